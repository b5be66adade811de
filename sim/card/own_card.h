// SPDX-License-Identifier: Apache-2.0
// Cards of one's own on the PC-bus expansion of rtl/mmcs.sv, those with motors in slots of Mark I
// cards: one Verilated model of all of them in a library by itself, made by card.py.
#pragma once

#include <cstdint>
#include <cstring>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "board.h"
#include "pins.h"

namespace mmcs {

// What such a library exports, under these names. Its run-time library of Verilator is its own.
struct CardModel {
  Context context;
  std::unique_ptr<Board> board;
  // At most 64 bits each: elements of arrays and words of wide registers are listed one by one.
  std::vector<std::pair<std::string, Net>> registers;
};
// In it: what card.py found, up to one without a name.
struct CardRow {
  const char *path, *name;
  bool must;  // it is in the model; else a variable of a loop, which may be gone
};
extern const CardRow kCardRows[];
extern "C" {
CardModel *mmcs_card_create();
void mmcs_card_destroy(CardModel *model);
const char *mmcs_card_register_name(int n);  // null: there are no more
}

class OwnCard {
 public:
  // Nets of rtl/mmcs.sv, which the ports of the model are named by.
  static constexpr const char *kInputs[] = {"rst_ni",          "pcx_a_o",    "pcx_d_o",
                                            "pcx_ior_no",      "pcx_iow_no", "pcx_aen_o",
                                            "pcx_reset_drv_o", "pcx_drq_o",  "pcx_clk_en_o"};
  static constexpr const char *kOutputs[] = {"pcx_d_i", "pcx_d_oe_i", "pcx_wait_i", "pcx_irq_i"};
  static constexpr size_t kAddress = 1;  // of these
  enum Output { kData, kDataOe, kWait, kIrq, kMostOutputs };
  // A bus and cards that follow each other longer than this have a combinational loop.
  static constexpr int kMostRounds = 64;
  static constexpr const char *kUnstable = "the own card and the PC bus do not settle";

  // Throws std::runtime_error.
  explicit OwnCard(const std::string &library);
  ~OwnCard();
  OwnCard(const OwnCard &) = delete;

  bool stands_in(int slot) const { return slots_.get() >> slot & 1; }
  int16_t drive(int axis) const { return static_cast<int16_t>(drive_.get(16 * axis, 16)); }
  // Whether this field of a port of rtl/mmcs.sv is of a joint of its own.
  bool has(Port port, int lsb) const {
    return joints_[port] && stands_in(lsb / (port == kAdc ? 32 : 2));
  }
  // Such a field, which changes; false: it is none.
  bool take(Port port, int lsb, uint64_t value);
  // What is wrong if two cards have answered one read, or "".
  const std::string &clash() const { return clash_; }

  bool has(size_t input) const { return static_cast<bool>(inputs_[input]); }
  void put(size_t input, uint64_t value);
  // What follows from inputs that were put. True: outputs have changed.
  bool follow();
  // One clock, with the inputs as they are. True: outputs have changed.
  bool clock();
  uint64_t output(Output n) const { return sent_[n]; }
  // Nothing is to follow, and it drives nothing on the bus.
  bool quiet() const { return !changed_ && (sent_[kDataOe] | sent_[kWait] | sent_[kIrq]) == 0; }
  // The next clock may change something: an input or a register has changed since the last.
  bool active() const { return active_; }

  size_t size() const { return model_->registers.size(); }
  const std::string &name(size_t reg) const { return model_->registers[reg].first; }
  const Net &net(size_t reg) const { return model_->registers[reg].second; }
  int width(size_t reg) const { return net(reg).width; }
  uint64_t read(size_t reg) const { return net(reg).get(); }
  // Flips these bits; follow() does what follows.
  void upset(size_t reg, uint64_t bits);
  // All registers at once, without the edge of a reset; called twice, as resets among them follow.
  void restore(const std::vector<uint64_t> &values);
  void copy_registers(std::vector<char> *to) const;
  // go_back(): to what registers and inputs were at the last mark(), when it was quiet.
  void mark();
  void go_back();

 private:
  bool registers_changed();
  bool send();

  void *library_ = nullptr;
  decltype(&mmcs_card_destroy) destroy_ = nullptr;
  CardModel *model_ = nullptr;
  std::vector<Net> inputs_, outputs_;  // of the bus; behind its inputs those of encoders
  Net joints_[kPorts], drive_, slots_, clashes_;
  std::string clash_;
  uint64_t sent_[kMostOutputs] = {};
  std::vector<std::pair<char *, size_t>> memory_;  // of the registers: where, and how many bytes
  std::vector<char> known_;                        // what is there, as seen last
  std::vector<char> marked_;                       // as mark() found it
  std::vector<uint64_t> marked_inputs_;
  bool changed_ = true, active_ = true;
  bool looked_ = false;  // known_ is of the last clock, and nothing has happened since
  unsigned busy_ = 0;    // clocks in a row in which it was active
};

}  // namespace mmcs
