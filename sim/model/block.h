// SPDX-License-Identifier: Apache-2.0
// A board in its slot: itself and its chips, each a model, and its ports on the nets of the
// machine.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "tables.h"
#include "unit.h"
#include "wires.h"

namespace mmcs {

struct Block;

// A port of a board on its net.
struct Slot {
  Block *block;
  Net port;
  int net, lsb, width;
  const PortRow *row;
  bool wakes = false;            // registers of the board itself follow from it ...
  const Guard *quiet = nullptr;  // ... unless this holds
  bool late = false;             // what happens here concerns chips alone: see Block::defer()
  uint64_t held = 0, at = 0;     // bits that a fault holds, and at what
  uint64_t shown = 0;            // what the net has of it

  uint64_t through(uint64_t value) const { return (value & ~held) | at; }
  uint64_t value() const { return through(port.get()); }
};

// Ports of one model that are wired to those of another, of the same size.
class Copies {
 public:
  void add(const char *base, Net from, Net to, bool wakes);
  // Those that moved since the last time arrive; true if there are any, with `woken` if any
  // concerns registers at the far end.
  bool take(const char *base, bool *woken) {
    if (!all_.moved(base)) return false;
    *woken = waking_.moved(base);
    for (const Copy &c : bytes_) *c.to = *c.from;
    for (const Copy &c : longer_) std::memcpy(c.to, c.from, c.size);
    return true;
  }

 private:
  struct Copy {
    const char *from;
    char *to;
    size_t size;
  };
  std::vector<Copy> bytes_, longer_;
  Words all_, waking_;
};

// A chip on its board.
struct Chip {
  Unit *unit;
  Copies in, out;
  Guard quiet;  // while it holds, the chip at rest looks at no input but the waking ones
};

struct Block {
  Block(const std::string &module, VerilatedContext &context, const std::string &name);

  // A register or port of the board or of one of its chips.
  Net find(const std::string &path, const std::string &name) const;
  Net find(const RegisterRow &row) const {
    Net net = find(row.path, row.name);
    net.width = row.width;
    return net;
  }
  Unit &board() { return units[0]; }

  void look_of(Slot &slot) const;
  // After edge t an input changes, but only chips' registers follow, which nobody looks at now: it
  // may wait until catch_up(). Should an output follow after all, catch_up() throws.
  void defer(int64_t t, const Slot &slot, uint64_t value) {
    deferred_.push_back({t, slot.port, value});
  }
  bool behind() const { return !deferred_.empty(); }
  // Edge t for those units that are due.
  void edge(int64_t t);
  // Edge t, and those after it before `end` at which the board alone is due, until something moves
  // that its chips look at or its neighbours see; the last.
  int64_t edges(int64_t t, int64_t end);
  // The slow way: all of it, both edges of the clock, by Verilator's own eval().
  void whole_edge(int64_t t);
  // What inputs and registers mean after edge t, between the board and its chips.
  void look(int64_t t);
  void renew(int64_t t);
  // All up to edge t. Registers may then be read, and written if written() follows.
  void catch_up(int64_t t);
  void written(int64_t t);
  int64_t due() const {
    int64_t first = kNever;
    for (const Unit &u : units) first = u.due < first ? u.due : first;
    return first;
  }

  const BoardTable &table;
  VerilatedContext &context;
  std::string name;
  size_t number = 0;  // among the boards
  std::vector<Unit> units;
  std::vector<Chip> chips;
  Guard quiet;  // of the board's own inputs
  std::vector<Slot *> outs;
  Words out_words;
  bool outs_moved = false;  // they did, and nobody has been told
  bool touched = false;     // in the list of those to look at

 private:
  struct Change {
    int64_t t;
    Net port;
    uint64_t value;
  };
  void run(int64_t t);
  std::vector<Change> deferred_;
  Words chip_words_, waking_words_;  // what chips see of the board, at rest and quiet

  const NetRow *row_of(const char *path, const char *port, size_t unit) const;
};

}  // namespace mmcs
