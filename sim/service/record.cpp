// SPDX-License-Identifier: Apache-2.0
// The lines of log.csv and bus.csv, for every carrier.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>

#include "mmcs_service.h"
#include "mmcs_sim.h"

extern "C" {

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

const char *mmcs_bus_lines(const mmcs_bus_cycle *cycles, int64_t count) {
  static constexpr const char *kKind[] = {"read", "write", "acknowledge"};
  static constexpr const char *kStrobes[] = {"", "DS0", "DS1", "DS0+DS1"};
  static constexpr const char *kAnswer[] = {"DTACK", "none", "BERR"};
  static thread_local std::string out;
  out = count ? "" : "begin_clock,end_clock,cycle,address,am,strobes,data,answer\n";
  for (const mmcs_bus_cycle *c = cycles; c != cycles + count; ++c) {
    char text[120];
    std::snprintf(text, sizeof text, "%lld,%lld,%s,%04X,%02X,%s,%04X,%s\n",
                  static_cast<long long>(c->begin), static_cast<long long>(c->end), kKind[c->kind],
                  c->address, static_cast<unsigned>(c->am), kStrobes[c->strobes], c->data,
                  kAnswer[c->answer]);
    out += text;
  }
  return out.c_str();
}

}  // extern "C"
