// SPDX-License-Identifier: Apache-2.0
// No clock gate: the cell that Ibex asks for, for programmable logic. The core sleeps without one.
// The name is Ibex's.
`default_nettype none

module prim_clock_gating (
  input  wire logic clk_i,
  input  wire logic en_i,
  input  wire logic test_en_i,
  output logic      clk_o
);

  assign clk_o = clk_i;

  logic unused;
  assign unused = en_i ^ test_en_i;

endmodule

`default_nettype wire
