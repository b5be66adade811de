/* SPDX-License-Identifier: Apache-2.0 */
/* The two functions that a freestanding compiler calls by itself. */
#include <stddef.h>
#include <stdint.h>

void *memcpy(void *to, const void *from, size_t len);
void *memset(void *to, int value, size_t len);

/* Longwords while both ends are even: the 68020 takes any even address. */
void *memcpy(void *to, const void *from, size_t len) {
  uint8_t *out = to;
  const uint8_t *in = from;
  if ((((uintptr_t)out | (uintptr_t)in) & 3) == 0) {
    for (; len >= 4; len -= 4, out += 4, in += 4) *(uint32_t *)out = *(const uint32_t *)in;
  }
  while (len-- > 0) *out++ = *in++;
  return to;
}

void *memset(void *to, int value, size_t len) {
  uint8_t *out = to;
  uint32_t word = (uint8_t)value * 0x01010101u;
  if (((uintptr_t)out & 3) == 0) {
    for (; len >= 4; len -= 4, out += 4) *(uint32_t *)out = word;
  }
  while (len-- > 0) *out++ = (uint8_t)value;
  return to;
}
