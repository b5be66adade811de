// SPDX-License-Identifier: Apache-2.0
// The two calls of LZ4 that FST tracing needs, for machines without the library's headers.
// Output is the LZ4 block format, found by a greedy search with one hash table.
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

inline int LZ4_compressBound(int size) {
  return size + size / 255 + 16;
}

namespace mmcs_lz4 {

inline char *put_length(char *out, int length) {
  for (; length >= 255; length -= 255) *out++ = static_cast<char>(255);
  *out++ = static_cast<char>(length);
  return out;
}

// One sequence: literals, then a match (match_length 0: none, the last sequence).
inline char *put_sequence(char *out, const char *literals, int count, int offset,
                          int match_length) {
  const int extra = match_length ? match_length - 4 : 0;
  *out++ = static_cast<char>((count < 15 ? count : 15) << 4 | (extra < 15 ? extra : 15));
  if (count >= 15) out = put_length(out, count - 15);
  std::memcpy(out, literals, static_cast<size_t>(count));
  out += count;
  if (match_length) {
    *out++ = static_cast<char>(offset & 255);
    *out++ = static_cast<char>(offset >> 8);
    if (extra >= 15) out = put_length(out, extra - 15);
  }
  return out;
}

inline uint32_t word(const char *at) {
  uint32_t value;
  std::memcpy(&value, at, 4);
  return value;
}

}  // namespace mmcs_lz4

inline int LZ4_compress_default(const char *in, char *out, int size, int) {
  using namespace mmcs_lz4;
  constexpr int kHashBits = 14;
  // The format wants the last 5 bytes as literals and no match to begin in the last 12.
  const int match_end = size - 5, start_end = size - 12;
  std::vector<int> table(size_t{1} << kHashBits, -1);
  char *const begin = out;
  int anchor = 0;
  for (int at = 0; at < start_end;) {
    int &slot = table[(word(in + at) * 2654435761u) >> (32 - kHashBits)];
    const int before = slot;
    slot = at;
    if (before < 0 || at - before > 65535 || word(in + before) != word(in + at)) {
      ++at;
      continue;
    }
    int length = 4;
    while (at + length < match_end && in[before + length] == in[at + length]) ++length;
    out = put_sequence(out, in + anchor, at - anchor, at - before, length);
    at += length;
    anchor = at;
  }
  out = put_sequence(out, in + anchor, size - anchor, 0, 0);
  return static_cast<int>(out - begin);
}
