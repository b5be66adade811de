/* SPDX-License-Identifier: Apache-2.0 */
/* The test program: `prog` lists its tests, `prog name` runs one; exit status 1 says it failed. */
#ifndef HARNESS_H
#define HARNESS_H

#if __STDC_HOSTED__
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#else
#include "free/libc.h"
#endif

extern int test_argc;
extern char **test_argv;

#define COUNT(array) (sizeof(array) / sizeof *(array))

struct test {
  const char *name;
  void (*run)(void);
};

#define CHECK(condition)                                               \
  do {                                                                 \
    if (!(condition)) {                                                \
      printf("%s:%d: not true: %s\n", __FILE__, __LINE__, #condition); \
      exit(1);                                                         \
    }                                                                  \
  } while (0)

#define CHECK_EQ(got, want)                                                                      \
  do {                                                                                           \
    long long got_ = (long long)(got), want_ = (long long)(want);                                \
    if (got_ != want_) {                                                                         \
      printf("%s:%d: %s is %lld (0x%llx), want %lld (0x%llx)\n", __FILE__, __LINE__, #got, got_, \
             (unsigned long long)got_, want_, (unsigned long long)want_);                        \
      exit(1);                                                                                   \
    }                                                                                            \
  } while (0)

/* A row of the linker's section `tests`, all of which main() sees; then the requirements shown. */
#define TEST(name, ...)                                                                        \
  static void name(void);                                                                      \
  static const struct test name##_row __attribute__((used, section("tests"))) = {#name, name}; \
  static void name(void)

#endif
