// SPDX-License-Identifier: Apache-2.0
// A board in its slot: its units, and its ports on the nets of the machine.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "board.h"
#include "tables.h"
#include "unit.h"
#include "wires.h"

namespace mmcs {

struct Block;

// The unit whose registers follow from a port, and what makes it look away.
struct Look {
  Unit *unit;
  const Guard *quiet;
};

// A port of a board on its net.
struct Slot {
  Block *block;
  Net port;
  int net, lsb, width;
  const PortRow *row;
  Look look;
  uint64_t held = 0, at = 0;  // bits that a fault holds, and at what
  uint64_t shown = 0;         // of an output: what the net has of it

  uint64_t through(uint64_t value) const { return (value & ~held) | at; }
  uint64_t value() const { return through(port.get()); }
};

struct Block {
  Block(const std::string &module, VerilatedContext &context, const std::string &name);

  Net find(const std::string &path, const std::string &name) const;

  Look look_of(const char *port);
  // Edge t for those units that are due.
  void edge(int64_t t);
  // The slow way: all of it, both edges of the clock, by Verilator's own eval().
  void whole_edge(int64_t t);
  // After edge t: what its inputs and registers mean for the next ones.
  void look(int64_t t);
  void wake(int64_t t);
  // Counters up to edge t. Registers may then be read, and written if wake() follows.
  void catch_up(int64_t t);
  int64_t due() const {
    int64_t first = kNever;
    for (const Unit &u : units) first = u.due < first ? u.due : first;
    return first;
  }

  const BoardTable &table;
  VerilatedContext &context;
  std::string name;
  std::unique_ptr<Board> board;
  char *base;
  std::vector<Unit> units;
  std::vector<Slot *> outs;
  Words out_words;
  int64_t next = 0;      // due(), kept
  bool stale = true;     // inputs or counters were written, and nothing has followed
  bool reset = false;    // among them one that resets without a clock
  bool touched = false;  // in the list of those to look at
  struct Poke {
    Net net;
    uint64_t clear, set;
  };
  std::vector<Poke> pokes;  // faults that hold bits of registers

 private:
  void poke();
};

}  // namespace mmcs
