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

[[noreturn]] void refuse() {
  throw std::runtime_error("through DPI no register can be read or written");
}

class DpiModel : public Model {
 public:
  DpiModel() {
    pins_.power_on();
    for (int n = 0; n < kResetClks; ++n) {
      if (n == kResetClks / 2) pins_.set(Pin::kSysreset, 0, 0);
      clocks(1);
    }
    lines_ = shown_lines_;
  }

  Stop run(int64_t n, int dtack, int64_t *ran) override {
    return run_by(n, dtack, ran, [this](int64_t most) { return clocks(most); });
  }

  bool dtack() const override { return !(bench_.vme >> MMCS_DPI_DTACK & 1); }
  bool alive() const override { return bench_.lines >> MMCS_DPI_ALIVE & 1; }
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

 private:
  void put(Port port, int lsb, int width, uint64_t value) override {
    bench_.put(port, lsb, width, value);
  }
  void cut(const std::string &, const char *, uint64_t mask, uint64_t) override {
    if (mask) refuse();
  }
  void stick(const std::string &, uint64_t, uint64_t) override { refuse(); }
  void stop_clock(bool) override { refuse(); }
  void put_back(const Saved &) override { refuse(); }

  // As many, or fewer: until an interrupt, DTACK* or a line has changed.
  int64_t clocks(int64_t most) {
    if (pins_.waiting()) pins_.apply();
    const int64_t passed = bench_.clocks(pins_.waiting() ? 1 : most);
    const uint32_t irq = ~(bench_.vme >> MMCS_DPI_IRQ) & 0x7F, lines = bench_.lines;
    shown_lines_ = irq << 1 | (lines >> MMCS_DPI_PANIC & 1) << 8 |
                   (lines >> MMCS_DPI_BRAKE_RELEASE & 1) << 9 |
                   (lines >> MMCS_DPI_SCLOCK & 1) << 10;
    return passed;
  }

  Bench &bench_ = Bench::only();
};

}  // namespace

std::unique_ptr<Model> Model::create(bool, uint64_t, const std::string &card) {
  if (!card.empty()) throw std::invalid_argument("own cards belong into the testbench here");
  return std::make_unique<DpiModel>();
}

int Model::cards() {
  return Bench::only().cards();
}
int Model::clk_hz() {
  return Bench::only().clk_hz();
}
uint64_t Model::digest() {
  refuse();
}
std::vector<uint8_t> Model::save() {
  refuse();
}
void Model::restore(const std::vector<uint8_t> &) {
  refuse();
}

const std::vector<Register> &registers() {
  static const std::vector<Register> none;
  return none;
}
int find_register(const std::string &) {
  return -1;
}

}  // namespace mmcs
