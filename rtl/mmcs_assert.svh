// SPDX-License-Identifier: Apache-2.0
// MMCS_ASSERT(name, cond, text): an invariant of registered state, checked on every clock.

`ifndef MMCS_ASSERT_SVH
`define MMCS_ASSERT_SVH

// Contract: the module has clk_i and rst_ni, and `cond` holds at every rising clk_i out of reset.
// In simulation a failure is fatal; MMCS_NO_ASSERT removes the check (speed builds). With FORMAL
// it is a property to prove. Synthesis sees nothing.
`ifdef FORMAL
  `define MMCS_ASSERT(name, cond, text) \
    always @(posedge clk_i) begin if (rst_ni) name : assert (cond); end
`elsif SYNTHESIS
  `define MMCS_ASSERT(name, cond, text)
`elsif YOSYS
  `define MMCS_ASSERT(name, cond, text)
`elsif MMCS_NO_ASSERT
  `define MMCS_ASSERT(name, cond, text)
`else
  // The shape of a flip-flop with asynchronous reset, so that lint sees one use of rst_ni.
  `define MMCS_ASSERT(name, cond, text) \
    always @(posedge clk_i or negedge rst_ni) begin : name \
      if (!rst_ni) begin end \
      else if (!(cond)) $fatal(1, "%m: %s", text); \
    end
`endif

`endif
