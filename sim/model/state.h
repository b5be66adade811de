// SPDX-License-Identifier: Apache-2.0
// What a snapshot of the hardware holds: registers in the order of registers(), so that every build
// understands it, and the pins.
#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace mmcs {

struct Saved {
  int64_t clock = 0;
  uint64_t lines = 0;
  std::vector<uint64_t> registers, pins;

  std::vector<uint8_t> pack() const {
    std::vector<uint64_t> words = {static_cast<uint64_t>(clock), lines, registers.size(),
                                   pins.size()};
    words.insert(words.end(), registers.begin(), registers.end());
    words.insert(words.end(), pins.begin(), pins.end());
    std::vector<uint8_t> bytes(words.size() * sizeof words[0]);
    std::memcpy(bytes.data(), words.data(), bytes.size());
    return bytes;
  }

  static Saved unpack(const std::vector<uint8_t> &bytes) {
    constexpr size_t kHead = 4, kWord = sizeof(uint64_t);
    uint64_t head[kHead];
    if (bytes.size() < sizeof head) throw std::invalid_argument("a snapshot of another machine");
    std::memcpy(head, bytes.data(), sizeof head);
    const size_t room = bytes.size() / kWord - kHead;
    if (head[2] > room || head[3] > room - head[2]) {
      throw std::invalid_argument("a snapshot of another machine");
    }
    const size_t count = head[2] + head[3];
    std::vector<uint64_t> words(count);
    if (count) std::memcpy(words.data(), bytes.data() + sizeof head, count * kWord);
    Saved state;
    state.clock = static_cast<int64_t>(head[0]);
    state.lines = head[1];
    const auto middle = words.begin() + static_cast<std::ptrdiff_t>(head[2]);
    state.registers.assign(words.begin(), middle);
    state.pins.assign(middle, words.end());
    return state;
  }
};

}  // namespace mmcs
