/* SPDX-License-Identifier: Apache-2.0 */
/* A sample of what `make fuzz` does, where there is no fuzzer: so many damaged copies of the files
 * given, or of nothing, for one of the programs here.
 *
 *   PROGRAM COUNT [FILE...]      prints "COUNT inputs" */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST 65536

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *argc, char ***argv) __attribute__((weak));

static uint64_t state = 1989;

static uint32_t chance(uint32_t below) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (uint32_t)(state >> 33) % below;
}

static size_t damage(uint8_t *data, size_t size) {
  static const uint8_t corners[] = {0, 1, 0x7F, 0x80, 0xFF};
  for (uint32_t n = 1 + chance(4); n > 0; n--) {
    size_t at = size > 0 ? chance((uint32_t)size) : 0;
    uint32_t kind = chance(6);
    if (kind == 0 && size > 1) {
      size = at;
    } else if (kind == 1 && size < MOST) {
      memmove(data + at + 1, data + at, size - at);
      data[at] = (uint8_t)chance(256);
      size++;
    } else if (kind == 2 && size >= 8) {
      memset(data + ((at & ~(size_t)7) + 1) % (size - 7), corners[chance(5)],
             8); /* behind a kind */
    } else if (at < size) {
      data[at] = kind == 3 ? corners[chance(5)] : (uint8_t)(data[at] ^ 1u << chance(8));
    }
  }
  return size;
}

static size_t load(const char *name, uint8_t *data) {
  FILE *file = fopen(name, "rb");
  size_t size = 0;
  if (file != NULL) {
    size = fread(data, 1, MOST, file);
    (void)fclose(file);
  }
  return size;
}

int main(int argc, char **argv) {
  static uint8_t good[MOST], data[MOST + 8];
  long count = argc > 1 ? atol(argv[1]) : 1000;
  size_t size = 16;
  if (LLVMFuzzerInitialize) (void)LLVMFuzzerInitialize(&argc, &argv);
  for (long n = 0; n < count; n++) {
    if (argc > 2) size = load(argv[2 + n % (argc - 2)], good);
    memcpy(data, good, size);
    if (argc <= 2) {
      size = chance(200);
      for (size_t i = 0; i < size; i++) data[i] = (uint8_t)chance(256);
    }
    size_t now = argc > 2 ? damage(data, size) : size;
    (void)LLVMFuzzerTestOneInput(data, now);
  }
  printf("%ld inputs\n", count);
  return 0;
}
