// SPDX-License-Identifier: Apache-2.0
// The two calls of LZ4 that FST tracing needs, for machines without the library's headers: a block
// of literals alone. FST keeps waveforms uncompressed then, as the smaller form.
#pragma once

#include <cstring>

inline int LZ4_compressBound(int size) {
  return size + size / 255 + 16;
}

inline int LZ4_compress_default(const char *in, char *out, int size, int) {
  char *const begin = out;
  *out++ = static_cast<char>((size < 15 ? size : 15) << 4);
  int length = size - 15;
  for (; length >= 255; length -= 255) *out++ = static_cast<char>(255);
  if (length >= 0) *out++ = static_cast<char>(length);
  std::memcpy(out, in, static_cast<size_t>(size));
  return static_cast<int>(out + size - begin);
}
