// SPDX-License-Identifier: Apache-2.0
// What every axis has whatever it carries: amplifier, friction, brake, potentiometer, encoder.
#pragma once

#include <cstdint>
#include <vector>

#include "encoder.h"
#include "plant.h"

namespace mmcs {

inline constexpr double kStep = kStepUs * 1e-6;

// The inputs, in the order of the table.
enum AxisInput {
#define PLANT(input, ...) input,
#include "inputs.def"
  kAxisInputs
};

// Members of eight bytes only: no padding, comparable by bytes.
struct AxisState {
  double theta;    // rad, motor
  double omega;    // rad/s, motor
  double q;        // rad, joint
  double qd;       // rad/s, joint
  double current;  // A
  double adc;      // V
  int64_t brake_on;
  int64_t brake_steps;  // steps since the brake's supply differs from brake_on
  int64_t faulty;       // 1: an input of the encoder is not 0
  uint64_t random;
  EncoderState encoder;
  double input[kAxisInputs];
};

// Bounds of the resisting torque at the motor. Breaking away needs more than `stick`; a moving
// shaft is resisted by `slide`. [0] against positive turning, [1] against negative.
struct Resistance {
  double stick[2];
  double slide[2];
};

class Axis {
 public:
  Axis(const mmcs_motor &motor, int number, int clks_per_step, int min_gap);

  AxisState initial(uint64_t seed) const;
  const mmcs_motor &motor() const { return m_; }
  bool flexible() const { return m_.stiffness > 0.0; }

  // The first half of a step: current, brake. Returns the torque on the shaft but for friction.
  double drive(AxisState &s, double volts, bool brake_release, bool amp_enable) const;
  // What the brake adds to the friction of the motor: nothing, its torque, or more than anything.
  double extra_friction(const AxisState &s) const;
  Resistance resistance(double extra) const;
  // Coupling torque at the joint, positive when the motor is ahead of the load.
  double coupling(const AxisState &s) const;
  // Speed of the motor after one step under this torque, without a stop: friction decides.
  double motor_speed(const AxisState &s, double torque) const;
  // The joint speed that would take the joint exactly to its stop, when `speed` goes beyond it.
  double stop_speed(const AxisState &s, double speed) const {
    if (m_.stop_lo >= m_.stop_hi) return speed;
    const double next = s.q + kStep * speed;
    if (next > m_.stop_hi) return (m_.stop_hi - s.q) / kStep;
    if (next < m_.stop_lo) return (m_.stop_lo - s.q) / kStep;
    return speed;
  }
  // The same bounded at the stops, then the new position; lands on the stop bit for bit.
  void move_joint(AxisState &s, double speed) const;
  // A whole step of an axis that stands alone.
  void step_alone(AxisState &s, double torque) const;
  // The second half: potentiometer, encoder.
  void sense(AxisState &s, double theta_before, std::vector<PinEdge> &edges) const;

 private:
  void step_brake(AxisState &s, bool release) const;

  mmcs_motor m_;
  Encoder encoder_;
  double amp_step_;         // share of the way to the demand that the current goes in a step
  int64_t brake_on_steps_;  // delays in steps
  int64_t brake_off_steps_;
  double viscous_denominator_;  // inertia / h + viscous
};

}  // namespace mmcs
