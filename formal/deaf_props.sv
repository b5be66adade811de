// SPDX-License-Identifier: Apache-2.0
// A card whose decoder says what it says without a command does not hear the bus, nor does a chip
// that is not selected.
//
// Two of them in one state differ in the pins of the bus; tools/carried.py writes down the pins and
// registers, and the decoder by itself, from the netlist and sim/model/parts.toml.
`default_nettype none
`include "mmcs_formal.svh"

module deaf_props #(
  parameter int Registers = 1,
  parameter int Outputs = 1
) (
  input wire logic                 clk_i,
  input wire logic                 rst_ni,
  input wire logic [Registers-1:0] registers_one,
  input wire logic [Registers-1:0] registers_two,
  input wire logic [  Outputs-1:0] outputs_one,
  input wire logic [  Outputs-1:0] outputs_two,
  input wire logic                 unheard        // both decoders say what none says; not selected
);

  logic started = 1'b0, unheard_1, alike_1;
  always @(posedge clk_i) begin
    started   <= 1'b1;
    unheard_1 <= unheard;
    alike_1   <= registers_one == registers_two;
  end

  `MMCS_PROVE(RegistersAlike, "5.3.1", started && alike_1 && unheard_1,
              registers_one == registers_two,
              "pins of the bus that are not for a card or chip change none of its registers")
  `MMCS_PROVE(OutputsAlike, "5.3.1", registers_one == registers_two && unheard,
              outputs_one == outputs_two, "nor any of its outputs")

endmodule

`default_nettype wire
