// SPDX-License-Identifier: Apache-2.0
// A part at rest stays at rest: what a simulator may take for granted who does not clock it.
//
// tools/standing.py finds the part's registers and pins in its netlist and writes them down before
// the proof, with the counters, strides and margins of sim/model/counters.toml. From any state, not
// only those that can be reached: an upset may have led anywhere.
`default_nettype none
`include "mmcs_formal.svh"

module standing_props #(
  parameter int Registers = 1,
  parameter int Pins = 1,
  parameter int Outputs = 1,
  parameter int Counters = 0
) (
  input wire logic                 clk_i,
  input wire logic                 rst_ni,
  input wire logic [Registers-1:0] registers,  // all but the counters
  input wire logic [     Pins-1:0] pins,       // inputs but those that are quiet
  input wire logic [  Outputs-1:0] outputs,
  input wire logic                 free,       // quiet inputs stand, or are quiet indeed
  input wire logic                 awake,      // the table says so
  // Of the counters, between two clocks ago and one: any moved; each stood or went down by a stride
  // of its own; those that did are farther than their margin from 0.
  input wire logic                 moved,
  input wire logic                 strided,
  input wire logic                 far,
  // And since then each did the same.
  input wire logic                 alike
);

  logic [1:0] age = 2'd0;
  logic free_1;
  logic [Registers-1:0] registers_1, registers_2;
  logic [Pins-1:0] pins_1, pins_2;
  logic [Outputs-1:0] outputs_1, outputs_2;
  always @(posedge clk_i) begin
    if (age != 2'd2) age <= age + 2'd1;
    {registers_2, registers_1} <= {registers_1, registers};
    {pins_2, pins_1}           <= {pins_1, pins};
    {outputs_2, outputs_1}     <= {outputs_1, outputs};
    free_1                     <= free;
  end

  // One clock left the registers as they were, and the pins stand.
  logic rest;
  assign rest = age == 2'd2 && registers_1 == registers_2 && strided && far && !awake &&
                pins_1 == pins_2 && pins == pins_1 && free_1 && free;

  `MMCS_PROVE(RegistersStand, "4.2", rest, registers == registers_1,
              "after one clock in which nothing but counters moved the next moves nothing else")
  `MMCS_PROVE(CountersGoOn, "4.2", rest, alike, "and it moves each counter as that one did")
  `MMCS_PROVE(OutputsStand, "4.2", rest, outputs == outputs_1 && outputs_1 == outputs_2,
              "and the outputs stand, whatever the inputs do that the table calls quiet")
  `MMCS_REACH(OneMoves, rest && (moved || Counters == 0), "a counter can move at rest")

endmodule

`default_nettype wire
