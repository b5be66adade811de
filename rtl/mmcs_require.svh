// SPDX-License-Identifier: Apache-2.0
// MMCS_REQUIRE(name, cond, text): a parameter that breaks `cond` stops the build with a sentence.

`ifndef MMCS_REQUIRE_SVH
`define MMCS_REQUIRE_SVH

// Elaboration tasks where the tool has them; Icarus 11 has not and stops at time 0.
`ifdef __ICARUS__
  `define MMCS_REQUIRE(name, cond, text) \
    initial begin : name \
      if (!(cond)) $fatal(1, "%m: %s", text); \
    end
`else
  `define MMCS_REQUIRE(name, cond, text) \
    if (!(cond)) begin : name \
      $error(text); \
    end
`endif

`endif
