// SPDX-License-Identifier: Apache-2.0
// The exports of a library of cards of one's own (own_card.h). Compiled behind the code that
// Verilator made of the cards, and fast.cpp.

#include "own_card.h"

namespace mmcs {

std::unique_ptr<Board> create_Vcard(VerilatedContext &context, const std::string &name);

namespace {

// A register, or each element of an array; of one of more than 64 bits, each word.
void add(const CardRow &row, const Net &net, CardModel *model) {
  const std::string name = *row.path ? std::string(row.path) + "." + row.name : row.name;
  const int words = net.entry > 8 ? net.entry / 4 : 1, bytes = net.entry / words;
  for (int at = 0; at < net.bytes; at += net.entry) {
    for (int word = 0; word < words; ++word) {
      Net one = net;
      one.at += at + word * bytes;
      one.bytes = one.entry = bytes;
      if (words > 1) one.width = word + 1 < words ? 32 : net.width - 32 * word;
      std::string full = name;
      if (net.bytes > net.entry) full += "[" + std::to_string(at / net.entry) + "]";
      if (words > 1) full += "[" + std::to_string(32 * word) + "+:32]";
      model->registers.emplace_back(full, one);
    }
  }
}

const CardModel &listed() {
  static const CardModel *const model = mmcs_card_create();
  return *model;
}

}  // namespace

#define MMCS_EXPORT extern "C" __attribute__((visibility("default")))

MMCS_EXPORT CardModel *mmcs_card_create() {
  auto model = std::make_unique<CardModel>();
  model->context = create_context(0);
  model->board = create_Vcard(*model->context, "CARD");
  for (const CardRow *at = kCardRows; at->name; ++at) {
    const CardRow &row = *at;
    const std::string inner = *row.path ? std::string(".") + row.path : "";
    const Net net = find_net(*model->context, "CARD.mmcs_card" + inner, row.name);
    if (!net && row.must) return nullptr;
    if (net) add(row, net, model.get());
  }
  return model.release();
}

MMCS_EXPORT void mmcs_card_destroy(CardModel *model) {
  use(model->context);  // which its end looks for, and another card's may be there
  delete model;
}

MMCS_EXPORT const char *mmcs_card_register_name(int n) {
  const auto &found = listed().registers;
  return n < 0 || n >= static_cast<int>(found.size()) ? nullptr : found[n].first.c_str();
}

}  // namespace mmcs
