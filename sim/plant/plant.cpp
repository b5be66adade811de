// SPDX-License-Identifier: Apache-2.0
// The plant: axes that stand alone, or axes that move an arm. docs/simulator/plant.md
#include "plant.h"

#include <cstring>
#include <stdexcept>

#include "arm.h"
#include "axis.h"
#include "contact.h"
#include "maths.h"

namespace mmcs {

namespace {

constexpr const char *kInputNames[kAxisInputs] = {
#define PLANT(input, name, ...) name,
#include "inputs.def"
};

bool is_encoder_input(int input) {
  return input <= kIndexMissing;
}

class AxesPlant : public Plant {
 public:
  AxesPlant(const mmcs_config &config, const mmcs_motor *motors, int clks_per_step, int min_gap)
      : edges_per_step_(static_cast<size_t>(config.axes) *
                        static_cast<size_t>(clks_per_step / min_gap + 1)),
        before_(static_cast<size_t>(config.axes)),
        torque_(static_cast<size_t>(config.axes)) {
    uint64_t seed = config.seed;
    for (int i = 0; i < config.axes; ++i) {
      axis_.emplace_back(motors[i], i, clks_per_step, min_gap);
      state_.push_back(axis_.back().initial(random_bits(seed)));
    }
  }

  int axes() const override { return static_cast<int>(axis_.size()); }

  void step(const double *drive_v, bool brake_release, bool amp_enable,
            std::vector<PinEdge> &edges) override {
    edges.clear();
    if (edges.capacity() < edges_per_step_) edges.reserve(edges_per_step_);
    const size_t n = axis_.size();
    const Axis *const axis = axis_.data();
    AxisState *const state = state_.data();
    double *const before = before_.data(), *const torque = torque_.data();
    for (size_t i = 0; i < n; ++i) {
      before[i] = state[i].theta;
      torque[i] = axis[i].drive(state[i], drive_v[i], brake_release, amp_enable);
    }
    move();
    for (size_t i = 0; i < n; ++i) axis[i].sense(state[i], before[i], edges);
  }

  uint8_t pins(int axis) const override { return static_cast<uint8_t>(at(axis).encoder.pins); }
  double adc_volts(int axis) const override { return at(axis).adc; }
  double angle(int axis) const override { return at(axis).q; }
  double velocity(int axis) const override { return at(axis).qd; }
  double current(int axis) const override { return at(axis).current; }
  int32_t count(int axis) const override {
    const EncoderState &e = at(axis).encoder;
    return static_cast<int32_t>(e.state - e.start);
  }

  void set_input(int input, int index, double value) override {
    if (input < 0 || input >= kAxisInputs)
      throw std::invalid_argument("the plant has no such input");
    if (index < -1 || index >= axes()) {
      throw std::invalid_argument(std::string(kInputNames[input]) + ": axis must be 0 to " +
                                  std::to_string(axes() - 1) + ", or -1 for all");
    }
    for (int i = 0; i < axes(); ++i) {
      if (index != -1 && index != i) continue;
      AxisState &s = state_[static_cast<size_t>(i)];
      s.input[input] = value;
      if (input == kEncoderSlip) s.encoder.slip = value;
      if (!is_encoder_input(input)) continue;
      s.encoder.refresh = 1;
      s.faulty = 0;
      for (int k = 0; k < kAxisInputs; ++k) {
        if (is_encoder_input(k) && s.input[k] != 0.0) s.faulty = 1;
      }
    }
  }

  std::vector<uint8_t> save() const override {
    std::vector<uint8_t> bytes(state_.size() * sizeof(AxisState));
    std::memcpy(bytes.data(), state_.data(), bytes.size());
    return bytes;
  }
  void restore(const std::vector<uint8_t> &bytes) override {
    if (bytes.size() != state_.size() * sizeof(AxisState)) {
      throw std::invalid_argument("this plant state belongs to another machine");
    }
    std::memcpy(state_.data(), bytes.data(), bytes.size());
  }

 protected:
  virtual void move() {
    for (size_t i = 0; i < axis_.size(); ++i) axis_[i].step_alone(state_[i], torque_[i]);
  }

  const AxisState &at(int axis) const { return state_[static_cast<size_t>(axis)]; }

  size_t edges_per_step_;
  std::vector<Axis> axis_;
  std::vector<AxisState> state_;
  std::vector<double> before_;  // motor angles before the step
  std::vector<double> torque_;  // on the shafts, without friction
};

// Rigid axes move with the arm: their rotor, friction and brake act at the joint through the gear.
// Flexible axes have a shaft of their own, and only the coupling's torque reaches the arm.
class ArmPlant final : public AxesPlant {
 public:
  ArmPlant(const mmcs_config &config, const mmcs_motor *motors, const mmcs_link *links,
           int clks_per_step, int min_gap)
      : AxesPlant(config, motors, clks_per_step, min_gap),
        arm_(links, config.links, config.gravity),
        solver_(config.links),
        joint_(axis_.size()),
        mass_(axis_.size() * axis_.size() + 1),  // may be read as pairs
        q_(axis_.size()),
        qd_(axis_.size()),
        tau_(axis_.size()),
        momentum_(axis_.size() + 1),
        next_(axis_.size()),
        bounds_(axis_.size()) {
    for (size_t i = 0; i < axis_.size(); ++i) {
      const mmcs_motor &m = axis_[i].motor();
      if (axis_[i].flexible()) continue;
      joint_[i].rotor = m.gear * m.gear * m.inertia;
      joint_[i].viscous = kStep * m.gear * m.gear * m.viscous;
      joint_[i].extra = -1.0;
    }
  }

