// SPDX-License-Identifier: Apache-2.0
// The machine of somebody else's simulator as a Model: run() lets the simulator have its clocks.
//
// Pins, lines and clocks only. What needs a hand inside the hardware is refused: a register that is
// read, flipped or held, a wire that is cut, a snapshot.

#include <stdexcept>

#include "bench.h"
#include "model.h"

namespace mmcs {
namespace {

constexpr int kResetClks = 64;  // as the other builds: clock 0 is the first after them

class DpiModel : public Model, private Ports {
 public:
  DpiModel() : pins_(*this, Bench::only().cards()) {
    pins_.power_on();
    for (int n = 0; n < kResetClks; ++n) {
      if (n == kResetClks / 2) pins_.set(Pin::kSysreset, 0, 0);
      clock_once();
    }
    lines_ = shown_;
  }

  Stop run(int64_t n, int dtack, int64_t *ran) override {
    const int64_t begin = clock_;
    Stop stop = Stop::kDone;
    while (clock_ < begin + n) {
      const bool moved = lines_ != shown_;
      lines_ = shown_;
      clock_once();
      ++clock_;
      if (moved) {
        stop = Stop::kLines;
        break;
      }
      if (dtack >= 0 && this->dtack() == (dtack == 0)) {
        stop = Stop::kDtack;
        break;
      }
    }
    *ran = clock_ - begin;
    return stop;
  }

  int64_t clock() const override { return clock_; }
  uint64_t evals() const override { return static_cast<uint64_t>(clock_); }
  void set_evals(uint64_t) override {}
  bool was_upset() const override { return false; }
  void set_upset(bool) override {}
  unsigned lines() const override { return lines_; }
  bool dtack() const override { return !(bench_.vme >> MMCS_DPI_DTACK & 1); }
  bool alive() const override { return bench_.lines >> MMCS_DPI_ALIVE & 1; }
  Pins &pins() override { return pins_; }
  int16_t drive(int axis) const override {
    return static_cast<int16_t>(bits_of(bench_.drive, 16 * axis, 16));
  }
  unsigned leds(int card) const override { return bits_of(bench_.leds, 11 * card, 11); }
  unsigned vme_sample() override {
    return (bench_.vme & 0x1FFFFu) | (bench_.vme >> MMCS_DPI_IACKOUT & 1) << 17;
  }
  std::string cannot(Pin pin) const override {
    return pin_is_port(pin) ? "" : "it is inside the hardware, where no call of DPI reaches";
  }
  uint64_t read(int) override { refuse(); }
  void upset(int, uint64_t) override { refuse(); }
  std::vector<uint8_t> save() override { refuse(); }
  void restore(const std::vector<uint8_t> &) override { refuse(); }
  bool trace(const std::string &) override { return false; }
  const std::string &failure() const override { return failure_; }

 private:
  [[noreturn]] static void refuse() {
    throw std::runtime_error("through DPI no register can be read or written");
  }
  void put(Port port, int lsb, int width, uint64_t value) override {
    bench_.put(port, lsb, width, value);
  }
  void cut(const std::string &, const char *, uint64_t mask, uint64_t) override {
    if (mask) refuse();
  }
  void stick(const std::string &, uint64_t, uint64_t) override { refuse(); }
  void stop_clock(bool) override { refuse(); }
  uint64_t look(const std::string &) override { refuse(); }

  void clock_once() {
    if (pins_.waiting()) pins_.apply();
    bench_.clock();
    const uint32_t irq = ~(bench_.vme >> MMCS_DPI_IRQ) & 0x7F, lines = bench_.lines;
    shown_ = irq << 1 | (lines >> MMCS_DPI_PANIC & 1) << 8 |
             (lines >> MMCS_DPI_BRAKE_RELEASE & 1) << 9 | (lines >> MMCS_DPI_SCLOCK & 1) << 10;
  }

  Bench &bench_ = Bench::only();
  Pins pins_;
  int64_t clock_ = 0;
  unsigned lines_ = 0, shown_ = 0;  // as the engine sees them, a clock after they move
  const std::string failure_;       // an assertion ends the simulator, and tells by itself
};

}  // namespace

std::unique_ptr<Model> Model::create(bool, bool, uint64_t) {
  return std::make_unique<DpiModel>();
}

int Model::cards() {
  return Bench::only().cards();
}
int Model::clk_hz() {
  return Bench::only().clk_hz();
}
bool Model::skip() {
  return false;
}
bool Model::traced() {
  return false;
}
bool Model::soc() {
  return false;
}

// The one register that a run looks at: a witness of where the card believes the axis is.
uint16_t Model::encoder_register(int axis) {
  return static_cast<uint16_t>(bits_of(Bench::only().counters, 16 * axis, 16));
}
uint64_t Model::digest() {
  throw std::runtime_error("through DPI no register can be read or written");
}

const std::vector<Register> &registers() {
  static const std::vector<Register> none;
  return none;
}
int find_register(const std::string &) {
  return -1;
}

}  // namespace mmcs
