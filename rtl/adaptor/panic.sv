// SPDX-License-Identifier: Apache-2.0
// System PANIC and the brakes, fail-safe: whatever is missing asserts it. §2.3.4, §4.3.5
`default_nettype none
`include "mmcs_assert.svh"

module panic (
  input  wire logic clk_i,
  input  wire logic rst_ni,
  // What can go wrong
  input  wire logic bus_panic_i,       // the jumpered line of the PC bus; all four asynchronous
  input  wire logic estop_closed_i,
  input  wire logic cable_ok_i,
  input  wire logic pc_power_i,
  // Result
  output logic      panic_o,
  output logic      brake_release_o,
  output logic      cable_ok_o,        // synchronised
  output logic      pc_power_o         // synchronised
);

  // {hand-held button, cable, power}; healthy until shown otherwise, so that a machine that is
  // healthy when it starts makes no edge.
  logic [2:0] sync0_q, sync1_q;
  logic bus0_q, bus1_q;   // the PC bus is heard only while the rest is good: no gap in between
  logic panic_q, safe;

  assign safe = &sync1_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sync0_q <= '1;
      sync1_q <= '1;
      bus0_q  <= 1'b0;
      bus1_q  <= 1'b0;
      panic_q <= 1'b1;
    end else begin
      sync0_q <= {estop_closed_i, cable_ok_i, pc_power_i};
      sync1_q <= sync0_q;
      bus0_q  <= bus_panic_i | ~safe;
      bus1_q  <= bus0_q | ~safe;
      panic_q <= bus1_q | ~safe;
    end
  end

  assign panic_o = panic_q;
  assign brake_release_o = ~panic_q;
  assign cable_ok_o = sync1_q[1];
  assign pc_power_o = sync1_q[0];

  `MMCS_ASSERT(BrakesHold, !(brake_release_o && panic_o),
               "the brakes are never released while PANIC stands")

endmodule

`default_nettype wire
