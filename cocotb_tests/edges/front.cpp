// SPDX-License-Identifier: Apache-2.0
// Length: one sweep: its wires, masters, the slave's answers and the judge are read together.
// Legal VME traffic at the least times a slave may see, at 8, 16, 48 and 80 MHz, with wires of
// different length and synchronisers that take what moves either way. Times in ps.

#include <algorithm>
#include <vector>

#include "Vbench_edges_front.h"
#include "world.h"

namespace {

constexpr long kNs = 1000, kSkew = 5 * kNs, kWindow = 2 * kNs, kTimeOut = 8000 * kNs;
constexpr long kCases = 51200;
constexpr unsigned kOurs = 0x6000, kOther = 0x2000, kMine = 5, kBehind = 3;

class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15U + 1) {}
  long below(long n) {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return static_cast<long>((state_ >> 11) % static_cast<uint64_t>(n));
  }
  bool coin() { return below(2) != 0; }

 private:
  uint64_t state_;
};

// Wires of the bus: the place of each in `Bus::wires`.
enum { kA = 0, kAm = 15, kD = 21, kAs = 29, kDs0, kDs1, kWrite, kLword, kIack, kIackin, kWires };

class Bus {
  VerilatedContext context_;

 public:
  Vbench_edges_front dut{&context_};
  Bus() { context_.timeprecision(-12); }

  void begin(long period, long phase, bool skew, bool metastable, uint64_t seed) {
    random = Random(seed);
    context_.randSeed(static_cast<int>(seed % 0x7FFFFFFF) + 1);
    period_ = period;
    for (long &wire : skew_) wire = skew ? random.below(2 * kSkew / 500 + 1) * 500 - kSkew : 0;
    events_.clear();
    why_ = nullptr;
    dut.window_i = metastable ? kWindow : 0;
    dut.delay_i = static_cast<unsigned char>(1 + random.below(12));
    dut.request_i = 0;
    for (int wire = 0; wire < kWires; ++wire) put(wire, wire >= kAs);
    dut.rst_ni = 0;
    rise_ = now + period;
    wait(3 * period);
    dut.rst_ni = 1;
    wait(3 * period);
    wait(phase);
    requests = answers = passes = 0;
    expected_ = nullptr;
  }

  struct Cycle {
    unsigned address;
    bool write;
    unsigned data;
    bool ack = false;
    bool ours() const { return !ack && address >> 11 == kOurs >> 11; }
  };

  // What a board sees of a wire comes up to 5 ns sooner or later than of the others.
  void set(int wire, bool level) { events_.push_back({now + kSkew + skew_[wire], wire, level}); }
  void address(const Cycle &c) {
    for (int bit = 0; bit < 15; ++bit) set(kA + bit, c.address >> (bit + 1) & 1);
    const unsigned am = c.ours() || c.ack || random.coin() ? 0x29 : 0x0B;
    for (int bit = 0; bit < 6; ++bit) set(kAm + bit, am >> bit & 1);
    set(kLword, true);
    set(kIack, !c.ack);
  }
  void data(const Cycle &c) {
    set(kWrite, !c.write);
    for (int bit = 0; bit < 8; ++bit) set(kD + bit, c.data >> bit & 1);
  }
  // DS0* now; the other half of a word within 20 ns.
  void strobe(const Cycle &c) {
    expected_ = &c;
    answered_ = false;
    set(kDs0, false);
  }
  void release() { set(kDs0, true); }
  void as(bool low) { set(kAs, !low); }
  void iackin(bool low) { set(kIackin, !low); }

  void wait(long time) {
    for (const long end = now + time; now < end;) step(end);
  }
  template <class F>
  bool wait_for(F met) {
    for (const long end = now + kTimeOut; now < end && !met();) step(end);
    return met();
  }
  bool answered() {
    return wait_for([this] { return dut.dtack_o != 0; });
  }
  void free() {
    if (!wait_for([this] { return dut.dtack_o == 0; })) fail("DTACK* stays low");
  }
  void fail(const char *why) {
    if (!why_) why_ = why;
  }
  const char *why() const { return why_; }

  Random random{1};
  long now = 0;
  unsigned requests = 0, answers = 0, passes = 0;

 private:
  struct Event {
    long at;
    int wire;
    bool level;
  };

  void put(int wire, bool level) {
    const auto bit = [level](auto &port, int n) {
      const unsigned mask = 1U << n;
      port = static_cast<std::decay_t<decltype(port)>>(level ? port | mask : port & ~mask);
    };
    if (wire < kAm) return bit(dut.a_i, wire - kA);
    if (wire < kD) return bit(dut.am_i, wire - kAm);
    if (wire < kAs) return bit(dut.d_i, wire - kD);
    if (wire == kAs) dut.as_ni = level;
    if (wire == kDs0) bit(dut.ds_ni, 0);
    if (wire == kDs1) bit(dut.ds_ni, 1);
    if (wire == kWrite) dut.write_ni = level;
    if (wire == kLword) dut.lword_ni = level;
    if (wire == kIack) dut.iack_ni = level;
    if (wire == kIackin) dut.iackin_ni = level;
  }