 protected:
  void move() override {
    const size_t n = axis_.size();
    double *const mass = mass_.data();
    calculate_arm();
    // Impulses: (M + h B) v' = M v + h (torque - bias) + friction. Rotor inertia counts in M.
    for (size_t i = 0; i < n; ++i) {
      mass[i * n + i] = joint_[i].inertia;
      momentum_[i] = kStep * (joint_torque(i) - tau_[i]);
    }
    for (size_t i = 0; i < n; i += 2) {  // M is symmetric: two rows, by columns
      Two sum = load(&momentum_[i]);
      for (size_t k = 0; k < n; ++k) sum += load(mass + k * n + i) * qd_[k];
      std::memcpy(&momentum_[i], &sum, sizeof sum);
    }
    for (size_t i = 0; i < n; ++i) {
      mass[i * n + i] += joint_[i].viscous;
      set_bounds(i);
    }
    solver_.solve(mass, momentum_.data(), bounds_.data(), next_.data());
    for (size_t i = 0; i < n; ++i) move_joint(i);
  }

 private:
  struct Joint {
    double rotor, viscous;  // at the joint, of a rigid axis: inertia; what brakes in a step
    double inertia;         // with the arm's
    double extra;           // friction that the bounds are of
  };

  static Two load(const double *two) {
    Two out;
    std::memcpy(&out, two, sizeof out);
    return out;
  }

  // Mass matrix and torques of the arm, which stand as long as the arm does.
  void calculate_arm() {
    const size_t n = axis_.size();
    for (size_t i = 0; i < n; ++i) {
      q_[i] = state_[i].q;
      next_[i] = state_[i].qd;
    }
    const bool turns = std::memcmp(next_.data(), qd_.data(), n * sizeof(double)) != 0;
    const bool moved = arm_.pose(q_.data());
    if (moved) {
      arm_.mass_matrix(mass_.data());
      for (size_t i = 0; i < n; ++i) joint_[i].inertia = mass_[i * n + i] + joint_[i].rotor;
    }
    if (!moved && !turns) return;
    qd_ = next_;
    arm_.inverse_dynamics(qd_.data(), nullptr, tau_.data());
  }

  // Steps the shaft of a flexible axis on its way.
  double joint_torque(size_t i) {
    const Axis &axis = axis_[i];
    AxisState &s = state_[i];
    if (!axis.flexible()) return axis.motor().gear * torque_[i];
    const double twist = axis.coupling(s);
    s.omega = axis.motor_speed(s, torque_[i] - twist / axis.motor().gear);
    s.theta += kStep * s.omega;
    return twist;
  }

  void set_bounds(size_t i) {
    const Axis &axis = axis_[i];
    const AxisState &s = state_[i];
    JointBounds &b = bounds_[i];
    b.speed_lo = axis.stop_speed(s, -kFastest);
    b.speed_hi = axis.stop_speed(s, kFastest);
    if (axis.flexible()) return;
    const double extra = axis.extra_friction(s);
    if (extra == joint_[i].extra) return;
    joint_[i].extra = extra;
    const double gear = axis.motor().gear;
    const double scale = kStep * (gear > 0.0 ? gear : -gear);
    const Resistance r = axis.resistance(extra);
    for (int side = 0; side < 2; ++side) {
      const int motor_side = gear > 0.0 ? side : 1 - side;
      b.stick[side] = scale * r.stick[motor_side];
      b.slide[side] = scale * r.slide[motor_side];
    }
  }

  void move_joint(size_t i) {
    const Axis &axis = axis_[i];
    AxisState &s = state_[i];
    const mmcs_motor &m = axis.motor();
    s.qd = next_[i];
    if (s.qd == 0.0) {
      if (!axis.flexible()) s.omega = 0.0;
      return;
    }
    s.q += kStep * s.qd;
    if (m.stop_lo < m.stop_hi) {
      if (s.qd == bounds_[i].speed_hi) s.q = m.stop_hi;
      if (s.qd == bounds_[i].speed_lo) s.q = m.stop_lo;
    }
    if (axis.flexible()) return;
    s.omega = m.gear * s.qd;
    s.theta = m.gear * s.q;
  }

  static constexpr double kFastest = 1e6;  // rad/s; no joint is faster, with or without stops

  Arm arm_;
  ContactSolver solver_;
  std::vector<Joint> joint_;
  std::vector<double> mass_, q_, qd_, tau_;  // of the arm as it stood last
  std::vector<double> momentum_, next_;
  std::vector<JointBounds> bounds_;
};

}  // namespace

std::unique_ptr<Plant> Plant::create(const mmcs_config &config, const mmcs_motor *motors,
                                     const mmcs_link *links, int clks_per_step, int min_gap) {
  if (config.links == 0) {
    return std::make_unique<AxesPlant>(config, motors, clks_per_step, min_gap);
  }
  return std::make_unique<ArmPlant>(config, motors, links, clks_per_step, min_gap);
}

const char *Plant::input_name(int input) {
  return input >= 0 && input < kAxisInputs ? kInputNames[input] : nullptr;
}

}  // namespace mmcs
