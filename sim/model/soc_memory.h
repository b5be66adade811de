// SPDX-License-Identifier: Apache-2.0
// The memory of the processor in the SoC builds of the model, by the name that Verilator gives it:
// the shortcut for a window that a real computer would go through word by word.
#pragma once

#include <cstdint>

#include "Vmmcs___024root.h"

namespace mmcs {

constexpr unsigned kSocWords = 32768;

// clang-format off
inline uint32_t &soc_word(Vmmcs___024root &r, unsigned index) {
  return r.mmcs_sim_top__DOT__u_soc__DOT__u_host__DOT__u_ram__DOT__memory[index % kSocWords];
}
// clang-format on

}  // namespace mmcs