  // To the next instant at which something moves, or to the end.
  void step(long end) {
    const long fall = rise_ - period_ / 2;
    long next = std::min(end, dut.clk_i ? fall : rise_);
    for (const Event &event : events_) next = std::min(next, event.at);
    now = std::max(now, next);
    context_.time(static_cast<uint64_t>(now));
    bool moves = false;
    if (dut.clk_i && now >= fall) {
      dut.clk_i = 0;
      moves = true;
    } else if (!dut.clk_i && now >= rise_) {
      dut.clk_i = 1;
      rise_ += period_;
      moves = true;
    }
    for (size_t n = 0; n < events_.size();) {
      if (events_[n].at > now) {
        ++n;
        continue;
      }
      put(events_[n].wire, events_[n].level);
      events_[n] = events_.back();
      events_.pop_back();
      moves = true;
    }
    if (!moves) return;
    dut.eval();
    look();
  }

  void look() {
    const unsigned fell = dut.dtack_o & ~dtack_was_;
    const bool req = dut.hp_req_o, starts = req && !req_was_;
    if (starts) {
      ++requests;
      if (!expected_ || !expected_->ours() || answered_) {
        fail("an access that nobody asked for");
      } else if (dut.hp_a_o != (expected_->address >> 1 & 0x3FF) ||
                 dut.hp_write_o != expected_->write ||
                 (expected_->write && dut.hp_wdata_o != expected_->data)) {
        fail("an access with a wrong address or wrong data");
      }
    }
    if (fell) {
      ++answers;
      if (answered_ || !expected_ || (fell == 1 ? !expected_->ours() : !expected_->ack)) {
        fail("DTACK* in a cycle that is not ours");
      }
      if (!(expected_ && expected_->write) && !(dut.d_oe_o & fell)) fail("DTACK* without data");
      answered_ = true;
      if (passes) fail("an acknowledge is passed on and answered");
    }
    if (dut.d_oe_o && dut.ds_ni == 3) fail("data is driven without a strobe");
    if (!dut.iackout_no && out_was_) {
      ++passes;
      if (answered_) fail("an acknowledge is answered and passed on");
    }
    if (!dut.iackout_no && (dut.iackin_ni || dut.as_ni)) fail("IACKOUT* without IACKIN*, AS*");
    dtack_was_ = dut.dtack_o;
    req_was_ = req;
    out_was_ = dut.iackout_no;
  }

  long period_ = 0, rise_ = 0;
  long skew_[kWires] = {};
  std::vector<Event> events_;
  const Cycle *expected_ = nullptr;
  const char *why_ = nullptr;
  bool answered_ = false, req_was_ = false, out_was_ = true;
  unsigned dtack_was_ = 0;
};

using Cycle = Bus::Cycle;

// To the strobe of a cycle and its AS*. The address stands 10 ns before AS*, the data as long
// before the strobe, which may fall 10 ns before AS*: so with the address.
void run(Bus &bus, const Cycle &c) {
  const long lead = (bus.random.coin() ? 0 : bus.random.below(60)) * kNs;  // address before DS0*
  if (lead < 10 * kNs) {
    bus.data(c);
    bus.wait(10 * kNs - lead);
    bus.address(c);
    bus.wait(lead);
    bus.strobe(c);
    bus.wait(10 * kNs - lead);
    bus.as(true);
  } else {
    bus.address(c);
    bus.wait(10 * kNs);
    bus.as(true);
    bus.wait(lead - 10 * kNs);
    bus.data(c);
    bus.wait(10 * kNs);
    bus.strobe(c);
  }
}

// The same where address and AS* are there already.
void run_under_as(Bus &bus, const Cycle &c) {
  bus.data(c);
  bus.wait(10 * kNs);
  bus.strobe(c);
}

void finish(Bus &bus, const Cycle &c) {
  if (!bus.answered()) bus.fail("a cycle of ours is not answered");
  if (bus.dut.dtack_o == 1 && bus.dut.hp_a_o != (c.address >> 1 & 0x3FF)) {
    bus.fail("the answer of another address");
  }
  bus.wait(bus.random.below(30) * kNs);
}

void end(Bus &bus) {
  bus.release();
  bus.as(false);
  bus.wait(2 * kSkew);
  bus.free();
  bus.wait(30 * kNs);
}

Cycle any(Bus &bus) {
  return {kOurs | static_cast<unsigned>(bus.random.below(1024)) << 1 | 1, bus.random.coin(),
          static_cast<unsigned>(bus.random.below(256))};
}

