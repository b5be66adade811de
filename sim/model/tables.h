// SPDX-License-Identifier: Apache-2.0
// The tables that generate.py makes of the boards: rows name what the model then finds by name.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace mmcs {

struct RegisterRow {
  const char *path, *name;  // path: of the instance, within the board
  int width;
  int unit;
  int strides[2];      // of a counter, that goes down; else 0
  int margin;          // it comes to this value and below by real clocks
  const char *unless;  // the register beside it must be 0
  bool awake;          // while it is not 0, its unit does not rest
};
// A net that a unit at rest watches; quiet: it does not look at it, always or under a guard.
struct NetRow {
  const char *path, *name;
  int unit;
  bool quiet;
  int guard;
};
struct GuardRow {
  const char *path, *name;
  int unit, guard, value;
};
struct PortRow {
  const char *name;
  int width;
  bool out;
  bool heard;  // only while the decoder says so
  int quiet;   // at rest it is not looked at
};
// A port of a chip on a wire of its board.
struct LinkRow {
  const char *name;
  bool out;
};
// Unit 0 is the board less its chips; the others are chips, each a model of its own.
struct UnitRow {
  const char *path, *module;
  const LinkRow *links;
  size_t link_count;
};
struct BoardTable {
  const char *module;
  const RegisterRow *registers;
  const NetRow *nets;
  const GuardRow *guards;
  const PortRow *ports;
  const UnitRow *units;
  size_t register_count, net_count, guard_count, port_count, unit_count;
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
