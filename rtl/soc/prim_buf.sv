// SPDX-License-Identifier: Apache-2.0
// A wire: the cell that Ibex asks for where a technology would keep a buffer. The name is Ibex's.
`default_nettype none

module prim_buf #(
  parameter int Width = 1
) (
  input  wire logic [Width-1:0] in_i,
  output logic      [Width-1:0] out_o
);

  assign out_o = in_i;

endmodule

`default_nettype wire
