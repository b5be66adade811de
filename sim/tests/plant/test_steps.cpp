// SPDX-License-Identifier: Apache-2.0
// Step responses of single axes against reference figures: the motor numbers are proven before any
// logic is attached to them.
#include "bench.h"
#include "check.h"

namespace {

// Rise 10-90 % in ms (-1: 90 % is never reached) and overshoot in %, for Coulomb compensation of
// 0, 0.8 and 1.0 of the friction; computed with an independent model of the same equations.
struct Case {
  int step;
  double rise[3], overshoot[3];
};

constexpr double kCompensation[3] = {0.0, 0.8, 1.0};

void run(const char *name, const mmcs_motor &m, int ms, int a0, int a1, const Case &c,
         int variant) {
  const double lsb = m.km * m.amp_gain * bench::kLsb;
  const double share = kCompensation[variant];
  const bench::Law law = {a0,
                          a1,
                          64,
                          1024,
                          static_cast<int>(share * m.coulomb_pos / lsb),
                          static_cast<int>(share * m.coulomb_neg / lsb)};
  auto plant = bench::alone(m);
  bench::Counter counter(*plant);
  bench::Servo servo(law);
  std::vector<mmcs::PinEdge> edges;
  std::vector<int> y;
  const double off = 0.0;
  for (int k = 0; k < 2000; ++k) plant->step(&off, true, true, edges);  // until brakes are open
  while (static_cast<int>(y.size()) * ms < 1500) {
    y.push_back(counter.count(0));
    const double volts = servo.sample(c.step, y.back());
    for (int s = 0; s < ms * 1000 / mmcs::kStepUs; ++s) {
      plant->step(&volts, true, true, edges);
      counter.take(edges);
    }
  }
  const bench::Response r = bench::measure(y, c.step, ms);
  const std::string what = std::string(name) + " " + std::to_string(ms) + " ms, step " +
                           std::to_string(c.step) + ", compensation " + std::to_string(share);

  CHECK(!counter.bad_order_ && !counter.both_changed_, "%s: impossible edges", what.c_str());
  CHECK(counter.count(0) == plant->count(0), "%s: pins say %d, plant says %d", what.c_str(),
        counter.count(0), plant->count(0));
  const double rise = c.rise[variant];
  if (rise < 0) {
    CHECK(r.rise_ms < 0, "%s: reaches 90 %% although friction holds it short", what.c_str());
  } else {
    CHECK(std::abs(r.rise_ms - rise) <= std::max(4.0, 0.1 * rise), "%s: rise %g ms, want %g",
          what.c_str(), r.rise_ms, rise);
  }
  CHECK(std::abs(r.overshoot_pct - c.overshoot[variant]) <= 3.0, "%s: overshoot %g %%, want %g",
        what.c_str(), r.overshoot_pct, c.overshoot[variant]);
  // Stuck error: what the proportional gain times the error lacks to break the joint away.
  const double p = (a0 + a1) / 64.0;
  const double stick = (r.steady > 0 ? m.stiction_pos : m.stiction_neg) / lsb;
  const double ic = r.steady > 0 ? law.ic_pos : law.ic_neg;
  CHECK(std::abs(r.steady) <= std::ceil((stick - ic) / p) + 1, "%s: rests %d counts off",
        what.c_str(), r.steady);
  if (variant == 0 && c.overshoot[0] == 0.0 && c.step == 200) {
    const double slide = m.coulomb_pos / lsb;
    CHECK(r.steady >= std::ceil(slide / p) - 1, "%s: rests %d counts off, friction is gone",
          what.c_str(), r.steady);
  }
  CHECK(r.rest_pp == 0, "%s: moves %d counts at rest", what.c_str(), r.rest_pp);
}

void all(const char *name, const mmcs_motor &m, int ms, int a0, int a1,
         std::initializer_list<Case> cases) {
  for (const Case &c : cases) {
    for (int variant = 0; variant < 3; ++variant) run(name, m, ms, a0, a1, c, variant);
  }
}

constexpr const mmcs_motor *kPuma = robots::puma560;

}  // namespace

TEST(step_responses_j1) {
  all("J1", kPuma[0], 1, 63339, -60879,
      {{200, {69, 58, 56}, {0, 0, 0}}, {1000, {100, 100, 100}, {0, .3, .4}}});
  all("J1", kPuma[0], 2, 19869, -18909, {{200, {-1, 82, 74}, {0, 0, 0}}});
}

TEST(step_responses_j2) {
  all("J2", kPuma[1], 1, 34000, -32676,
      {{200, {50, 46, 45}, {0, 0, 0}},
       {1000, {62, 62, 62}, {1.5, 2.2, 2.4}},
       {-1000, {60, 60, 60}, {4.5, 4.9, 5.0}}});
  all("J2", kPuma[1], 2, 10649, -10132,
      {{200, {108, 70, 66}, {0, 0, 0}}, {1000, {86, 82, 82}, {0, 0, 0}}});
}

TEST(step_responses_j3) {
  all("J3", kPuma[2], 1, 20480, -19672, {{200, {51, 44, 43}, {0, 0, 0}}});
}

TEST(step_responses_j4) {
  all("J4", kPuma[3], 1, 13832, -13293,
      {{200, {50, 43, 42}, {0, 0, 0}}, {1000, {52, 51, 51}, {0, 0, 0}}});
  all("J4", kPuma[3], 2, 4331, -4120, {{200, {-1, 72, 64}, {0, 0, 0}}});
}

TEST(step_responses_j5_j6) {
  all("J5", kPuma[4], 1, 13147, -12634, {{200, {48, 43, 42}, {0, 0, 0}}});
  all("J6", kPuma[5], 1, 14420, -13861, {{200, {44, 42, 42}, {0, 0, 0}}});
}

TEST(step_responses_lab) {
  all("LAB500", robots::lab500[0], 1, 7309, -7027,
      {{200, {-1, 46, 42}, {0, 0, 0}}, {1000, {49, 46, 45}, {0, 0, 0}}});
  all("LAB500", robots::lab500[0], 2, 2304, -2194, {{1000, {92, 70, 66}, {0, 0, 0}}});
  all("LAB1000", robots::lab1000[0], 1, 3654, -3514, {{1000, {53, 45, 43}, {0, 0, 0}}});
}
