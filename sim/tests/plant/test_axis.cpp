// SPDX-License-Identifier: Apache-2.0
// Amplifier, friction, brake, stops, coupling and their faults on axes that stand alone.
#include <stdexcept>

#include "bench.h"
#include "check.h"

namespace {

using bench::ideal;
using bench::input;
using bench::run;
using mmcs::PinEdge;
using mmcs::Plant;

// A load on a spring behind a gear, with play; 0.01 kg m^2 of the motor at the joint.
mmcs_motor sprung(double damping, double backlash = 0.02) {
  mmcs_motor m = ideal();
  m.gear = 10.0;
  m.load_inertia = 0.03;
  m.stiffness = 100.0;
  m.damping = damping;
  m.backlash = backlash;
  return m;
}

double current(const Plant &p) {
  return p.current(0);
}
double speed(const Plant &p) {
  return p.velocity(0);
}

void held(mmcs_motor &m) {  // no back-EMF
  m.stiction_pos = m.stiction_neg = 10.0;
}
void rubs(mmcs_motor &m) {
  m.coulomb_pos = m.stiction_pos = 0.05;
  m.coulomb_neg = m.stiction_neg = 0.02;
}
void braked(mmcs_motor &m) {
  m.brake_torque = 1.0;
  m.gravity = 0.1;
}

// An ideal motor with one change, one input at one value, so many volts for so many seconds: what
// is seen then. 0.1 N m are 1000 rad/s^2.
struct Row {
  const char *what;
  void (*change)(mmcs_motor &);
  const char *input;  // or null
  double value, volts, seconds;
  bool released, enabled;  // the brake, the amplifier
  double (*seen)(const Plant &);
  double want, within;
};

constexpr bool kOn = true, kOff = false;
const Row kRows[] = {
    {"lag of the amplifier", [](mmcs_motor &m) { held(m), m.amp_tau = 1e-3; }, nullptr, 0, 4, 1e-3,
     kOn, kOn, current, 2.0 * (1.0 - std::exp(-1.0)), 1e-12},
    {"no lag", held, nullptr, 0, 4, 50e-6, kOn, kOn, current, 2, 0},
    {"limit", [](mmcs_motor &m) { held(m), m.amp_max = 1.5; }, nullptr, 0, 10, 1e-3, kOn, kOn,
     current, 1.5, 0},
    {"limit, backward", [](mmcs_motor &m) { held(m), m.amp_max = 1.5; }, nullptr, 0, -10, 1e-3, kOn,
     kOn, current, -1.5, 0},
    {"limit by the supply", [](mmcs_motor &m) { held(m), m.v_supply = 0.75; }, nullptr, 0, 10, 1e-3,
     kOn, kOn, current, 0.75, 0},
    {"dead amplifier", held, "amp_dead", 1, 5, 0.1, kOn, kOn, current, 0, 0},
    {"saturated amplifier", [](mmcs_motor &m) { m.amp_max = 2; }, "amp_saturated", -1, 5, 0.1, kOn,
     kOn, current, -2, 0},
    {"disabled amplifier", held, nullptr, 0, 5, 0.001, kOn, kOff, current, 0, 0},
    {"offset of the drive", held, "drive_offset", 0.5, 0, 0.001, kOn, kOn, current, 0.25, 0},
    {"free acceleration", nullptr, nullptr, 0, 1, 0.1, kOn, kOn, speed, 50, 5e-8},
    {"end by viscous friction", [](mmcs_motor &m) { m.viscous = 1e-3; }, nullptr, 0, 1, 5, kOn, kOn,
     speed, 50, 1e-6},
    {"friction forward", rubs, nullptr, 0, 2, 0.1, kOn, kOn, speed, 50, 1e-6},
    {"friction backward", rubs, nullptr, 0, -2, 0.1, kOn, kOn, speed, -80, 1e-6},
    {"brake stuck open", braked, "brake_stuck", 1, 0, 0.1, kOff, kOn, speed, -100, 1e-6},
    {"brake stuck closed", braked, "brake_stuck", 2, 5, 0.1, kOn, kOn, speed, 0, 0},
    {"load that holds it", nullptr, "load_torque", 0.05, 1, 0.1, kOn, kOn, speed, 0, 0},
    {"load that it lifts", nullptr, "load_torque", 0.05, 2, 0.1, kOn, kOn, speed, 50, 1e-6},
    {"jam", nullptr, "motor_jam", 1, 5, 0.1, kOn, kOn, speed, 0, 0},
};

}  // namespace

