// SPDX-License-Identifier: Apache-2.0
// What rtl/mmcs.sv wires and computes between its boards. The table is made by generate.py.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace mmcs {

class Wires;

struct NetInfo {
  const char *name;
  int width;
  bool input;  // of the machine
};
struct BoardInfo {
  const char *path, *module;
};
struct PinInfo {
  int board;
  const char *port;
  int net, lsb, width;
};
struct LogicInfo {
  void (*run)(Wires &);
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

// Whoever is told what changes.
class Listener {
 public:
  virtual void changed(int net, int lsb, int width) = 0;

 protected:
  ~Listener() = default;
};

// The values of all nets.
class Wires {
 public:
  explicit Wires(Listener &listener) : listener_(listener) {
    size_t words = 0;
    for (const NetInfo &net : kWires.nets) {
      at_.push_back(words);
      words += static_cast<size_t>(net.width) / 64 + 2;
    }
    bits_.resize(words);
    held_.resize(kWires.nets.size());
    before_.resize(kWires.nets.size());
  }

  static int find(const std::string &name) {
    for (size_t n = 0; n < kWires.nets.size(); ++n) {
      if (name == kWires.nets[n].name) return static_cast<int>(n);
    }
    return -1;
  }

  uint64_t get(int net, int lsb, int width) const {
    const uint64_t *word = &bits_[at(net, lsb)];
    const int shift = lsb % 64;
    uint64_t value = word[0] >> shift;
    if (shift + width > 64) value |= word[1] << (64 - shift);
    return width == 64 ? value : value & ((uint64_t{1} << width) - 1);
  }

  void put(int net, int lsb, int width, uint64_t value) {
    const uint64_t mask = width == 64 ? ~uint64_t{0} : (uint64_t{1} << width) - 1;
    value &= mask;
    if (get(net, lsb, width) == value) return;
    uint64_t *word = &bits_[at(net, lsb)];
    const int shift = lsb % 64;
    word[0] = (word[0] & ~(mask << shift)) | value << shift;
    if (shift + width > 64) {
      word[1] = (word[1] & ~(mask >> (64 - shift))) | value >> (64 - shift);
    }
    if (!held_[static_cast<size_t>(net)]) listener_.changed(net, lsb, width);
  }

  // While its logic builds a net step by step, nobody is told.
  void hold(int net) {
    held_[static_cast<size_t>(net)] = true;
    before_[static_cast<size_t>(net)] = get(net, 0, width(net));
  }
  void release(int net) {
    held_[static_cast<size_t>(net)] = false;
    if (get(net, 0, width(net)) != before_[static_cast<size_t>(net)]) {
      listener_.changed(net, 0, width(net));
    }
  }

 private:
  static int width(int net) {
    const int width = kWires.nets[static_cast<size_t>(net)].width;
    return width < 64 ? width : 64;
  }

  size_t at(int net, int lsb) const {
    return at_[static_cast<size_t>(net)] + static_cast<size_t>(lsb) / 64;
  }

  Listener &listener_;
  std::vector<size_t> at_;  // a net's first word
  std::vector<uint64_t> bits_, before_;
  std::vector<char> held_;
};

}  // namespace mmcs
