// SPDX-License-Identifier: Apache-2.0
// Encoder edges: their order, their clocks, the index, and faults on the wires.
#include "bench.h"
#include "check.h"
#include "maths.h"

namespace {

using bench::input;
using mmcs::PinEdge;
using mmcs::Plant;

// A heavy wheel without friction: constant speed after a push.
mmcs_motor wheel(int counts_per_rev = 1000) {
  mmcs_motor m = {};
  m.inertia = 1e-3;
  m.km = 1.0;
  m.resistance = 1.0;
  m.amp_gain = 1.0;
  m.gear = 1.0;
  m.counts_per_rev = counts_per_rev;
  m.index_per_rev = 1;
  return m;
}

// Steps at so many volts; `seen` is called with each edge and the number of its clock.
template <typename Seen>
void drive(Plant &plant, double volts, int steps, Seen seen) {
  std::vector<PinEdge> edges;
  for (int64_t k = 0; k < steps; ++k) {
    plant.step(&volts, true, true, edges);
    for (const PinEdge &e : edges) seen(e, k * bench::kClks + e.clk);
  }
}

void coast(Plant &plant, bench::Counter &counter, int steps) {
  drive(plant, 0.0, steps, [&](const PinEdge &e, int64_t) { counter.take({e}); });
}

// Brings it to about `speed` rad/s.
void push(Plant &plant, double speed, bench::Counter &counter) {
  while (std::abs(plant.velocity(0)) < std::abs(speed)) {
    drive(plant, speed > 0 ? 10.0 : -10.0, 1,
          [&](const PinEdge &e, int64_t) { counter.take({e}); });
  }
}

}  // namespace

TEST(edges_fall_on_the_clock_of_the_angle) {
  for (const double speed : {440.0, -440.0, 3.0}) {
    auto plant = bench::alone(wheel());
    plant->set_input(input("index_missing"), 0, speed > 0);  // a fault alters no other edge
    bench::Counter counter(*plant);
    push(*plant, speed, counter);
    // Clocks between edges of a wheel at constant speed.
    const double want =
        2 * M_PI / 1000 / std::abs(plant->velocity(0)) / bench::kStepS * bench::kClks;
    int64_t last = -1;
    int seen = 0;
    drive(*plant, 0.0, 4000, [&](const PinEdge &, int64_t clk) {
      CHECK(last < 0 || std::abs(static_cast<double>(clk - last) - want) <= 1.0,
            "%lld clocks between edges, want %g", static_cast<long long>(clk - last), want);
      last = clk;
      ++seen;
    });
    CHECK(std::abs(seen - 4000 * bench::kClks / want) < 2, "%d edges", seen);
  }
}

TEST(counts_follow_the_angle_both_ways) {
  auto plant = bench::alone(wheel());
  bench::Counter counter(*plant);
  std::vector<PinEdge> edges;
  uint64_t random = 42;
  for (int k = 0; k < 20000; ++k) {
    const double volts = 20.0 * (mmcs::random_unit(random) - 0.5);
    for (int s = 0; s < 5; ++s) {
      plant->step(&volts, true, true, edges);
      counter.take(edges);
      const double exact = plant->angle(0) * 1000 / (2 * M_PI);
      CHECK(std::abs(counter.count(0) - exact) <= 0.5 + 1e-9, "%d counts at %g", counter.count(0),
            exact);
      if (check::failures > 0) return;
    }
  }
  CHECK(!counter.bad_order_ && !counter.both_changed_, "impossible edges");
  CHECK(counter.count(0) == plant->count(0), "%d and %d", counter.count(0), plant->count(0));
  CHECK(counter.pins(0) == plant->pins(0), "pins differ");
}

// Edges closer than the gap are put off, none is lost, and order is kept.
TEST(gap_between_edges) {
  const mmcs_motor m = wheel(40000);
  constexpr int kWide = 40;
  auto plant = Plant::create(bench::config(1), &m, nullptr, bench::kClks, kWide);
  bench::Counter counter(*plant);
  std::vector<PinEdge> edges;
  int64_t last = -kWide;
  for (int64_t k = 0; k < 20000; ++k) {
    const double volts = k < 1000 ? 10.0 : k < 2000 ? -10.0 : 0.0;
    plant->step(&volts, true, true, edges);
    counter.take(edges);
    for (const auto &e : edges) {
      const int64_t clk = k * bench::kClks + e.clk;
      CHECK(clk - last >= kWide, "%lld clocks", static_cast<long long>(clk - last));
      last = clk;
    }
  }
  const double exact = plant->angle(0) * 40000 / (2 * M_PI);
  CHECK(std::abs(counter.count(0) - exact) <= 1.0, "%d counts at %g", counter.count(0), exact);
}

