// SPDX-License-Identifier: Apache-2.0
// A test program in one header: TEST(name) {...}, CHECK(condition, ...). `program NAME` runs one.
// Included once.
#pragma once

#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <string>

namespace check {

inline std::map<std::string, std::function<void()>> &all() {
  static std::map<std::string, std::function<void()>> tests;
  return tests;
}
inline int failures = 0;

struct Register {
  Register(const char *name, void (*test)()) { all()[name] = test; }
};

}  // namespace check

int main(int argc, char **argv) {
  if (argc != 2 || check::all().count(argv[1]) == 0) {
    std::fprintf(stderr, "usage: %s TEST\n", argv[0]);
    return 2;
  }
  check::all()[argv[1]]();
  return check::failures == 0 ? 0 : 1;
}

#define TEST(name)                                           \
  static void name();                                        \
  static const check::Register register_##name(#name, name); \
  static void name()

// The message is a printf format with its values.
#define CHECK(condition, ...)                                     \
  do {                                                            \
    if (!(condition)) {                                           \
      ++check::failures;                                          \
      std::printf("%s:%d: %s: ", __FILE__, __LINE__, #condition); \
      std::printf(__VA_ARGS__);                                   \
      std::printf("\n");                                          \
    }                                                             \
  } while (0)
