// SPDX-License-Identifier: Apache-2.0
// What the plant's tests share: machines made from the robot files.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "plant.h"
#include "robots.h"  // generated from sim/robots/*.toml

namespace bench {

inline constexpr int kClks = 400;  // 8 MHz
inline constexpr int kGap = 2;
inline constexpr double kStepS = mmcs::kStepUs * 1e-6;
inline constexpr double kGravity[3] = {0.0, 0.0, -9.81};

inline mmcs_config config(int axes, int links = 0, uint64_t seed = 1) {
  mmcs_config c = {};
  c.cards = (axes + 1) / 2;
  c.axes = axes;
  c.links = links;
  c.seed = seed;
  c.gravity[2] = links != 0 ? -9.81 : 0.0;
  return c;
}

inline std::unique_ptr<mmcs::Plant> alone(const mmcs_motor &motor, uint64_t seed = 1) {
  return mmcs::Plant::create(config(1, 0, seed), &motor, nullptr, kClks, kGap);
}

inline std::unique_ptr<mmcs::Plant> puma_arm(std::vector<mmcs_motor> motors, bool gravity = true) {
  mmcs_config c = config(6, 6);
  if (!gravity) c.gravity[2] = 0.0;
  return mmcs::Plant::create(c, motors.data(), robots::puma560_links, kClks, kGap);
}

// The six motors with their rotors alone, as the arm wants them.
inline std::vector<mmcs_motor> puma_rotors() {
  std::vector<mmcs_motor> m(robots::puma560, robots::puma560 + 6);
  for (int i = 0; i < 6; ++i) m[i].inertia = robots::puma560_rotor_inertia[i];
  return m;
}

// The same without friction, limits or stops: only rotor and gear are left.
inline std::vector<mmcs_motor> free_rotors() {
  auto motors = puma_rotors();
  for (mmcs_motor &m : motors) {
    m.viscous = m.coulomb_pos = m.coulomb_neg = m.stiction_pos = m.stiction_neg = 0.0;
    m.stop_lo = m.stop_hi = m.v_supply = m.brake_torque = 0.0;
  }
  return motors;
}

// A motor without friction or limits, to see one effect at a time.
inline mmcs_motor ideal() {
  mmcs_motor m = {};
  m.inertia = 1e-4;
  m.km = 0.1;
  m.resistance = 1.0;
  m.amp_gain = 0.5;
  m.gear = 1.0;
  m.counts_per_rev = 1000;
  m.index_per_rev = 1;
  return m;
}

// The number of an input of the plant.
inline int input(const std::string &name) {
  for (int i = 0; mmcs::Plant::input_name(i) != nullptr; ++i)
    if (name == mmcs::Plant::input_name(i)) return i;
  throw std::invalid_argument("no input is called " + name);
}

// So many seconds, with the same voltage on every axis.
inline void run(mmcs::Plant &plant, double volts, double seconds, bool release = true,
                bool enable = true) {
  const std::vector<double> drive(static_cast<size_t>(plant.axes()), volts);
  std::vector<mmcs::PinEdge> edges;
  for (int k = 0; k < std::lround(seconds / kStepS); ++k) {
    plant.step(drive.data(), release, enable, edges);
  }
}

// Decodes the pins as a counter would, and checks the order of edges on the way.
class Counter {
 public:
  explicit Counter(const mmcs::Plant &plant) {
    for (int i = 0; i < plant.axes(); ++i) pins_.push_back(plant.pins(i));
    count_.resize(pins_.size());
    index_at_.resize(pins_.size());
  }
  void take(const std::vector<mmcs::PinEdge> &edges) {
    int32_t last = 0;
    for (const auto &e : edges) {
      if (e.clk < last || e.clk < 0 || e.clk >= kClks) bad_order_ = true;
      last = e.clk;
      uint8_t &pins = pins_[e.axis];
      const int now = e.a + 2 * e.b;
      const int turn = (kPhase[now] - kPhase[pins & 3]) & 3;
      if (turn == 2) both_changed_ = true;
      count_[e.axis] += turn == 1 ? 1 : turn == 3 ? -1 : 0;
      if (e.i != 0 && (pins & 4) == 0) index_at_[e.axis].push_back(count_[e.axis]);
      pins = static_cast<uint8_t>(now + 4 * e.i);
    }
  }
  int count(int axis) const { return count_[axis]; }
  uint8_t pins(int axis) const { return pins_[axis]; }
  const std::vector<int> &index_at(int axis) const { return index_at_[axis]; }
  bool bad_order_ = false;
  bool both_changed_ = false;

 private:
  static constexpr int kPhase[4] = {0, 1, 3, 2};  // A first, then both, then B
  std::vector<uint8_t> pins_;
  std::vector<int> count_;
  std::vector<std::vector<int>> index_at_;
};

}  // namespace bench
