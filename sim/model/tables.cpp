// SPDX-License-Identifier: Apache-2.0
// See tables.h.

#include "tables.h"

#include <algorithm>
#include <stdexcept>

#include "wires.h"

namespace mmcs {
namespace {

#define MMCS_COUNT(a) (sizeof(a) / sizeof((a)[0]))
#include "boards.inc"

std::vector<Register> all() {
  std::vector<Register> found;
  for (size_t n = 0; n < kWires.boards.size(); ++n) {
    const BoardTable &table = board_table(kWires.boards[n].module);
    for (size_t row = 0; row < table.register_count; ++row) {
      const RegisterRow &r = table.registers[row];
      std::string name = std::string(kWires.boards[n].path) + ".";
      if (*r.path) name += std::string(r.path) + ".";
      found.push_back({name + r.name, r.width, static_cast<int>(n), static_cast<int>(row)});
    }
  }
  return found;
}

}  // namespace

const BoardTable &board_table(const std::string &module) {
  for (const BoardTable &table : kBoards) {
    if (module == table.module) return table;
  }
  throw std::runtime_error("no model of the board " + module);
}

const std::vector<Register> &registers() {
  static const std::vector<Register> found = all();
  return found;
}

int find_register(const std::string &name) {
  const auto &list = registers();
  const auto at =
      std::find_if(list.begin(), list.end(), [&name](const Register &r) { return r.name == name; });
  return at == list.end() ? -1 : static_cast<int>(at - list.begin());
}

}  // namespace mmcs
