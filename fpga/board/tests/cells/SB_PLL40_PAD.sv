// SPDX-License-Identifier: Apache-2.0
// The PLL of an iCE40, as no tool models it: it passes its clock on.
/* verilator lint_off UNUSEDSIGNAL */
/* verilator lint_off UNUSEDPARAM */
`default_nettype none

module SB_PLL40_PAD #(
  parameter FEEDBACK_PATH = "",
  parameter logic [3:0] DIVR = 0,
  parameter logic [6:0] DIVF = 0,
  parameter logic [2:0] DIVQ = 0, FILTER_RANGE = 0
) (
  input  wire logic PACKAGEPIN, RESETB, BYPASS,
  output logic      PLLOUTCORE, LOCK
);
  assign PLLOUTCORE = PACKAGEPIN;
  assign LOCK = 1'b1;
endmodule

`default_nettype wire