// Strobes of a block transfer of a neighbour, 30 ns low and high, our address under the last one.
void block(Bus &bus) {
  const Cycle other{kOther | 8, true, 0x99}, ours = any(bus), next = any(bus);
  bus.address(other);
  bus.wait(10 * kNs);
  bus.as(true);
  const long strobes = 1 + bus.random.below(6);
  for (long n = 0; n < strobes; ++n) {
    bus.data(other);
    bus.wait(10 * kNs);
    bus.strobe(other);
    bus.wait((30 + bus.random.below(30)) * kNs);
    if (n + 1 == strobes) break;
    bus.release();
    bus.wait(20 * kNs);
  }
  bus.as(false);
  bus.address(ours);
  bus.wait(30 * kNs);
  bus.as(true);
  bus.wait(bus.random.below(200) * kNs);
  bus.release();
  bus.wait(20 * kNs);
  if (bus.requests) bus.fail("another's strobe is taken for ours");
  run_under_as(bus, ours);
  finish(bus, ours);
  end(bus);
  run(bus, next);
  finish(bus, next);
  end(bus);
  if (bus.requests != 2) bus.fail("not one access for each cycle");
}

// Cycles of ours and of neighbours one after the other, 30 ns apart.
void single(Bus &bus) {
  std::vector<Cycle> cycles;
  unsigned ours = 0;
  for (int n = 0; n < 4; ++n) {
    cycles.push_back(any(bus));
    if (bus.random.below(3) == 0) cycles.back().address ^= kOurs ^ kOther;
    ours += cycles.back().ours();
  }
  for (const Cycle &c : cycles) {
    run(bus, c);
    if (c.ours()) {
      finish(bus, c);
    } else {
      bus.wait((30 + bus.random.below(100)) * kNs);
    }
    end(bus);
  }
  if (bus.requests != ours) bus.fail("not one access for each cycle");
}

// Read and write under one AS*.
void modify(Bus &bus) {
  Cycle read = any(bus), write = read;
  read.write = false;
  write.write = true;
  run(bus, read);
  finish(bus, read);
  bus.release();
  bus.wait(2 * kSkew);
  bus.free();
  bus.wait(20 * kNs);
  run_under_as(bus, write);
  finish(bus, write);
  end(bus);
  if (bus.requests != 2) bus.fail("not one access for each strobe");
}

// Acknowledges of our level and another's, the request coming up around the fall of IACKIN*.
void acknowledge(Bus &bus) {
  for (int turn = 0; turn < 2; ++turn) {
    const bool level = bus.random.below(4) != 0;
    const Cycle ack{(level ? kMine : kBehind) << 1, false, 0xFF, true};
    bus.answers = bus.passes = 0;
    const long when = bus.random.below(3);  // it stands, comes up meanwhile, is not there
    bus.dut.request_i = when == 0;
    bus.wait(3 * 125 * kNs);
    run(bus, ack);
    bus.wait((20 + bus.random.below(20)) * kNs);
    bus.iackin(true);
    bus.wait(bus.random.below(2 * kSkew));
    if (when == 1) bus.dut.request_i = 1;
    if (!bus.wait_for([&] { return bus.answers || bus.passes; })) {
      bus.fail("an acknowledge is neither answered nor passed on");
    }
    bus.wait(bus.random.below(300) * kNs);
    if (bus.answers + bus.passes != 1) bus.fail("an acknowledge is passed on and answered");
    if (when == 0 && level && !bus.answers) bus.fail("our acknowledge is passed on");
    if ((when == 2 || !level) && !bus.passes) bus.fail("another's acknowledge is answered");
    bus.release();
    bus.as(false);
    bus.wait(bus.random.below(20) * kNs);
    bus.iackin(false);
    bus.wait(2 * kSkew);
    bus.free();
    bus.wait(30 * kNs);
  }
  bus.requests = bus.passes = 0;
  const Cycle after = any(bus);
  run(bus, after);
  finish(bus, after);
  end(bus);
  if (bus.requests != 1) bus.fail("not one access for each cycle");
}

}  // namespace

int main(int argc, char **argv) {
  long total = 0;
  const Options options(argc, argv);
  struct {
    const char *name;
    void (*run)(Bus &);
  } scenes[] = {{"block", block}, {"single", single}, {"modify", modify}, {"ack", acknowledge}};
  Bus bus;
  for (long mhz : {8, 16, 48, 80}) {
    for (int kind = 0; kind < 4; ++kind) {
      const bool skew = kind & 1, metastable = kind & 2;
      long cases = 0, failures = 0;
      for (long index = options.sample - 1; index < kCases; index += options.sample) {
        auto &scene = scenes[index % 4];
        if (!options.wants(scene.name)) continue;
        const long period = 1000000 / mhz;
        bus.begin(period, index / 4 * 500 % period, skew, metastable,
                  static_cast<uint64_t>(index * 16 + kind * 4 + mhz % 7 + 1));
        scene.run(bus);
        ++cases;
        if (!bus.why()) continue;
        if (++failures <= kShown)
          std::printf("  %ld MHz: %s %ld: %s\n", mhz, scene.name, index, bus.why());
      }
      std::printf("EDGES %ld MHz|%ld|%ld|wires %s, synchronisers %s\n", mhz, cases, failures,
                  skew ? "±5 ns apart" : "alike", metastable ? "either way" : "ideal");
      std::fflush(stdout);
      total += failures;
    }
  }
  return total != 0;
}
