// SPDX-License-Identifier: Apache-2.0
// The coupled arm: friction that holds, stops, energy, brakes.
#include "arm.h"

#include "bench.h"
#include "check.h"
#include "contact.h"
#include "maths.h"

namespace {

using bench::run;
using mmcs::JointBounds;
using mmcs::Plant;

constexpr int kN = 6;

std::vector<double> angles(const Plant &plant) {
  std::vector<double> q;
  for (int i = 0; i < plant.axes(); ++i) q.push_back(plant.angle(i));
  return q;
}

}  // namespace

// Random problems; the answer must obey every rule of dry friction and of stops.
TEST(contact_solutions_obey_friction_and_stops) {
  uint64_t random = 11;
  const auto uniform = [&random](double lo, double hi) {
    return lo + (hi - lo) * mmcs::random_unit(random);
  };
  mmcs::ContactSolver solver(kN);
  int rests = 0;
  int stops = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    double root[kN][kN];
    double a[kN * kN] = {};
    double b[kN];
    double v[kN];
    double before[kN];
    JointBounds bounds[kN];
    for (auto &row : root) {
      for (double &x : row) x = uniform(-1, 1);
    }
    for (int i = 0; i < kN; ++i) {
      for (int j = 0; j < kN; ++j) {
        a[i * kN + j] = i == j ? 0.5 : 0.0;
        for (int k = 0; k < kN; ++k) a[i * kN + j] += root[i][k] * root[j][k];
      }
      b[i] = uniform(-3, 3);
      before[i] = v[i] = mmcs::random_bits(random) % 3 == 0 ? 0.0 : uniform(-2, 2);
      for (int side = 0; side < 2; ++side) {
        bounds[i].slide[side] = uniform(0, 1.5);
        bounds[i].stick[side] = bounds[i].slide[side] * uniform(1, 1.5);
      }
      bounds[i].speed_lo = -uniform(0, 3);
      bounds[i].speed_hi = uniform(0, 3);
    }
    solver.solve(a, b, bounds, v);
    for (int i = 0; i < kN; ++i) {
      double friction = -b[i];
      for (int k = 0; k < kN; ++k) friction += a[i * kN + k] * v[k];
      const JointBounds &j = bounds[i];
      const double *hold = before[i] == 0.0 ? j.stick : j.slide;
      constexpr double kTiny = 1e-12;
      bool good = v[i] >= j.speed_lo && v[i] <= j.speed_hi;
      if (v[i] == 0.0) {
        ++rests;
        good = good && friction >= -hold[0] - kTiny && friction <= hold[1] + kTiny;
      } else if (v[i] == j.speed_hi || v[i] == j.speed_lo) {
        ++stops;  // friction and the stop, both against the motion
        good =
            good && (v[i] > 0 ? friction <= -j.slide[0] + kTiny : friction >= j.slide[1] - kTiny);
      } else {
        const double want = v[i] > 0 ? -j.slide[0] : j.slide[1];
        good = good && std::abs(friction - want) < kTiny;
      }
      CHECK(good, "trial %d joint %d: speed %g, friction %g", trial, i, v[i], friction);
      if (check::failures > 5) return;
    }
  }
  CHECK(rests > 5000 && stops > 2000, "%d rests and %d stops are too few to prove much", rests,
        stops);
}

TEST(brakes_hold_what_friction_cannot) {
  auto motors = bench::puma_rotors();
  auto plant = bench::puma_arm(motors);
  const auto before = angles(*plant);
  run(*plant, 0.0, 10.0, false);
  CHECK(angles(*plant) == before, "the braked arm moved");
  run(*plant, 0.0, 0.2, true);
  CHECK(plant->angle(1) != before[1], "joint 2 does not fall with its brake open");
  run(*plant, 0.0, 1.0, false);
  for (int i = 0; i < 3; ++i) {
    CHECK(plant->velocity(i) == 0.0, "joint %d is not caught by its brake", i + 1);
  }
}

