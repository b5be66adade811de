// SPDX-License-Identifier: Apache-2.0
// The physics behind the connectors: amplifiers, motors, arm, encoders, potentiometers, brakes.
//
// Pure C++17: no RTL, no files, no clock of its own. Advances in fixed steps of kStepUs; within a
// step the drive is constant, and every encoder transition of the step is reported with the clock
// at which it happens. Deterministic on every machine: no libm in the state path (sin and cos are
// our own polynomials; sqrt is exact by IEEE 754), built with -ffp-contract=off.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "mmcs_sim.h"

namespace mmcs {

inline constexpr int kStepUs = 50;

// New levels of one axis' encoder pins, `clk` clocks after the start of the step (0-based).
struct PinEdge {
  int32_t clk;
  uint8_t axis, a, b, i;
};

class Plant {
 public:
  // Throws std::invalid_argument with one sentence when a parameter is impossible.
  // clks_per_step: model clocks in kStepUs. min_gap: fewest clocks between two edges of one axis.
  static std::unique_ptr<Plant> create(const mmcs_config &config, const mmcs_motor *motors,
                                       const mmcs_link *links, int clks_per_step, int min_gap);
  virtual ~Plant() = default;

  virtual int axes() const = 0;
  // Advances one step. drive_v: one voltage per axis. brake_release: brakes powered open.
  // amp_enable: amplifiers on. edges is cleared, then filled in order of clk.
  virtual void step(const double *drive_v, bool brake_release, bool amp_enable,
                    std::vector<PinEdge> &edges) = 0;
  // Encoder pin levels now (bit 0 A, bit 1 B, bit 2 index).
  virtual uint8_t pins(int axis) const = 0;
  virtual double adc_volts(int axis) const = 0;  // potentiometer at the A/D input
  virtual double angle(int axis) const = 0;      // rad, joint
  virtual double velocity(int axis) const = 0;   // rad/s, joint
  virtual double current(int axis) const = 0;    // A
  virtual int32_t count(int axis) const = 0;     // edges up minus edges down since t = 0

  // Inputs and faults by name; the list is input_name(0..) until nullptr.
  static const char *input_name(int input);
  virtual void set_input(int input, int index, double value) = 0;

  // Everything that changes, as bytes; restoring gives a bit-identical future.
  virtual std::vector<uint8_t> save() const = 0;
  virtual void restore(const std::vector<uint8_t> &state) = 0;
};

}  // namespace mmcs