TEST(motor_of_the_textbook_and_its_faults) {
  for (const Row &row : kRows) {
    mmcs_motor m = ideal();
    if (row.change != nullptr) row.change(m);
    auto plant = bench::alone(m);
    if (row.input != nullptr) plant->set_input(input(row.input), 0, row.value);
    run(*plant, row.volts, row.seconds, row.released, row.enabled);
    const double got = row.seen(*plant);
    CHECK(std::abs(got - row.want) <= row.within, "%s: %.15g, want %.15g", row.what, got, row.want);
  }
}

TEST(signs_from_drive_to_counter) {
  auto plant = bench::alone(ideal());
  bench::Counter counter(*plant);
  std::vector<PinEdge> edges;
  const double volts = 1.0;
  for (int k = 0; k < 200; ++k) {
    plant->step(&volts, true, true, edges);
    counter.take(edges);
  }
  CHECK(plant->current(0) > 0 && plant->velocity(0) > 0, "positive drive must turn positive");
  CHECK(counter.count(0) > 0, "A must lead B while turning positive");
  mmcs_motor reversed = ideal();
  reversed.gear = -50.0;
  auto back = bench::alone(reversed);
  run(*back, 1.0, 0.01);
  CHECK(back->count(0) > 0 && back->angle(0) < 0, "a negative gear turns the joint back");
}

TEST(maximum_speeds) {
  const double want[6] = {120, 163, 129, 406, 366, 440};
  for (int i = 0; i < 6; ++i) {
    mmcs_motor m = robots::puma560[i];
    m.stop_lo = m.stop_hi = 0.0;
    auto plant = bench::alone(m);
    run(*plant, 10.0, 3.0);
    const double w = plant->velocity(0) * m.gear;
    CHECK(std::abs(w - want[i]) < 0.03 * want[i], "J%d: %g rad/s, want %g", i + 1, w, want[i]);
  }
}

TEST(stick_holds_bit_for_bit_and_breaks_at_its_bound) {
  mmcs_motor m = robots::puma560[1];
  m.brake_torque = 0.0;
  for (const double load : {0.07, -0.12}) {  // just below the friction against it
    m.gravity = load;
    auto plant = bench::alone(m);
    const double q = plant->angle(0);
    run(*plant, 0.0, 10.0);
    CHECK(plant->angle(0) == q && plant->count(0) == 0, "crept by %g rad", plant->angle(0) - q);
  }

  const double lsb = m.km * m.amp_gain;  // N m per V
  m.gravity = 0.0;
  auto held = bench::alone(m);
  run(*held, 0.999 * m.stiction_pos / lsb, 1.0);
  CHECK(held->velocity(0) == 0.0, "breaks away too early");
  run(*held, 1.001 * m.stiction_pos / lsb, 1.0);
  CHECK(held->velocity(0) > 0.0, "does not break away");
  // Moving, it needs only the Coulomb torque to go on.
  run(*held, 0.5 * (m.stiction_pos + m.coulomb_pos) / lsb, 0.5);
  CHECK(held->velocity(0) > 0.0, "stiction acts on a moving shaft");
  run(*held, 0.0, 0.5);
  CHECK(held->velocity(0) == 0.0, "friction does not stop it");
}