TEST(unpowered_arm_falls_to_rest) {
  auto motors = bench::puma_rotors();
  motors[1].angle0 = 0.0;
  auto plant = bench::puma_arm(motors);
  run(*plant, 0.0, 0.1);
  CHECK(plant->angle(1) < 0.0 && plant->angle(1) > -0.1, "joint 2 jumps to %g", plant->angle(1));
  run(*plant, 0.0, 4.9);
  const auto rest = angles(*plant);
  for (int i = 0; i < kN; ++i) {
    CHECK(rest[i] >= motors[i].stop_lo && rest[i] <= motors[i].stop_hi, "joint %d at %g", i + 1,
          rest[i]);
    CHECK(plant->velocity(i) == 0.0, "joint %d still moves", i + 1);
  }
  CHECK(rest[1] == motors[1].stop_lo, "joint 2 must lie on its stop, not at %g", rest[1]);
  run(*plant, 0.0, 5.0);
  CHECK(angles(*plant) == rest, "the fallen arm crept");
}

// What did not move is not calculated again: the bits are those of an arm that is placed anew.
TEST(links_that_stand_keep_their_place_to_the_bit) {
  uint64_t random = 29;
  for (int n = 1; n <= kN; ++n) {
    mmcs::Arm arm(robots::puma560_links, n, bench::kGravity);
    double q[kN] = {}, qd[kN] = {}, tau[2][kN], mass[2][kN * kN];
    for (int k = 0; k < 200; ++k) {
      const int moved = static_cast<int>(mmcs::random_unit(random) * (n + 1));
      for (int i = moved; i < n; ++i) {
        if (mmcs::random_unit(random) < 0.7) q[i] = 3.0 * mmcs::random_unit(random) - 1.5;
        qd[i] = mmcs::random_unit(random) - 0.5;
      }
      mmcs::Arm anew(robots::puma560_links, n, bench::kGravity);
      arm.pose(q);
      anew.pose(q);
      for (mmcs::Arm *each : {&arm, &anew}) {
        each->inverse_dynamics(qd, nullptr, tau[each == &arm]);
        each->mass_matrix(mass[each == &arm]);
      }
      const size_t size = static_cast<size_t>(n) * sizeof(double);
      CHECK(std::memcmp(tau[0], tau[1], size) == 0, "%d links: other torques", n);
      CHECK(std::memcmp(mass[0], mass[1], size * n) == 0, "%d links: another mass matrix", n);
      CHECK(arm.tip().x == anew.tip().x, "%d links: another tip", n);
    }
  }
}

TEST(energy_of_a_free_arm_is_kept) {
  const auto motors = bench::free_rotors();
  auto plant = bench::puma_arm(motors);
  mmcs::Arm arm(robots::puma560_links, kN, bench::kGravity);
  double potential = 0.0;  // by the work of gravity along the way
  double first = 0.0;
  double worst = 0.0;
  double most = 0.0;
  for (int k = 0; k < 40000; ++k) {
    const auto q = angles(*plant);
    double qd[kN];
    double tau[kN];
    double mass[kN * kN];
    for (int i = 0; i < kN; ++i) qd[i] = plant->velocity(i);
    arm.pose(q.data());
    arm.mass_matrix(mass);
    double kinetic = 0.0;
    for (int i = 0; i < kN; ++i) {
      mass[i * kN + i] += motors[i].gear * motors[i].gear * motors[i].inertia;
      for (int j = 0; j < kN; ++j) kinetic += 0.5 * qd[i] * mass[i * kN + j] * qd[j];
    }
    if (k == 0) first = kinetic + potential;
    worst = std::max(worst, std::abs(kinetic + potential - first));
    most = std::max(most, kinetic);
    const double rest[kN] = {};
    run(*plant, 0.0, bench::kStepS);
    double mid[kN];
    for (int i = 0; i < kN; ++i) mid[i] = 0.5 * (q[i] + plant->angle(i));
    arm.pose(mid);
    arm.inverse_dynamics(rest, nullptr, tau);
    for (int i = 0; i < kN; ++i) potential += tau[i] * (plant->angle(i) - q[i]);
  }
  CHECK(most > 10.0, "it hardly moves: %g J", most);
  CHECK(worst < 0.01 * most, "energy wanders by %g J of %g J", worst, most);
}