TEST(index_once_per_revolution_one_state_wide) {
  for (const double speed : {300.0, -300.0}) {
    mmcs_motor m = wheel(2000);
    m.angle0 = 1.0;  // 318.3 counts after the index
    auto plant = bench::alone(m);
    bench::Counter counter(*plant);
    push(*plant, speed, counter);
    coast(*plant, counter, 4000);
    const auto &at = counter.index_at(0);
    CHECK(at.size() > 5, "%zu index pulses", at.size());
    for (const int count : at) {
      CHECK((count + 318) % 2000 == 0, "index at count %d", count);
    }
  }
  // One quadrature state wide: it rises with one edge and falls with the next.
  auto plant = bench::alone(wheel());
  bench::Counter counter(*plant);
  push(*plant, 100.0, counter);
  int high = 0;
  int revolutions = 0;
  drive(*plant, 0.0, 20000, [&](const PinEdge &e, int64_t) {
    high = e.i != 0 ? high + 1 : 0;
    revolutions += e.i;
    CHECK(high <= 1, "index spans two states");
    CHECK(e.i == 0 || (e.a == 0 && e.b == 0), "index outside of state 00");
  });
  CHECK(revolutions >= 15, "%d revolutions", revolutions);
}

TEST(glitches_come_at_their_rate_and_by_seed) {
  const auto edges_of = [](uint64_t seed) {
    auto plant = bench::alone(wheel(), seed);
    plant->set_input(input("encoder_glitch"), 0, 1000.0);
    plant->set_input(input("index_glitch"), 0, 200.0);
    std::vector<int64_t> all;
    drive(*plant, 0.0, 20000,
          [&](const PinEdge &e, int64_t clk) { all.push_back(clk + 1000000000 * e.i); });
    return all;
  };
  const auto a = edges_of(1);
  // Two edges per pulse, 2 x 1000 + 200 pulses in the second.
  CHECK(a.size() > 4000 && a.size() < 4800, "%zu edges", a.size());
  CHECK(a == edges_of(1), "the same seed must give the same pulses");
  CHECK(a != edges_of(2), "another seed must give others");
  // Pulses on a wheel that turns leave the true count alone and cost the counter little.
  auto plant = bench::alone(wheel());
  bench::Counter counter(*plant);
  plant->set_input(input("encoder_glitch"), 0, 100.0);
  push(*plant, 100.0, counter);
  coast(*plant, counter, 4000);
  plant->set_input(input("encoder_glitch"), 0, 0.0);
  coast(*plant, counter, 10);
  CHECK(plant->pins(0) == counter.pins(0), "pins differ after the last pulse");
  auto still = bench::alone(wheel());
  const auto sound = still->pins(0);
  for (int k = 0; k < 300; ++k) {  // pulses that are under way when the fault is cleared end
    for (const double rate : {1e5, 0.0, 0.0}) {
      still->set_input(input("encoder_glitch"), 0, rate);
      bench::run(*still, 0.0, bench::kStepS);
    }
    CHECK(still->pins(0) == sound, "pins %u after pulse %d", still->pins(0), k);
  }
}

// Own sine and cosine against the C library's, which is good to an ulp or so.
TEST(sine_and_cosine) {
  uint64_t random = 3;
  double worst = 0.0;
  for (int k = 0; k < 1000000; ++k) {
    const double scale = k % 3 == 0 ? 1.0 : k % 3 == 1 ? 10.0 : 10000.0;
    const double x = (mmcs::random_unit(random) - 0.5) * 2.0 * scale;
    double s;
    double c;
    mmcs::sin_cos(x, s, c);
    worst = std::max({worst, std::abs(s - std::sin(x)), std::abs(c - std::cos(x))});
  }
  CHECK(worst < 5e-16, "worst error %g", worst);
  double s;
  double c;
  mmcs::sin_cos(0.0, s, c);
  CHECK(s == 0.0 && c == 1.0, "sin 0 = %g, cos 0 = %g", s, c);
  CHECK(std::abs(mmcs::exp_neg(0.25) - std::exp(-0.25)) < 2e-16, "%.17g", mmcs::exp_neg(0.25));
}
