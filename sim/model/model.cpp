// SPDX-License-Identifier: Apache-2.0
// What all builds of the machine share, and the registers by name.

#include "model.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

#include "wires.h"

namespace mmcs {
namespace {

#include "boards.inc"

std::vector<Register> all() {
  std::vector<Register> found;
  for (size_t n = 0; n < kWires.boards.size(); ++n) {
    const BoardTable &table = board_table(kWires.boards[n].module);
    for (size_t row = 0; row < table.registers.size(); ++row) {
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

int Model::cards() {
  return kWires.cards;
}

int Model::clk_hz() {
  return MMCS_CLK_HZ;
}

uint64_t Model::digest() {
  uint64_t hash = 0xCBF29CE484222325ull;
  for (size_t reg = 0; reg < registers().size(); ++reg) {
    hash = (hash ^ read(static_cast<int>(reg))) * 0x100000001B3ull;
  }
  for (size_t reg = 0; own_card_ && reg < own_card_->size(); ++reg) {
    hash = (hash ^ own_card_->read(reg)) * 0x100000001B3ull;
  }
  return hash;
}

std::vector<uint8_t> Model::save() {
  const std::vector<uint64_t> pins = pins_.save();
  std::vector<uint64_t> words = {static_cast<uint64_t>(clock_), lines_, registers().size(),
                                 pins.size()};
  for (size_t reg = 0; reg < registers().size(); ++reg) {
    words.push_back(read(static_cast<int>(reg)));
  }
  words.insert(words.end(), pins.begin(), pins.end());
  for (size_t reg = 0; own_card_ && reg < own_card_->size(); ++reg) {
    words.push_back(own_card_->read(reg));
  }
  std::vector<uint8_t> bytes(words.size() * sizeof words[0]);
  std::memcpy(bytes.data(), words.data(), bytes.size());
  return bytes;
}

void Model::restore(const std::vector<uint8_t> &bytes) {
  constexpr size_t kHead = 4;
  std::vector<uint64_t> words(bytes.size() / sizeof(uint64_t));
  if (!words.empty()) std::memcpy(words.data(), bytes.data(), words.size() * sizeof words[0]);
  if (words.size() < kHead || words[2] != registers().size() || words[2] > words.size() - kHead ||
      words[3] != words.size() - kHead - words[2] - (own_card_ ? own_card_->size() : 0)) {
    throw std::invalid_argument("a snapshot of another machine");
  }
  const auto begin = words.begin() + kHead;
  const auto middle = begin + static_cast<std::ptrdiff_t>(words[2]);
  const auto card = middle + static_cast<std::ptrdiff_t>(words[3]);
  put_back({static_cast<int64_t>(words[0]),
            static_cast<unsigned>(words[1]),
            {begin, middle},
            {middle, card},
            {card, words.end()}});
}

}  // namespace mmcs
