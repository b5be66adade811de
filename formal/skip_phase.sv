// SPDX-License-Identifier: Apache-2.0
// The frame of every skipping proof: two copies of a module step alike until one jump is tried.
`default_nettype none
`include "mmcs_formal.svh"

// To prove: one edge that stands for k clocks, k <= horizon_o, does what k single edges do. The
// frame tries what is enough for that by induction over k: a jump of k clocks ends where a jump of
// k - 1 clocks and a single one end, and shows its outputs nothing before the last clock.
//
// Phase 0: both copies take the same edges. A jump is tried at any time: copy A takes k clocks at
// once, copy B takes k - 1. Phase 1: B takes the last one; the inputs stay. Phase 2: the registers
// of B must now be what those of A were a clock ago. Phase 3: nothing more is looked at.
module skip_phase (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic        try_i,
  input  wire logic [15:0] extra_i,    // any
  input  wire logic [15:0] horizon_i,  // of copy A
  output logic      [15:0] extra_a_o,
  output logic      [15:0] extra_b_o,
  output logic      [ 1:0] phase_o
);

  logic jump;
  assign jump = phase_o == 2'd0 && try_i && extra_i != '0;
  assign extra_a_o = phase_o == 2'd0 ? extra_i : 16'd0;
  assign extra_b_o = jump ? extra_i - 16'd1 : extra_a_o;

  always @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) phase_o <= 2'd0;
    else if (jump) phase_o <= 2'd1;
    else if (phase_o != 2'd0 && phase_o != 2'd3) phase_o <= phase_o + 2'd1;
  end

  `MMCS_GIVEN(Allowed, phase_o != 2'd0 || extra_i < horizon_i,
              "nobody steps further than the module allows")
  `MMCS_REACH(Tried, phase_o == 2'd2 && $past(extra_b_o, 2) > 16'd2, "a jump has been tried")

endmodule

`default_nettype wire
