// SPDX-License-Identifier: Apache-2.0
// A part at rest stays at rest: what a simulator may take for granted who does not clock it.
//
// tools/standing.py finds the part's registers and pins in its netlist and writes them down before
// the proof, with the counters, strides and margins of sim/model/counters.toml. From any state, not
// only those that can be reached: an upset may have led anywhere.
`default_nettype none
`include "mmcs_formal.svh"
`include "part.svh"  // the module's head, the part, its registers, pins, outputs and counters

  // What they were a clock ago and two.
  reg [1:0] age = 2'd0;
  reg free_1;
  always @(posedge clk_i) begin
    if (age != 2'd2) age <= age + 2'd1;
    {registers_2, registers_1} <= {registers_1, registers};
    {pins_2, pins_1}           <= {pins_1, pins};
    {outputs_2, outputs_1}     <= {outputs_1, outputs};
    free_1                     <= free;
  end

  // One clock left the registers as they were, and each counter stood too or moved by a stride of
  // its own and is farther than its margin from its end. The pins stand.
  wire rest = age == 2'd2 && registers_1 == registers_2 && strided && far && !awake &&
              pins_1 == pins_2 && pins == pins_1 && free_1 && free;

  `MMCS_PROVE(RegistersStand, "4.2", rest, registers == registers_1,
              "after one clock in which nothing but counters moved the next moves nothing else")
  `MMCS_PROVE(CountersGoOn, "4.2", rest, alike, "and it moves each counter as that one did")
  `MMCS_PROVE(OutputsStand, "4.2", rest, outputs == outputs_1 && outputs_1 == outputs_2,
              "and the outputs stand, whatever the inputs do that the table calls quiet")
  `MMCS_REACH(OneMoves, rest && (moved != '0 || Counters == 0), "a counter can move at rest")

endmodule

`default_nettype wire
