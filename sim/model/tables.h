// SPDX-License-Identifier: Apache-2.0
// The tables that generate.py makes of the boards: rows name what the model then finds by name.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace mmcs {

enum class Kind { kControl, kData, kDecides, kCounter };

struct RegisterRow {
  const char *path, *name;  // path: of the instance, within the board
  int width;
  int part;
  Kind kind;
  int margin;  // of a counter: from this value on down it is control state
};
// Bits of a control register that are data.
struct SliceRow {
  int reg, lsb, width;
  Kind kind;
};
// A port of a part on a net of its board.
struct PortRow {
  const char *path, *name;  // of the variable in the part's model: its own port, or a chip's
  int lsb, width;           // the bits of it
  bool out;
  Kind kind;
  bool selected;  // received only while the card is selected
  int driven;     // all ones while this port of the part is 0; or -1
  int select;     // not read while this port of the part is 1; or -1
  int net;
};
// Part 0 is the board less its chips; the others are chips.
struct PartRow {
  const char *path, *module;
  std::vector<PortRow> ports;
};
// While this net of a part is at this level, data decide.
struct DecideRow {
  const char *path, *name;
  int part;
  bool level;
};
struct BoardTable {
  const char *module;
  std::vector<RegisterRow> registers;
  std::vector<SliceRow> slices;
  std::vector<PartRow> parts;
  std::vector<DecideRow> decides;
};

const BoardTable &board_table(const std::string &module);

// One register of the machine: where it is and how wide. The order is that of the digest.
struct Register {
  std::string name;  // from mmcs down
  int width;
  int board, row;  // in kWires.boards, in the board's table
};
const std::vector<Register> &registers();
int find_register(const std::string &name);  // or -1

}  // namespace mmcs
