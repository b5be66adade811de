// SPDX-License-Identifier: Apache-2.0
// What parts of one module do, remembered: states, and the transitions between them.
//
// A state is all control registers and control inputs of a part, with what its control outputs are;
// where data decide, these can differ by the data. Data and counters are cells beside it; a counter
// at its margin or below is part of the state.
// A transition says what a clock, or inputs that moved, make of a state and of the cells. The model
// is asked once: with several sets of marks in the cells, so that it shows which bit goes where.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace mmcs {

class Part;
struct State;

constexpr int kMarks = 16;  // sets of them
constexpr size_t kMostCells = 32;
constexpr size_t kMostBytes = 256;  // of control registers

// A register or port that is data, or a counter.
struct Cell {
  uint32_t mask;
  int margin;  // of a counter that is control at some values, else -1
  bool counter, in, out;
  bool decides;     // in the situations that parts.toml names
  uint64_t driven;  // an input of all ones while this control input is 0; or 0
};

// Bits of one cell that another one gets: rotated, masked.
struct Copy {
  uint8_t to, from, left;
  uint32_t keep, value, mask;  // of its own bits; constants, and what is inverted; of the other's

  uint32_t apply(uint32_t own, uint32_t other) const {
    return (own & keep) ^ value ^ ((other << left | other >> (-left & 31)) & mask);
  }
};
struct Count {
  uint8_t cell;
  int8_t margin;  // the cell's
  uint32_t by, mask;
};

// What a transition is before its place in memory is known.
struct Draft {
  bool rests = false, near = false, tells = true;
  bool computed = false;  // a cell became what no other one was: there is no such transition
  uint32_t sources = 0;
  std::vector<Copy> copies;
  std::vector<Count> counts;
  std::vector<Copy> shown;
};

// A hit touches little memory: copies and counts lie right behind the transition.
struct Transition {
  uint64_t in = 0;             // the inputs that lead to it
  State *to = nullptr;         // null: data decide, or the model computes what becomes of them
  Transition *next = nullptr;  // another one from the same state
  union {
    State *other = nullptr;  // the same, with other counters at their margin
    Transition *cases;       // where data decide: by their values
  };
  uint32_t sources = 0;                                    // data inputs that it looks at
  uint8_t copy_count = 0, out_count = 0, count_count = 0;  // out: copies to outputs, the first
  uint8_t shown_count = 0;
  bool decided : 1;  // by data: its cases are
  bool is_case : 1;  // one of them
  bool rests : 1;    // from a state to itself, and it may go on
  bool near : 1;     // a counter may come to its margin, or from it
  bool tells : 1;    // outputs that somebody looks at move
  bool moves : 1;    // it has copies or counts
  bool swaps : 1;    // a copy reads what one before it writes

  template <class T>
  struct Span {
    const T *first, *last;
    const T *begin() const { return first; }
    const T *end() const { return last; }
  };
  Span<Copy> copies() const {
    const Copy *first = reinterpret_cast<const Copy *>(this + 1);
    return {first, first + copy_count};
  }
  Span<Count> counts() const {
    const Count *first = reinterpret_cast<const Count *>(copies().last);
    return {first, first + count_count};
  }
  // Of data inputs to outputs, if these have moved, too.
  Span<Copy> shown() const {
    const Copy *first = reinterpret_cast<const Copy *>(counts().last);
    return {first, first + shown_count};
  }
};

struct State {
  uint64_t in, out;  // control inputs and outputs
  uint64_t near;     // a byte each counter with a margin: its value, or one above it
  Transition *clock = nullptr;
  Transition *same = nullptr;    // when data inputs alone move
  Transition *inputs = nullptr;  // by what they become: a list
  // So many clocks tell nothing; then it rests for good. -1: not known yet, or by its cells.
  int16_t quiet = -1;
  bool ends = false;
  bool rests = false, still = false;  // a clock copies nothing; and nothing counts
  Transition *ahead = nullptr;        // these clocks as one transition, if they are more than one
  Transition *told = nullptr;         // with the one after them, which tells something

  uint8_t *registers() { return reinterpret_cast<uint8_t *>(this + 1); }
};

class Cache {
 public:
  Cache(std::vector<Cell> cells, size_t register_bytes);

  // The state of these registers, and of these outputs if they are given; made if it is new.
  State *find(const uint8_t *registers, uint64_t near, uint64_t in, const uint64_t *out);
  State *make(const uint8_t *registers, uint64_t near, uint64_t in, uint64_t out);
  Transition *add(const Draft &draft, uint64_t in, State *to);
  // From what the marks became: the copies and counts of a transition; false: it is none.
  // before, data, after: by mark, then by cell; data: when data inputs alone have moved. fixed:
  // cells that had no marks.
  struct Seen {
    uint32_t before[kMostCells], data[kMostCells], after[kMostCells];
  };
  bool explain(const std::vector<Seen> &seen, uint32_t fixed, bool clock, Draft *t) const;
  // The values of the cells that may decide.
  uint64_t values(const uint32_t *cells) const {
    uint64_t all = 0;
    for (size_t c : deciding_) all = all << 16 | cells[c];
    return all;
  }
  const std::vector<size_t> &deciding() const { return deciding_; }
  uint32_t mark(int set, size_t cell) const { return marks_[static_cast<size_t>(set)][cell]; }

  uint64_t near(const uint32_t *cells) const {
    uint64_t all = 0;
    int place = 0;
    for (size_t c : margins_) {
      const uint32_t top = static_cast<uint32_t>(cells_[c].margin) + 1;
      all |= static_cast<uint64_t>(cells[c] < top ? cells[c] : top) << place;
      place += 8;
    }
    return all;
  }
  // Those cells that have no marks in a state.
  uint32_t fixed(uint64_t near, uint64_t in) const;

  bool full() const { return bytes_ > kFull; }
  void clear();

  const std::vector<Cell> &cells() const { return cells_; }
  size_t bytes() const { return bytes_; }
  size_t states() const { return states_.size(); }

 private:
  static constexpr size_t kFull = size_t{4} << 20;
  struct Source {
    uint8_t cell, bit;
    bool flip, constant;
  };
  void make_marks();

  const std::vector<Cell> cells_;
  const size_t register_bytes_;
  std::vector<size_t> margins_, deciding_;  // cells with a margin; that decide
  std::vector<std::vector<uint32_t>> marks_;
  std::unordered_map<uint32_t, Source> sources_;  // by what a bit was in each set of marks
  // Memory that is given back as a whole.
  void *take(size_t bytes);
  static constexpr size_t kLine = 64, kChunk = size_t{1} << 16;
  std::vector<std::unique_ptr<char[]>> chunks_;
  char *free_ = nullptr;
  size_t room_ = 0;
  std::unordered_multimap<uint64_t, State *> states_;
  size_t bytes_ = 0;
};

}  // namespace mmcs
