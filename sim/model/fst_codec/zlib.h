// SPDX-License-Identifier: Apache-2.0
// The call of zlib that FST tracing needs, for machines without the library's headers.
// Output is a valid zlib stream of stored blocks; FST then keeps the smaller, uncompressed form.
#pragma once

#include <cstdint>
#include <cstring>

using Bytef = unsigned char;
using uLong = unsigned long;
using uLongf = unsigned long;
enum { Z_OK = 0, Z_BUF_ERROR = -5 };

inline uLong compressBound(uLong size) {
  return size + 5 * (size / 65535 + 1) + 6;
}

inline int compress2(Bytef *out, uLongf *out_size, const Bytef *in, uLong size, int) {
  if (*out_size < compressBound(size)) return Z_BUF_ERROR;
  Bytef *const begin = out;
  *out++ = 0x78;
  *out++ = 0x01;
  uint32_t a = 1, b = 0;  // Adler-32
  uLong at = 0;
  do {
    const uLong block = size - at < 65535 ? size - at : 65535;
    *out++ = at + block == size;
    *out++ = static_cast<Bytef>(block & 255);
    *out++ = static_cast<Bytef>(block >> 8);
    *out++ = static_cast<Bytef>(~block & 255);
    *out++ = static_cast<Bytef>(~block >> 8 & 255);
    std::memcpy(out, in + at, block);
    for (uLong i = 0; i < block; ++i) {
      a = (a + in[at + i]) % 65521;
      b = (b + a) % 65521;
    }
    out += block;
    at += block;
  } while (at < size);
  for (int shift = 8; shift >= 0; shift -= 8) *out++ = static_cast<Bytef>(b >> shift);
  for (int shift = 8; shift >= 0; shift -= 8) *out++ = static_cast<Bytef>(a >> shift);
  *out_size = static_cast<uLongf>(out - begin);
  return Z_OK;
}