TEST(brake_holds_releases_and_engages_late) {
  mmcs_motor m = ideal();
  m.brake_torque = 1.0;
  m.brake_delay = 0.030;
  m.brake_release_delay = 0.01004;  // 201 steps
  m.gravity = 0.1;
  auto plant = bench::alone(m);
  run(*plant, 0.0, 1.0, false);
  CHECK(plant->angle(0) == 0.0, "a brake without power must hold");
  run(*plant, 0.0, 0.01, true);
  CHECK(plant->angle(0) == 0.0, "released too early");
  run(*plant, 0.0, 0.0002, true);
  CHECK(plant->velocity(0) < 0.0, "not released");
  run(*plant, 0.0, 0.0299, false);
  const double w = plant->velocity(0);
  run(*plant, 0.0, 0.0002, false);
  CHECK(plant->velocity(0) > w, "not engaged after its delay");
  run(*plant, 0.0, 0.5, false);
  CHECK(plant->velocity(0) == 0.0, "does not stop the axis");
}

TEST(stops_end_the_motion_exactly) {
  for (const double gear : {20.0, -20.0}) {
    mmcs_motor m = ideal();
    m.gear = gear;
    m.stop_lo = -0.3;
    m.stop_hi = 0.7;
    for (const double volts : {8.0, -8.0}) {
      auto plant = bench::alone(m);
      const double end = volts * gear > 0 ? m.stop_hi : m.stop_lo;
      run(*plant, volts, 1.0);
      CHECK(plant->angle(0) == end && plant->velocity(0) == 0.0, "at %.17g, want %g",
            plant->angle(0), end);
      run(*plant, -volts, 0.02);
      CHECK(plant->angle(0) != end, "does not leave the stop");
    }
  }
}

TEST(potentiometer_noise_and_cut) {
  mmcs_motor m = ideal();
  m.pot_v_per_rad = 2.0;
  m.pot_offset = 1.0;
  m.angle0 = 1.5;
  m.stiction_pos = m.stiction_neg = 1.0;
  auto plant = bench::alone(m);
  CHECK(plant->adc_volts(0) == 4.0, "%g V", plant->adc_volts(0));
  plant->set_input(input("pot_noise"), 0, 0.1);
  double sum = 0.0;
  double squares = 0.0;
  constexpr int kSamples = 20000;
  for (int k = 0; k < kSamples; ++k) {
    run(*plant, 0.0, bench::kStepS);
    sum += plant->adc_volts(0) - 4.0;
    squares += std::pow(plant->adc_volts(0) - 4.0, 2);
  }
  CHECK(std::abs(sum / kSamples) < 0.004, "mean %g V", sum / kSamples);
  CHECK(std::abs(std::sqrt(squares / kSamples) - 0.1) < 0.004, "%g V rms",
        std::sqrt(squares / kSamples));
  plant->set_input(input("pot_cut"), 0, 1.0);
  plant->set_input(input("pot_noise"), 0, 0.0);
  run(*plant, 0.0, bench::kStepS);
  CHECK(plant->adc_volts(0) == 0.0, "%g V", plant->adc_volts(0));
}

// A load on a spring: the two masses swing with the frequency of the textbook, about their mean.
TEST(flexible_coupling_swings) {
  auto plant = bench::alone(sprung(0.0, 0.0));
  run(*plant, 1.0, 0.05);
  double last = plant->velocity(0);
  const double mean_acc = 0.05 * 10.0 / 0.04;
  int crossings = 0;
  std::vector<double> at;
  for (int k = 0; k < 20000; ++k) {
    run(*plant, 1.0, bench::kStepS);
    const double acc = (plant->velocity(0) - last) / bench::kStepS - mean_acc;
    static double before = acc;
    if (before < 0 && acc >= 0) at.push_back(k * bench::kStepS), ++crossings;
    before = acc;
    last = plant->velocity(0);
  }
  const double period = (at.back() - at.front()) / (crossings - 1);
  const double want = 2 * M_PI / std::sqrt(100.0 * (1 / 0.03 + 1 / 0.01));
  CHECK(std::abs(period - want) < 0.005 * want, "period %g s, want %g", period, want);
}

