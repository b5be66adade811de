/* SPDX-License-Identifier: Apache-2.0 */
/* The tests of all files of this folder as one program: see harness.h. */
#include "harness.h"

#include "mock.h"

extern const struct test __start_tests[], __stop_tests[];

int test_argc;
char **test_argv;

int main(int argc, char **argv) {
  test_argc = argc;
  test_argv = argv;
  for (const struct test *test = __start_tests; test < __stop_tests; test++) {
    if (argc < 2) {
      puts(test->name);
    } else if (strcmp(argv[1], test->name) == 0) {
      test->run();
#if __STDC_HOSTED__
      printf("%04x\n", (unsigned)(mock_told & 0xFFFF));
#endif
      return 0;
    }
  }
  return argc < 2 ? 0 : 2;
}
