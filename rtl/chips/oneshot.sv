// SPDX-License-Identifier: Apache-2.0
// Retriggerable one-shot in the manner of a 4538: the heartbeat of an axis. §5.3.6
`default_nettype none
`include "mmcs_assert.svh"
`include "mmcs_require.svh"

module oneshot #(
  parameter int PulseClks = 400_000  // 50 ms at 8 MHz
) (
  input  wire logic clk_i,
  input  wire logic rst_ni,
  // Pins
  input  wire logic trig_i,  // a rising edge triggers and retriggers
  input  wire logic clr_ni,  // low ends the pulse and inhibits
  output logic      q_o      // high for PulseClks clocks after the last trigger
);

  `MMCS_REQUIRE(ReqPulse, PulseClks >= 1, "oneshot: PulseClks must be at least 1")

  localparam int Width = $clog2(PulseClks + 1);

  logic trig_q;
  logic run_d, run_q;
  logic [Width-1:0] left_d, left_q;  // clocks until the pulse ends, valid while run_q

  // A trigger on the very clock that would end the pulse wins: the output does not glitch.
  always_comb begin
    run_d  = run_q && clr_ni && left_q > Width'(1);
    left_d = run_q ? left_q - 1'b1 : left_q;
    if (trig_i && !trig_q && clr_ni) begin
      run_d  = 1'b1;
      left_d = Width'(PulseClks);
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      trig_q <= 1'b0;
      run_q  <= 1'b0;
      left_q <= '0;
    end else begin
      trig_q <= trig_i;
      run_q  <= run_d;
      left_q <= left_d;
    end
  end

  assign q_o = run_q;

  `MMCS_ASSERT(PulseHasClocks, !run_q || left_q != '0, "a running pulse has a clock left")

endmodule

`default_nettype wire
