// SPDX-License-Identifier: Apache-2.0
// The arm's dynamics as a filter, to be compared with another library: per line of stdin 6 angles,
// 6 speeds and 6 accelerations; per line of stdout 6 torques that these take, 36 elements of the
// mass matrix, 6 accelerations that those torques give in one step of the plant.
#include <cstdio>
#include <cstring>
#include <vector>

#include "arm.h"
#include "axis.h"
#include "bench.h"

namespace {

constexpr int kN = 6;

}  // namespace

int main() {
  const auto motors = bench::free_rotors();
  mmcs::Arm arm(robots::puma560_links, kN, bench::kGravity);
  auto plant = bench::puma_arm(motors);
  const int torque_input = bench::input("load_torque");

  double in[3 * kN];
  for (;;) {
    for (double &x : in) {
      if (std::scanf("%lf", &x) != 1) return 0;
    }
    double tau[kN];
    double mass[kN * kN];
    arm.pose(in);
    arm.inverse_dynamics(in + kN, in + 2 * kN, tau);
    arm.mass_matrix(mass);
    for (int i = 0; i < kN; ++i) {
      const double ratio = motors[i].gear * motors[i].gear;
      mass[i * kN + i] += ratio * motors[i].inertia;
      tau[i] += ratio * motors[i].inertia * in[2 * kN + i];
    }
    // One step of the plant from this state, under these torques.
    auto bytes = plant->save();
    for (int i = 0; i < kN; ++i) {
      mmcs::AxisState s;
      std::memcpy(&s, &bytes[i * sizeof s], sizeof s);
      s.q = in[i];
      s.qd = in[kN + i];
      s.theta = motors[i].gear * s.q;
      s.omega = motors[i].gear * s.qd;
      s.current = 0.0;
      std::memcpy(&bytes[i * sizeof s], &s, sizeof s);
    }
    plant->restore(bytes);
    for (int i = 0; i < kN; ++i) plant->set_input(torque_input, i, -tau[i] / motors[i].gear);
    const double off[kN] = {};
    std::vector<mmcs::PinEdge> edges;
    plant->step(off, true, true, edges);
    for (double x : tau) std::printf("%.17g ", x);
    for (double x : mass) std::printf("%.17g ", x);
    for (int i = 0; i < kN; ++i) {
      std::printf("%.17g ", (plant->velocity(i) - in[kN + i]) / bench::kStepS);
    }
    std::printf("\n");
  }
}
