// SPDX-License-Identifier: Apache-2.0
// MMCS_RULE(index, name, cond, text): one rule of a bus checker.

`ifndef MMCS_RULE_SVH
`define MMCS_RULE_SVH
`include "mmcs_assert.svh"

// Contract: the checker declares `bit Stop`, `logic [N-1:0] bad`, and gathers `bad` in its sticky
// output. With Stop a broken rule ends the simulation (or is a property to prove); without, the
// caller reads the bits: tests of the checkers, and proofs that assume a rule.
`define MMCS_RULE(index, name, cond, text) \
  assign bad[index] = !(cond); \
  if (Stop) begin : g_``name \
    `MMCS_ASSERT(name, !bad[index], text) \
  end

`endif
