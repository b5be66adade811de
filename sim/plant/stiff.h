// SPDX-License-Identifier: Apache-2.0
// Whether an arm can be integrated in steps of kStep at all: its links must be bodies, and no
// flexible joint may swing faster than the steps can follow, in any pose.
#pragma once

#include <string>

#include "mmcs_sim.h"

namespace mmcs {

// Throws std::invalid_argument with one sentence.
void check_arm(const mmcs_config &config, const mmcs_motor *motors, const mmcs_link *links);

// One sentence about links that can be integrated but that no body is, as published ones may be;
// empty if there is none.
std::string arm_caution(const mmcs_link *links, int count);

}  // namespace mmcs
