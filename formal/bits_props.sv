// SPDX-License-Identifier: Apache-2.0
// Data are only carried: each bit of them that a clock writes is one bit of before, its inverse or
// a constant, and which one it is does not depend on data.
//
// A function of bits is such a one if and only if it keeps majorities: what it makes of the bits
// that most of three have is what most of its three results have. So four of a part in one state:
// the data of the fourth are, bit by bit, what most of the others have; then they still are, one
// clock on. tools/carried.py finds registers and pins in the netlist, and what of them is data or a
// counter in sim/model/parts.toml.
`default_nettype none
`include "mmcs_formal.svh"

module bits_props #(
  parameter int Control = 1,
  parameter int Data = 1,
  parameter int Shown = 1
) (
  input wire logic               clk_i,
  input wire logic               rst_ni,
  // Registers that are neither data nor counters
  input wire logic [Control-1:0] control_one,
  input wire logic [Control-1:0] control_two,
  input wire logic [Control-1:0] control_three,
  input wire logic [Control-1:0] control_four,
  // Data and counters
  input wire logic [   Data-1:0] data_one,
  input wire logic [   Data-1:0] data_two,
  input wire logic [   Data-1:0] data_three,
  input wire logic [   Data-1:0] data_four,
  // Outputs that are data
  input wire logic [  Shown-1:0] shown_one,
  input wire logic [  Shown-1:0] shown_two,
  input wire logic [  Shown-1:0] shown_three,
  input wire logic [  Shown-1:0] shown_four,
  input wire logic [   Data-1:0] excused,  // all four counted alike, or the table says computed
  input wire logic               above,    // each counter is the same in all, or above its margin
  input wire logic               decides   // data differ where the table says that they decide
);

  logic [ Data-1:0] most_data;
  logic [Shown-1:0] most_shown;
  assign most_data = (data_one & data_two) | (data_one & data_three) | (data_two & data_three);
  assign most_shown = (shown_one & shown_two) | (shown_one & shown_three) |
                      (shown_two & shown_three);

  // What a strobe clocks takes what stood before it: two clocks alike, then the next one is.
  logic [1:0] age = 2'd0;
  logic alike, alike_1, alike_2;
  assign alike = {3{control_one}} == {control_two, control_three, control_four} && above &&
                 !decides && data_four == most_data;
  always @(posedge clk_i) begin
    if (age != 2'd2) age <= age + 2'd1;
    {alike_2, alike_1} <= {alike_1, alike};
  end

  `MMCS_PROVE(BitsCarried, "4.2", age == 2'd2 && alike_2 && alike_1,
              &(excused | ~(data_four ^ most_data)),
              "one clock on, each bit of data is one that was there, its inverse or a constant")
  `MMCS_PROVE(BitsShown, "4.2", alike, shown_four == most_shown,
              "and so is each bit of an output that is data")

endmodule

`default_nettype wire
