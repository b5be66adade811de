// SPDX-License-Identifier: Apache-2.0
// Data are carried and decide nothing: what a simulator may take for granted who remembers what a
// part did, whatever its data were.
//
// Two of a part in one state but for their data; tools/carried.py finds registers and pins in the
// netlist, and what of them is data or a counter in sim/model/parts.toml. From any state, not only
// those that can be reached: an upset may have led anywhere.
`default_nettype none
`include "mmcs_formal.svh"

module carried_props #(
  parameter int Registers = 1,
  parameter int Outputs = 1,
  parameter int Counters = 1
) (
  input wire logic                 clk_i,
  input wire logic                 rst_ni,
  // Of both parts: registers and outputs that are neither data nor counters
  input wire logic [Registers-1:0] registers_one,
  input wire logic [Registers-1:0] registers_two,
  input wire logic [  Outputs-1:0] outputs_one,
  input wire logic [  Outputs-1:0] outputs_two,
  input wire logic [ Counters-1:0] counted,   // each is the same in both, or above its margin
  input wire logic [ Counters-1:0] same_way,  // in both it moved by as much, or to the same value
  // other data than in the other part, where the table says that they decide
  input wire logic                 decides
);

  // What a strobe clocks takes what stood before it: two clocks alike, then the next one is.
  logic [1:0] age = 2'd0;
  logic alike, alike_1, alike_2, decides_1, decides_2;
  assign alike = registers_one == registers_two && &counted;
  always @(posedge clk_i) begin
    if (age != 2'd2) age <= age + 2'd1;
    {alike_2, alike_1}     <= {alike_1, alike};
    {decides_2, decides_1} <= {decides_1, decides};
  end

  logic given;
  assign given = age == 2'd2 && alike_2 && alike_1 && !decides_2 && !decides_1;

  `MMCS_PROVE(RegistersAlike, "4.2", given, registers_one == registers_two,
              "one clock on, no register has followed data or a counter above its margin")
  `MMCS_PROVE(OutputsAlike, "4.2", given && alike && !decides, outputs_one == outputs_two,
              "nor has an output")
  `MMCS_PROVE(CountersAlike, "4.2", given, &same_way,
              "and a counter above its margin counts, stands or is loaded, whatever its value")

endmodule

`default_nettype wire
