// SPDX-License-Identifier: Apache-2.0
// How rtl/mmcs.sv wires its boards: a table made by generate.py; and the values of its nets.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace mmcs {

struct NetInfo {
  const char *name;
  int width;
};
struct BoardInfo {
  const char *path, *module;
};
struct PinInfo {
  int board;
  const char *port;
  int inside;  // its net on the board (PortRow)
  int net, lsb, width;
  bool out;
};
struct LogicInfo {  // nets that an expression of mmcs.sv reads, and those that it drives
  std::vector<int> sources, targets;
};
struct WireTable {
  int cards;
  std::vector<NetInfo> nets;
  std::vector<BoardInfo> boards;
  std::vector<PinInfo> pins;
  std::vector<LogicInfo> logic;
};
extern const WireTable kWires;

// Where a design that Verilator knows by this name has a board, or what is in it.
inline std::string scope_of(const std::string &top, const std::string &path) {
  if (path.empty()) return top;
  return top + (path.rfind("g_card", 0) == 0 ? ".u_cards." : ".") + path;
}

// Is read and written as two halves, too.
using NetWord [[gnu::may_alias]] = uint64_t;

class Nets {
 public:
  // bits: of words(), all 0.
  explicit Nets(uint32_t *bits) : bits_(reinterpret_cast<NetWord *>(bits)) {
    size_t words = 0;
    for (const NetInfo &net : kWires.nets) {
      at_.push_back(words);
      words += words_of(net);
    }
  }
  static size_t words() {
    size_t words = 0;
    for (const NetInfo &net : kWires.nets) words += words_of(net);
    return words;
  }

  static int find(const std::string &name) {
    for (size_t n = 0; n < kWires.nets.size(); ++n) {
      if (name == kWires.nets[n].name) return static_cast<int>(n);
    }
    return -1;
  }

  // Where bits of a net are among the words.
  size_t at(int net, int lsb) const {
    return at_[static_cast<size_t>(net)] + static_cast<size_t>(lsb) / 64;
  }

  uint64_t get(int net, int lsb, int width) const {
    const NetWord *word = &bits_[at(net, lsb)];
    const int shift = lsb % 64;
    uint64_t value = word[0] >> shift;
    if (shift + width > 64) value |= word[1] << (64 - shift);
    return width == 64 ? value : value & ((uint64_t{1} << width) - 1);
  }

  // True: it changes.
  bool put(int net, int lsb, int width, uint64_t value) {
    const uint64_t mask = width == 64 ? ~uint64_t{0} : (uint64_t{1} << width) - 1;
    value &= mask;
    if (get(net, lsb, width) == value) return false;
    NetWord *word = &bits_[at(net, lsb)];
    const int shift = lsb % 64;
    word[0] = (word[0] & ~(mask << shift)) | value << shift;
    if (shift + width > 64) {
      word[1] = (word[1] & ~(mask >> (64 - shift))) | value >> (64 - shift);
    }
    return true;
  }

 private:
  static size_t words_of(const NetInfo &net) { return static_cast<size_t>(net.width) / 64 + 2; }

  std::vector<size_t> at_;  // a net's first word
  NetWord *const bits_;
};

}  // namespace mmcs
