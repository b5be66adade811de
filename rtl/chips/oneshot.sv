// SPDX-License-Identifier: Apache-2.0
// Retriggerable one-shot in the manner of a 4538: the heartbeat of an axis.
// §5.3.6

`include "mmcs_assert.svh"
`default_nettype none

module oneshot #(
  parameter bit          Skip      = 1'b0,
  parameter bit          Gate      = 1'b0,    // see rtl/mmcs.sv
  parameter int          PulseClks = 400_000  // 50 ms at 8 MHz
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // pins
  input  wire logic        trig_i,  // a rising edge triggers and retriggers
  input  wire logic        clr_ni,  // low ends the pulse and inhibits
  output      logic        q_o,     // high for PulseClks clocks after the last trigger
  // skipping and gating
  input  wire logic        clk_free_i,
  output      logic        due_o,   // this clock ends the pulse
  input  wire logic [15:0] extra_i,
  output      logic [15:0] horizon_o
);
  localparam int Width = $clog2(PulseClks + 1) < 18 ? 18 : $clog2(PulseClks + 1);

  logic             clk_free;
  logic             trig_q, run_q, start;
  logic [Width-1:0] left_q;  // clocks until the pulse ends, valid while run_q
  logic [Width-1:0] n;       // clocks this edge stands for

  assign n   = Skip ? {{(Width - 16) {1'b0}}, extra_i} + 1'b1 : {{(Width - 1) {1'b0}}, 1'b1};
  assign q_o = run_q;
  assign start = trig_i && !trig_q && clr_ni;
  assign due_o = run_q && left_q <= n;
  assign clk_free = Gate ? clk_free_i : clk_i;

  // A trigger on the very clock that would end the pulse wins, so the output does not glitch.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      trig_q <= 1'b0;
      run_q  <= 1'b0;
    end else if (run_q || trig_i || trig_q) begin
      trig_q <= trig_i;
      if (!clr_ni || due_o) run_q <= 1'b0;
      if (start) run_q <= 1'b1;
    end
  end

  always_ff @(posedge clk_free or negedge rst_ni) begin
    if (!rst_ni) left_q <= '0;
    else if (start) left_q <= PulseClks[Width-1:0];
    else if (run_q) left_q <= left_q - n;
  end

  generate
    if (Skip) begin : g_skip
      logic [15:0] low;
      logic near;  // the end is close enough for horizon_o to say
      assign low  = left_q[15:0];
      assign near = left_q[Width-1:16] == '0;
      always_comb begin
        horizon_o = 16'hFFFF;
        if (trig_i != trig_q || (run_q && !clr_ni)) horizon_o = 16'd1;
        else if (run_q && near) horizon_o = low;
      end
    end else begin : g_step
      assign horizon_o = 16'd1;
    end
    if (PulseClks == 0) begin : g_bad
      initial $fatal(1, "oneshot: PulseClks must be at least 1");
    end
  endgenerate

  `MMCS_ASSERT(a_left, !run_q || left_q != '0, "a running pulse has at least one clock left")
endmodule

`default_nettype wire
