// SPDX-License-Identifier: Apache-2.0
// Refuses parameters that no machine can have, in one sentence each.
#pragma once

#include "plant.h"

namespace mmcs {

// Throws std::invalid_argument.
void check_parameters(const mmcs_config &config, const mmcs_motor *motors, const mmcs_link *links,
                      int clks_per_step, int min_gap);

}  // namespace mmcs
