// SPDX-License-Identifier: Apache-2.0
// What run.mmcs and log.csv say of a log, for every carrier.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

#include "mmcs_service.h"
#include "mmcs_sim.h"

namespace {

constexpr int64_t kMostGroups = 1024, kMostMarks = 8, kMostPoints = 32;

struct Tables {
  uint32_t of[8][256];  // of a byte with so many others behind it
  constexpr Tables() : of() {
    for (uint32_t n = 0; n < 256; ++n) {
      uint32_t rest = n;
      for (int bit = 0; bit < 8; ++bit) rest = (rest & 1 ? 0xedb88320 : 0) ^ rest >> 1;
      of[0][n] = rest;
    }
    for (int k = 1; k < 8; ++k)
      for (int n = 0; n < 256; ++n) of[k][n] = of[0][of[k - 1][n] & 0xff] ^ of[k - 1][n] >> 8;
  }
};
constexpr Tables kTables;

std::string base64(const std::string &bytes) {
  const char *letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t at = 0; at < bytes.size(); at += 3) {
    uint32_t three = 0;
    for (size_t n = at; n < at + 3; ++n)
      three = three << 8 | (n < bytes.size() ? static_cast<unsigned char>(bytes[n]) : 0);
    for (size_t n = 0; n < 4; ++n)
      out += at + n > bytes.size() ? '=' : letters[three >> (18 - 6 * n) & 63];
  }
  return out;
}

}  // namespace

// CRC-32 as zlib has it, of doubles.
class Crc {
 public:
  void take(uint64_t word) {
    word ^= rest_;
    rest_ = 0;
    for (int n = 0; n < 8; ++n) rest_ ^= kTables.of[7 - n][word >> 8 * n & 0xff];
  }
  uint32_t value() const { return ~rest_; }

 private:
  uint32_t rest_ = ~0u;
};

struct mmcs_digests {
  int64_t each;
  std::vector<int64_t> marks;
  std::vector<Crc> columns;
  Crc group;
  int64_t taken = 0;
  size_t marked = 0;
  std::string of_groups, of_columns, told;

  void mark() {
    for (; marked < marks.size() && marks[marked] == taken; ++marked)
      for (const Crc &column : columns) {
        of_columns += static_cast<char>(column.value());
        of_columns += static_cast<char>(column.value() >> 8);
      }
  }
  void end_group() {
    of_groups += static_cast<char>(group.value());
    group = {};
  }
  void take(const double *row) {
    mark();
    for (Crc &column : columns) {
      uint64_t word;
      std::memcpy(&word, row++, sizeof word);
      column.take(word);
      group.take(word);
    }
    if (++taken % each == 0) end_group();
  }
};

extern "C" {

mmcs_digests *mmcs_digests_create(int32_t columns, int64_t rows, int64_t each, const int64_t *marks,
                                  int32_t count) {
  std::vector<int64_t> at;
  if (count) at.assign(marks, marks + count);
  for (int64_t n = 1; !each && rows && n <= kMostMarks; ++n) at.push_back(rows * n / kMostMarks);
  if (!each) each = std::max<int64_t>(1, (rows + kMostGroups - 1) / kMostGroups);
  std::vector<Crc> none(static_cast<size_t>(columns));
  return new mmcs_digests{each, at, none, {}, 0, 0, "", "", ""};
}

void mmcs_digests_destroy(mmcs_digests *digests) {
  delete digests;
}

void mmcs_digests_take(mmcs_digests *digests, const double *rows, int64_t count) {
  for (; count > 0; --count, rows += digests->columns.size()) digests->take(rows);
}

const char *mmcs_digests_told(mmcs_digests *my, const mmcs_checkpoint *points, int32_t count) {
  my->mark();
  if (my->taken % my->each) my->end_group();
  const int64_t keep = std::max<int64_t>(1, (count + kMostPoints - 1) / kMostPoints);
  std::string kept, marks;
  for (int64_t n = keep - 1; n < count; n += keep)
    kept.append(reinterpret_cast<const char *>(points + n), sizeof *points);
  for (const int64_t mark : my->marks) marks += (marks.empty() ? "" : ",") + std::to_string(mark);
  my->told = R"({"checkpoints":")" + base64(kept) + R"(","rows_each":)" + std::to_string(my->each) +
             R"(,"rows":")" + base64(my->of_groups) + R"(","marks":[)" + marks +
             R"(],"columns":")" + base64(my->of_columns) + "\"}";
  return my->told.c_str();
}

const char *mmcs_log_lines(int32_t columns, const double *rows, int64_t count) {
  static thread_local std::string out;
  const std::string all = MMCS_SIM_LOG_FIELDS;
  const auto fields = static_cast<int>(std::count(all.begin(), all.end(), ' ') + 1);
  out = count ? "" : "t_s";
  for (int axis = 0; !count && axis < columns / fields; ++axis) {
    std::istringstream names(all);
    for (std::string name; names >> name;) out += "," + name + "_" + std::to_string(axis);
  }
  for (int64_t row = 0; row < count; ++row, rows += columns) {
    if (row) out += '\n';
    for (int n = 0; n < columns; ++n) {  // whole numbers, but for times and angles
      if (n) out += ',';
      char text[340];
      if (n % fields == 0 || std::fabs(rows[n]) >= 1e18)
        std::snprintf(text, sizeof text, n == 0 ? "%.6f" : "%.9f", rows[n]);
      else
        std::snprintf(text, sizeof text, "%lld", static_cast<long long>(rows[n]));
      out += text;
    }
  }
  out += '\n';
  return out.c_str();
}

}  // extern "C"
