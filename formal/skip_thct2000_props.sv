// SPDX-License-Identifier: Apache-2.0
// Skipping in the encoder counter. §5.3.2
`default_nettype none
`include "mmcs_formal.svh"

`define STATE(x) {x.s1_q, x.s2_q, x.prev_q, x.d_q, x.held_q, x.snap_q, x.latch_q, x.count_q, \
                  x.rd_q, x.wr_q, x.rs_q, x.latch_in_q, x.latched_q, x.illegal_q, \
                  x.rd_seen_q, x.rd_snap_q, x.wr_seen_q, x.wr_first_q}

module skip_thct2000_props (
  input wire logic        clk_i,
  input wire logic        no_reset_i,
  input wire logic        try_i,
  input wire logic [15:0] extra_i,
  input wire logic        reset_i,
  input wire logic        clk_en_i,
  input wire logic [ 2:0] m_i,
  input wire logic        a_i,
  input wire logic        b_i,
  input wire logic        latch_i,
  input wire logic        cs_ni,
  input wire logic        rd_ni,
  input wire logic        wr_ni,
  input wire logic        rs_i,
  input wire logic [ 7:0] d_i
);

  logic rst_ni, started = 1'b0;
  always @(posedge clk_i) started <= 1'b1;
  assign rst_ni = started & no_reset_i;

  logic [15:0] horizon_a, horizon_b, extra_a, extra_b;
  logic [1:0] phase;
  logic [25:0] pins_a, pins_b;

  skip_phase frame (
    .clk_i, .rst_ni, .try_i, .extra_i,
    .horizon_i(horizon_a),
    .extra_a_o(extra_a),
    .extra_b_o(extra_b),
    .phase_o(phase)
  );
  thct2000 #(.Skip(1'b1)) a (
    .clk_i, .rst_ni, .reset_i, .clk_en_i, .m_i, .a_i, .b_i, .latch_i, .asleep_i(1'b0),
    .cs_ni, .rd_ni, .wr_ni, .rs_i, .d_i, .d_o(pins_a[7:0]), .d_oe_o(pins_a[8]),
    .count_o(pins_a[24:9]), .illegal_o(pins_a[25]), .extra_i(extra_a), .horizon_o(horizon_a)
  );
  thct2000 #(.Skip(1'b1)) b (
    .clk_i, .rst_ni, .reset_i, .clk_en_i, .m_i, .a_i, .b_i, .latch_i, .asleep_i(1'b0),
    .cs_ni, .rd_ni, .wr_ni, .rs_i, .d_i, .d_o(pins_b[7:0]), .d_oe_o(pins_b[8]),
    .count_o(pins_b[24:9]), .illegal_o(pins_b[25]), .extra_i(extra_b), .horizon_o(horizon_b)
  );

  // Wires of these names are joined to the registers when the hierarchy is flattened.
  (* hierconn *) wire [1:0] \a.s1_q , \a.s2_q , \a.prev_q , \b.s1_q , \b.s2_q , \b.prev_q ;
  (* hierconn *) wire [7:0] \a.d_q , \a.held_q , \b.d_q , \b.held_q ;
  (* hierconn *) wire [15:0] \a.snap_q , \a.latch_q , \a.count_q ;
  (* hierconn *) wire [15:0] \b.snap_q , \b.latch_q , \b.count_q ;
  (* hierconn *) wire \a.rd_q , \a.wr_q , \a.rs_q , \a.latch_in_q , \a.latched_q , \a.illegal_q ;
  (* hierconn *) wire \b.rd_q , \b.wr_q , \b.rs_q , \b.latch_in_q , \b.latched_q , \b.illegal_q ;
  (* hierconn *) wire \a.rd_seen_q , \a.rd_snap_q , \a.wr_seen_q , \a.wr_first_q ;
  (* hierconn *) wire \b.rd_seen_q , \b.rd_snap_q , \b.wr_seen_q , \b.wr_first_q ;
  logic [79:0] state_a, state_b;
  assign state_a = `STATE(a);
  assign state_b = `STATE(b);

  logic [23:0] pins;
  assign pins = {reset_i, clk_en_i, m_i, a_i, b_i, latch_i, cs_ni, rd_ni, wr_ni, rs_i, d_i};

  `MMCS_GIVEN(Still, phase != 2'd1 || pins == $past(pins), "the inputs stay during a jump")
  `MMCS_PROVE(JumpIsSteps, "5.3.2", phase == 2'd2, state_b == $past(state_a),
              "k clocks at once end where k single clocks end")
  `MMCS_PROVE(Quiet, "5.3.2", phase == 2'd1, pins_b[8:0] == $past(pins_b[8:0]),
              "the outputs stay until the last clock of a jump, the count on its test pins aside")
  `MMCS_PROVE(Advances, "5.3.2", 1'b1, horizon_a != '0, "one clock can always be taken")

  `MMCS_LEMMA(Alike, phase != 2'd0 || state_a == state_b, "before the jump the copies are alike")

endmodule

`default_nettype wire
