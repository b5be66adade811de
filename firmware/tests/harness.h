/* SPDX-License-Identifier: Apache-2.0 */
/* A test program: `prog` lists its tests, `prog name` runs one; exit status 1 says it failed. */
#ifndef HARNESS_H
#define HARNESS_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

static inline int run_tests(const struct test *tests, int n, int argc, char **argv) {
  for (int i = 0; i < n; i++) {
    if (argc < 2) {
      puts(tests[i].name);
    } else if (strcmp(argv[1], tests[i].name) == 0) {
      tests[i].run();
      return 0;
    }
  }
  return argc < 2 ? 0 : 2;
}

#define MAIN(tests)                                                             \
  int main(int argc, char **argv) {                                             \
    return run_tests(tests, (int)(sizeof tests / sizeof tests[0]), argc, argv); \
  }

#endif
