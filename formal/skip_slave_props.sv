// SPDX-License-Identifier: Apache-2.0
// Skipping in the VME slave. §4.3.1
`default_nettype none
`include "mmcs_formal.svh"

`define STATE(x) {x.state_q, x.strobe_q, x.fresh_q, x.ours_q, x.both_high_q, x.both_high2_q, \
                  x.dtack_q, x.gone_q, x.hp_a_o, x.hp_wdata_o, x.hp_write_o}

module skip_slave_props (
  input wire logic        clk_i,
  input wire logic        no_reset_i,
  input wire logic        try_i,
  input wire logic [15:0] extra_i,
  input wire logic        sys_reset_i,
  input wire logic [15:1] vme_a_i,
  input wire logic [ 5:0] vme_am_i,
  input wire logic        vme_as_ni,
  input wire logic [ 1:0] vme_ds_ni,
  input wire logic        vme_write_ni,
  input wire logic        vme_lword_ni,
  input wire logic        vme_iack_ni,
  input wire logic [ 7:0] vme_d_i,
  input wire logic        hp_ack_i
);

  logic rst_ni, started = 1'b0;
  always @(posedge clk_i) started <= 1'b1;
  assign rst_ni = started & no_reset_i;

  logic [15:0] horizon_a, horizon_b, extra_a, extra_b;
  logic [1:0] phase;
  logic [22:0] pins_a, pins_b;

  skip_phase frame (
    .clk_i, .rst_ni, .try_i, .extra_i,
    .horizon_i(horizon_a),
    .extra_a_o(extra_a),
    .extra_b_o(extra_b),
    .phase_o(phase)
  );
  vme_slave #(.Skip(1'b1)) a (
    .clk_i, .rst_ni, .sys_reset_i, .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni,
    .vme_lword_ni, .vme_iack_ni, .vme_d_i, .hp_ack_i, .d_oe_o(pins_a[0]), .dtack_o(pins_a[1]),
    .hp_req_o(pins_a[2]), .idle_o(pins_a[3]), .hp_write_o(pins_a[4]), .hp_a_o(pins_a[14:5]),
    .hp_wdata_o(pins_a[22:15]), .extra_i(extra_a), .horizon_o(horizon_a)
  );
  vme_slave #(.Skip(1'b1)) b (
    .clk_i, .rst_ni, .sys_reset_i, .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni,
    .vme_lword_ni, .vme_iack_ni, .vme_d_i, .hp_ack_i, .d_oe_o(pins_b[0]), .dtack_o(pins_b[1]),
    .hp_req_o(pins_b[2]), .idle_o(pins_b[3]), .hp_write_o(pins_b[4]), .hp_a_o(pins_b[14:5]),
    .hp_wdata_o(pins_b[22:15]), .extra_i(extra_b), .horizon_o(horizon_b)
  );

  // Wires of these names are joined to the registers when the hierarchy is flattened.
  (* hierconn *) wire [1:0] \a.state_q ;
  (* hierconn *) wire [1:0] \b.state_q ;
  (* hierconn *) wire \a.strobe_q , \a.fresh_q , \a.ours_q , \a.both_high_q , \a.both_high2_q ;
  (* hierconn *) wire \a.dtack_q , \a.gone_q , \a.hp_write_o ;
  (* hierconn *) wire \b.strobe_q , \b.fresh_q , \b.ours_q , \b.both_high_q , \b.both_high2_q ;
  (* hierconn *) wire \b.dtack_q , \b.gone_q , \b.hp_write_o ;
  (* hierconn *) wire [10:1] \a.hp_a_o ;
  (* hierconn *) wire [10:1] \b.hp_a_o ;
  (* hierconn *) wire [7:0] \a.hp_wdata_o ;
  (* hierconn *) wire [7:0] \b.hp_wdata_o ;
  logic [27:0] state_a, state_b;
  assign state_a = `STATE(a);
  assign state_b = `STATE(b);

  logic [36:0] pins;
  assign pins = {sys_reset_i, vme_a_i, vme_am_i, vme_as_ni, vme_ds_ni, vme_write_ni,
                 vme_lword_ni, vme_iack_ni, vme_d_i, hp_ack_i};

  `MMCS_GIVEN(Still, phase != 2'd1 || pins == $past(pins), "the inputs stay during a jump")
  `MMCS_PROVE(JumpIsSteps, "4.3.1", phase == 2'd2, state_b == $past(state_a),
              "k clocks at once end where k single clocks end")
  `MMCS_PROVE(Quiet, "4.3.1", phase == 2'd1, pins_b[2:0] == $past(pins_b[2:0]),
              "DTACK*, drivers and request stay until the last clock of a jump")
  `MMCS_PROVE(Advances, "4.3.1", 1'b1, horizon_a != '0, "one clock can always be taken")

  `MMCS_LEMMA(Alike, phase != 2'd0 || (state_a == state_b),
              "before the jump the copies are alike")

endmodule

`default_nettype wire
