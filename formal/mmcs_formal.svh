// SPDX-License-Identifier: Apache-2.0
// What the formal tops are written in: properties, assumptions, covers.

`ifndef MMCS_FORMAL_SVH
`define MMCS_FORMAL_SVH

// Contract: the formal top has clk_i, and rst_ni by MMCS_RESET. All are looked at on rising edges
// out of reset. tools/formal.py reads these lines for docs/evidence/formal.md: `where` is the
// section of the report, `text` its sentence in our words; both plain strings on one line or two.

// Reset in the first clock, and whenever `runs` is 0.
`define MMCS_RESET(runs) \
  logic rst_ni, started = 1'b0; \
  always @(posedge clk_i) started <= 1'b1; \
  assign rst_ni = started & (runs);

// Whenever `when` holds, `what` holds; a cover shows that `when` can be had.
`define MMCS_PROVE(name, where, when, what, text) \
  always @(posedge clk_i) if (rst_ni) begin \
    name : assert (!(when) || (what)); \
    name``_when : cover (when); \
  end

// A step on the way to a proof: an invariant of the design that others stand on.
`define MMCS_LEMMA(name, what, text) \
  always @(posedge clk_i) if (rst_ni) begin name : assert (what); end

// What the surroundings keep to.
`define MMCS_GIVEN(name, what, text) \
  always @(posedge clk_i) if (rst_ni) begin name : assume (what); end

// Something that must be possible.
`define MMCS_REACH(name, what, text) \
  always @(posedge clk_i) if (rst_ni) begin name : cover (what); end

`endif