TEST(backlash_lets_the_motor_turn_alone) {
  auto plant = bench::alone(sprung(0.1));  // 0.2 rad at the motor, half of it ahead: 15.9 counts
  std::vector<PinEdge> edges;
  const double volts = 0.2;
  while (plant->angle(0) == 0.0) plant->step(&volts, true, true, edges);
  CHECK(std::abs(plant->count(0) - 16) <= 1, "load follows after %d counts", plant->count(0));
}

// Pushed against a stop, the spring winds up by half the play and the torque over the stiffness.
TEST(backlash_and_spring_at_a_stop) {
  mmcs_motor m = sprung(0.2);
  m.viscous = 1e-3;
  m.stop_lo = -1.0;
  for (const double volts : {2.0, -2.0}) {
    m.angle0 = volts > 0 ? m.stop_hi : m.stop_lo;
    auto plant = bench::alone(m);
    run(*plant, volts, 5.0);
    const double torque = volts * 0.5 * 0.1 * 10.0;  // at the joint
    const double wind = torque / 100.0 + (volts > 0 ? 0.01 : -0.01);
    const int want = static_cast<int>(std::lround(wind * 10.0 * 1000 / (2 * M_PI)));
    CHECK(plant->angle(0) == m.angle0, "the load left its stop");
    CHECK(std::abs(plant->count(0) - want) <= 1, "wound up by %d counts, want %d", plant->count(0),
          want);
  }
}

// While the motor is ahead its teeth push the load or leave it alone, also while it turns round.
TEST(backlash_never_pulls) {
  const mmcs_motor m = sprung(1.0);
  auto plant = bench::alone(m);
  std::vector<PinEdge> edges;
  int ahead = 0;
  for (int step = 0; step < 4000; ++step) {
    const double volts = step < 2000 ? 1.0 : -10.0, speed = plant->velocity(0);
    const bool pushes = plant->count(0) * 2 * M_PI / 1000 / m.gear > plant->angle(0) + 1e-3;
    plant->step(&volts, true, true, edges);
    if (!pushes) continue;
    CHECK(plant->velocity(0) >= speed, "pulled from %g to %g rad/s at step %d", speed,
          plant->velocity(0), step);
    ahead += step > 2000;
  }
  CHECK(ahead > 10, "it turned round away from the teeth");
}

TEST(saved_state_has_the_same_future) {
  mmcs_motor motors[2] = {robots::puma560[1], robots::lab500[0]};
  motors[0].stiffness = 3000.0;
  motors[0].load_inertia = 2.0;
  const auto make = [&] {
    auto p = Plant::create(bench::config(2, 0, 7), motors, nullptr, bench::kClks, bench::kGap);
    p->set_input(input("pot_noise"), -1, 0.01);
    p->set_input(input("encoder_glitch"), -1, 500.0);
    return p;
  };
  auto a = make();
  run(*a, 3.0, 0.05);
  const auto saved = a->save();
  auto b = Plant::create(bench::config(2, 0, 99), motors, nullptr, bench::kClks, bench::kGap);
  b->restore(saved);
  const double volts[2] = {-2.0, 4.0};
  std::vector<PinEdge> ea;
  std::vector<PinEdge> eb;
  for (int k = 0; k < 2000; ++k) {
    a->step(volts, k < 1000, true, ea);
    b->step(volts, k < 1000, true, eb);
    bool same = ea.size() == eb.size();
    for (size_t i = 0; same && i < ea.size(); ++i) {
      same = ea[i].clk == eb[i].clk && ea[i].axis == eb[i].axis && ea[i].a == eb[i].a;
    }
    CHECK(same, "edges differ in step %d", k);
    if (!same) return;
  }
  CHECK(a->save() == b->save(), "states differ");
  for (int wrong = 0; wrong < 3; ++wrong) {
    try {
      wrong == 0 ? b->restore({1, 2, 3}) : b->set_input(input("pot_cut"), 2 - 4 * (wrong - 1), 1);
      CHECK(false, "takes a state of another size, or an input of an axis that is not there");
    } catch (const std::invalid_argument &) {
    }
  }
}
