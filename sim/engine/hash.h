// SPDX-License-Identifier: Apache-2.0
// The running hash of a simulation and the random numbers that it may use: integers only, so that
// every machine agrees.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace mmcs {

// FNV-1a over 64-bit words, with a shift so that high bits come down.
class Hash {
 public:
  void add(uint64_t word) {
    state_ = (state_ ^ word) * 0x100000001B3ull;
    state_ ^= state_ >> 29;
  }
  void add(double value) {
    uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    add(bits);
  }
  uint64_t value() const { return state_; }

 private:
  uint64_t state_ = 0xCBF29CE484222325ull;
};

// Of bytes: eight at a time, then what is left.
inline uint64_t digest(const uint8_t *data, size_t size) {
  Hash hash;
  size_t at = 0;
  for (; at + 8 <= size; at += 8) {
    uint64_t word;
    std::memcpy(&word, data + at, 8);
    hash.add(word);
  }
  for (; at < size; ++at) hash.add(uint64_t{data[at]});
  return hash.value();
}

// SplitMix64.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  uint64_t next() {
    uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }
  // 0..limit, both included.
  int64_t upto(int64_t limit) {
    return limit <= 0 ? 0 : static_cast<int64_t>(next() % (static_cast<uint64_t>(limit) + 1));
  }

 private:
  uint64_t state_;
};

}  // namespace mmcs
