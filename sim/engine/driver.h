// SPDX-License-Identifier: Apache-2.0
// The mc driver's interface, which is C, as C++ wants to see it.
#pragma once

extern "C" {
#include "mc.h"
}
