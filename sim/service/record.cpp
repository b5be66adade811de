// SPDX-License-Identifier: Apache-2.0
// The lines of log.csv, for every carrier.

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

}  // extern "C"
