// SPDX-License-Identifier: Apache-2.0
// One axis: amplifier, motor, friction, stops, brake, sensors. docs/simulator/plant.md has the
// equations.
#include "axis.h"

#include <algorithm>

#include "maths.h"

namespace mmcs {

namespace {

constexpr double kFullScaleVolts = 10.0;

EncoderFaults faults_of(const AxisState &s) {
  EncoderFaults f;
  constexpr AxisInput kCuts[] = {kEncoderACut, kEncoderBCut, kEncoderIndexCut};
  for (int w = 0; w < 3; ++w) {  // 0 sound, 1 stuck low, 2 stuck high
    const int cut = static_cast<int>(s.input[kCuts[w]]);
    if (cut != 0) f.cut |= 1u << w;
    if (cut == 2) f.high |= 1u << w;
  }
  f.swapped = s.input[kEncoderSwap] != 0.0;
  f.no_index = s.input[kIndexMissing] != 0.0;
  f.glitch_rate[0] = f.glitch_rate[1] = s.input[kEncoderGlitch];
  f.glitch_rate[2] = s.input[kIndexGlitch];
  return f;
}

[[gnu::noinline]] double noise(AxisState &s) {
  return s.input[kPotNoise] * random_normal(s.random);
}

int64_t steps_of(double seconds) {
  return floor_int(std::min(seconds / kStep, 1e15) + 0.5);
}

}  // namespace

Axis::Axis(const mmcs_motor &motor, int number, int clks_per_step, int min_gap)
    : m_(motor),
      encoder_(motor, number, clks_per_step, min_gap),
      amp_step_(motor.amp_tau > 0.0 ? 1.0 - exp_neg(kStep / motor.amp_tau) : 1.0),
      brake_on_steps_(steps_of(motor.brake_delay)),
      brake_off_steps_(steps_of(motor.brake_release_delay)),
      viscous_denominator_(motor.inertia / kStep + motor.viscous) {}

AxisState Axis::initial(uint64_t seed) const {
  AxisState s = {};
  s.q = m_.angle0;
  s.theta = m_.gear * m_.angle0;
  s.adc = m_.pot_offset + m_.pot_v_per_rad * s.q;
  s.brake_on = m_.brake_torque > 0.0 ? 1 : 0;
  s.random = seed;
  s.encoder = encoder_.initial(s.theta, ~seed);
  return s;
}

// The brake closes after brake_delay without supply and opens after brake_release_delay with it.
void Axis::step_brake(AxisState &s, bool release) const {
  if (release == (s.brake_on == 0)) {
    s.brake_steps = 0;
  } else if (++s.brake_steps >= (release ? brake_off_steps_ : brake_on_steps_)) {
    s.brake_on = release ? 0 : 1;
    s.brake_steps = 0;
  }
}

double Axis::drive(AxisState &s, double volts, bool brake_release, bool amp_enable) const {
  if (m_.brake_torque > 0.0) step_brake(s, brake_release);

  double target = m_.amp_gain * (volts + s.input[kDriveOffset]);
  double limit = kFullScaleVolts * m_.amp_gain;
  if (m_.amp_max > 0.0) {
    limit = m_.amp_max;
    target = std::clamp(target, -limit, limit);
  }
  if (s.input[kAmpSaturated] != 0.0) target = s.input[kAmpSaturated] > 0.0 ? limit : -limit;
  const bool live = amp_enable && s.input[kAmpDead] == 0.0;
  if (!live) target = 0.0;
  s.current += amp_step_ * (target - s.current);
  if (live && m_.v_supply > 0.0) {
    // The supply must carry back-EMF and winding: |km w + R i| <= V.
    const double emf = m_.km * s.omega;
    s.current = std::clamp(s.current, (-m_.v_supply - emf) / m_.resistance,
                           (m_.v_supply - emf) / m_.resistance);
  }
  return m_.km * s.current - s.input[kLoadTorque];
}

double Axis::extra_friction(const AxisState &s) const {
  if (s.input[kMotorJam] != 0.0) return kInfinity;
  const double stuck = s.input[kBrakeStuck];
  return stuck == 2.0 || (s.brake_on != 0 && stuck != 1.0) ? m_.brake_torque : 0.0;
}

Resistance Axis::resistance(double extra) const {
  return {{m_.stiction_pos + extra, m_.stiction_neg + extra},
          {m_.coulomb_pos + extra, m_.coulomb_neg + extra}};
}

double Axis::coupling(const AxisState &s) const {
  const double wind = s.theta / m_.gear - s.q;
  const double play = 0.5 * m_.backlash;
  if (wind >= -play && wind <= play) return 0.0;
  const double spring = m_.stiffness * (wind > 0.0 ? wind - play : wind + play);
  const double torque = spring + m_.damping * (s.omega / m_.gear - s.qd);
  // Teeth push, they never pull: damping must not turn the sign round.
  return m_.backlash > 0.0 && torque * spring < 0.0 ? 0.0 : torque;
}

// Backward Euler in speed with friction as a bounded impulse: friction takes whatever value within
// its bounds brings the shaft to rest, so that a held shaft has speed 0 exactly.
double Axis::motor_speed(const AxisState &s, double torque) const {
  const double push = m_.inertia / kStep * s.omega + torque;
  const Resistance r = resistance(extra_friction(s));
  const double *hold = s.omega == 0.0 ? r.stick : r.slide;
  if (push <= hold[0] && push >= -hold[1]) return 0.0;
  return (push > 0.0 ? push - r.slide[0] : push + r.slide[1]) / viscous_denominator_;
}

void Axis::move_joint(AxisState &s, double speed) const {
  const double bounded = stop_speed(s, speed);
  s.qd = bounded;
  if (bounded == 0.0) return;
  s.q += kStep * bounded;
  if (bounded != speed) s.q = speed > 0.0 ? m_.stop_hi : m_.stop_lo;
}

void Axis::step_alone(AxisState &s, double torque) const {
  if (flexible()) {
    const double twist = coupling(s);
    s.omega = motor_speed(s, torque - twist / m_.gear);
    s.theta += kStep * s.omega;
    const double pull = twist - m_.gravity * m_.gear;
    move_joint(s, s.qd + kStep / m_.load_inertia * pull);
    return;
  }
  const double speed = motor_speed(s, torque - m_.gravity);
  const double q_before = s.q;
  if (speed == 0.0) {
    s.omega = s.qd = 0.0;
    return;
  }
  move_joint(s, speed / m_.gear);
  if (s.qd == speed / m_.gear) {
    s.omega = speed;
    s.theta += kStep * speed;
    s.q = s.theta / m_.gear;
  } else {
    s.omega = s.qd * m_.gear;
    if (s.q != q_before) s.theta = s.q * m_.gear;
  }
}

void Axis::sense(AxisState &s, double theta_before, std::vector<PinEdge> &edges) const {
  double volts = m_.pot_offset + m_.pot_v_per_rad * s.q;
  if (s.input[kPotCut] != 0.0) volts = 0.0;
  if (s.input[kPotNoise] > 0.0) volts += noise(s);
  s.adc = std::clamp(volts, -kFullScaleVolts, kFullScaleVolts);
  static const EncoderFaults kSound;
  if (s.faulty != 0) {
    encoder_.step(s.encoder, faults_of(s), theta_before, s.theta, edges);
  } else {
    encoder_.step(s.encoder, kSound, theta_before, s.theta, edges);
  }
}

}  // namespace mmcs
