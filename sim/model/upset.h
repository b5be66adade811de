// SPDX-License-Identifier: Apache-2.0
// Registers that a particle may hit, by the names that Verilator gives them.
//
// Written from the RTL side they would have a second driver. Here they are written between clocks;
// the caller then has the logic behind them worked out anew.
#pragma once

#include "model.h"

#include "Vmmcs___024root.h"

namespace mmcs {

template <typename T>
void flip(T &value, unsigned bits) {
  value = static_cast<T>(value ^ bits);
}

// clang-format off
#if MMCS_SOC
#define MMCS_MACHINE(name) mmcs_sim_top__DOT__u_soc__DOT__u_mmcs__DOT__##name
#else
#define MMCS_MACHINE(name) mmcs_sim_top__DOT__u_mmcs__DOT__##name
#endif
#define MMCS_CORE(name) MMCS_MACHINE(u_adaptor__DOT__u_core__DOT__##name)
#define MMCS_AXIS(card, joint, name) \
  MMCS_MACHINE(g_card__BRA__##card##__KET____DOT__u_card__DOT__##\
g_axis__BRA__##joint##__KET____DOT__u_axis__DOT__##name)
#define MMCS_UPSET_AXIS(c, j) \
  if (axis == 2 * (c) + (j)) { \
    if (reg == Register::kEncoder) flip(r.MMCS_AXIS(c, j, u_encoder__DOT__count_q), bits); \
    if (reg == Register::kDacRank1) flip(r.MMCS_AXIS(c, j, u_dac__DOT__rank1_q), bits); \
    if (reg == Register::kDacRank2) flip(r.MMCS_AXIS(c, j, u_dac__DOT__rank2_q), bits); \
    if (reg == Register::kIndexLatch) flip(r.MMCS_AXIS(c, j, index_latch_q), bits); \
    if (reg == Register::kHeartbeat) flip(r.MMCS_AXIS(c, j, u_heartbeat__DOT__run_q), bits); \
  }
#define MMCS_UPSET_CARD(card) MMCS_UPSET_AXIS(card, 0) MMCS_UPSET_AXIS(card, 1)

inline void flip_register(Vmmcs___024root &r, Register reg, int axis, unsigned bits) {
  if (reg == Register::kPccsr) flip(r.MMCS_CORE(u_pccsr__DOT__csr_q), bits);
  if (reg == Register::kVector) flip(r.MMCS_CORE(vector_q), bits);
  if (reg == Register::kPccsr || reg == Register::kVector) return;
  r.MMCS_MACHINE(settle_q) = 7;  // no card sleeps through it
  MMCS_UPSET_CARD(0)
#if MMCS_CARDS > 1
  MMCS_UPSET_CARD(1)
#endif
#if MMCS_CARDS > 2
  MMCS_UPSET_CARD(2)
#endif
#if MMCS_CARDS > 3
  MMCS_UPSET_CARD(3)
#endif
#if MMCS_CARDS > 4
  MMCS_UPSET_CARD(4)
#endif
#if MMCS_CARDS > 5
  MMCS_UPSET_CARD(5)
#endif
#if MMCS_CARDS > 6
  MMCS_UPSET_CARD(6)
#endif
#if MMCS_CARDS > 7
  MMCS_UPSET_CARD(7)
#endif
#if MMCS_CARDS > 8
  MMCS_UPSET_CARD(8)
#endif
#if MMCS_CARDS > 9
  MMCS_UPSET_CARD(9)
#endif
#if MMCS_CARDS > 10
  MMCS_UPSET_CARD(10)
#endif
#if MMCS_CARDS > 11
  MMCS_UPSET_CARD(11)
#endif
#if MMCS_CARDS > 12
  MMCS_UPSET_CARD(12)
#endif
#if MMCS_CARDS > 13
  MMCS_UPSET_CARD(13)
#endif
#if MMCS_CARDS > 14
  MMCS_UPSET_CARD(14)
#endif
#if MMCS_CARDS > 15
  MMCS_UPSET_CARD(15)
#endif
}
// clang-format on

}  // namespace mmcs
