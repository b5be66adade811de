// SPDX-License-Identifier: Apache-2.0
// How often a part begins a clock, or follows its inputs, in which state: for
// studies/bench/usual.py, which has fast.cpp compiled with MMCS_RECORD. Written at the program's
// end into the folder that the variable MMCS_RECORD names.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

namespace mmcs {
namespace {

class Record {
 public:
  ~Record() {
    const char *folder = std::getenv("MMCS_RECORD");
    if (!folder) return;
    std::FILE *f = std::fopen((std::string(folder) + "/" MMCS_TEXT(MMCS_MODEL)).c_str(), "w");
    if (!f) return;
    for (const auto &[state, times] : times_) {
      for (unsigned value : state) std::fprintf(f, "%x ", value);
      std::fprintf(f, "%ld\n", times);
    }
    std::fclose(f);
  }
  void add(unsigned kind, const MMCS_ROOT *root) {
    std::vector<unsigned> state = {kind};
#define MMCS_MEMBER(net) state.push_back(root->net);
#include MMCS_MEMBERS_OF
#undef MMCS_MEMBER
    ++times_[state];
  }

 private:
  std::map<std::vector<unsigned>, long> times_;
};
Record record;

}  // namespace
}  // namespace mmcs
