// SPDX-License-Identifier: Apache-2.0
// The model behind DPI without a simulator: at which clock run() ends, when one pin moves alone.
//
// One line for each case that is wrong; exit status 1 then.

#include <cstdio>
#include <memory>
#include <vector>

#include "../../dpi/bench.h"
#include "model.h"

namespace mmcs {
namespace {

constexpr int kAt = 10, kLongest = 100;
constexpr unsigned kIdle = 0x7F << MMCS_DPI_IRQ | 1u << MMCS_DPI_DTACK;  // low when asserted

struct Case {
  const char *name;
  unsigned vme, lines;  // bits that change in clock kAt of this case, and stay
  int dtack;            // as run() is asked
  Stop stop;
  int64_t ran;
};

// A line is told a clock after its change, as the other builds tell it.
std::vector<Case> cases() {
  std::vector<Case> all = {
      {"PANIC", 0, 1u << MMCS_DPI_PANIC, -1, Stop::kLines, kAt + 1},
      {"SCLOCK", 0, 1u << MMCS_DPI_SCLOCK, -1, Stop::kLines, kAt + 1},
      {"brakes", 0, 1u << MMCS_DPI_BRAKE_RELEASE, -1, Stop::kLines, kAt + 1},
      {"DTACK* falls", 1u << MMCS_DPI_DTACK, 0, 0, Stop::kDtack, kAt},
      {"DTACK* stands low", 0, 0, 0, Stop::kDtack, 1},
      {"DTACK* rises", 1u << MMCS_DPI_DTACK, 0, 1, Stop::kDtack, kAt},
      {"DTACK* stands high", 0, 0, 1, Stop::kDtack, 1},
      {"data lines", 0xFFFF, 0, -1, Stop::kDone, kLongest},
  };
  static constexpr const char *kIrqs[] = {"IRQ1*", "IRQ2*", "IRQ3*", "IRQ4*",
                                          "IRQ5*", "IRQ6*", "IRQ7*"};
  for (int irq = 0; irq < 7; ++irq)
    all.push_back({kIrqs[irq], 1u << (MMCS_DPI_IRQ + irq), 0, -1, Stop::kLines, kAt + 1});
  return all;
}

const std::vector<Case> kCases = cases();
size_t now = 0;       // the case that runs
bool begins = false;  // its clocks are counted anew
int wrong = 0;

void engine() {
  const std::unique_ptr<Model> model = Model::create(false, false, 0);
  for (; now < kCases.size(); ++now) {
    const Case &is = kCases[now];
    begins = true;
    int64_t ran = 0;
    const Stop stop = model->run(kLongest, is.dtack, &ran);
    if (stop == is.stop && ran == is.ran) continue;
    std::printf("%s: stop %d after %d clocks, not %d after %d\n", is.name, static_cast<int>(stop),
                static_cast<int>(ran), static_cast<int>(is.stop), static_cast<int>(is.ran));
    ++wrong;
  }
  Bench::only().end(0);
  for (;;) Bench::only().clocks(1);
}

int simulator() {
  Bench::only().begin(1, 8'000'000, engine);
  uint32_t vme = kIdle, lines = 0, words[MMCS_DPI_AXIS_WORDS] = {};
  uint32_t safety, encoder[3], switches[3], adc[MMCS_DPI_AXIS_WORDS];
  uint64_t bus;
  for (int clock = 0;; ++clock) {
    if (begins) clock = 1;
    begins = false;
    if (clock == kAt && now < kCases.size()) {
      vme ^= kCases[now].vme;
      lines ^= kCases[now].lines;
    }
    if (mmcs_dpi_clock(vme, lines, words, words, words, &bus, &safety, encoder, switches, adc))
      return wrong != 0;
  }
}

}  // namespace
}  // namespace mmcs

int main() {
  return mmcs::simulator();
}
