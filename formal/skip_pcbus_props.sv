// SPDX-License-Identifier: Apache-2.0
// Skipping in a cycle on the PC bus. §4.3.2
`default_nettype none
`include "mmcs_formal.svh"

`define STATE(x) {x.state_q, x.timer_q, x.waits_q, x.write_q, x.pc_a_o, x.pc_d_o, x.pc_ior_no, \
                  x.pc_iow_no, x.rdata_o}

module skip_pcbus_props (
  input wire logic        clk_i,
  input wire logic        no_reset_i,
  input wire logic        try_i,
  input wire logic [15:0] extra_i,
  input wire logic        start_i,
  input wire logic        write_i,
  input wire logic [15:0] a_i,
  input wire logic [ 7:0] wdata_i,
  input wire logic        link_ok_i,
  input wire logic        clk_en_i,
  input wire logic [ 7:0] pc_d_i,
  input wire logic        pc_wait_i
);

  logic rst_ni, started = 1'b0;
  always @(posedge clk_i) started <= 1'b1;
  assign rst_ni = started & no_reset_i;

  logic [15:0] horizon_a, horizon_b, extra_a, extra_b;
  logic [1:0] phase;
  logic [35:0] pins_a, pins_b;

  skip_phase frame (
    .clk_i, .rst_ni, .try_i, .extra_i,
    .horizon_i(horizon_a),
    .extra_a_o(extra_a),
    .extra_b_o(extra_b),
    .phase_o(phase)
  );
  pcbus_master #(.Skip(1'b1)) a (
    .clk_i, .rst_ni, .start_i, .write_i, .a_i, .wdata_i, .link_ok_i, .clk_en_i, .pc_d_i,
    .pc_wait_i, .done_o(pins_a[0]), .rdata_o(pins_a[8:1]), .pc_ior_no(pins_a[9]),
    .pc_iow_no(pins_a[10]), .idle_o(pins_a[11]), .pc_a_o(pins_a[27:12]), .pc_d_o(pins_a[35:28]),
    .extra_i(extra_a), .horizon_o(horizon_a)
  );
  pcbus_master #(.Skip(1'b1)) b (
    .clk_i, .rst_ni, .start_i, .write_i, .a_i, .wdata_i, .link_ok_i, .clk_en_i, .pc_d_i,
    .pc_wait_i, .done_o(pins_b[0]), .rdata_o(pins_b[8:1]), .pc_ior_no(pins_b[9]),
    .pc_iow_no(pins_b[10]), .idle_o(pins_b[11]), .pc_a_o(pins_b[27:12]), .pc_d_o(pins_b[35:28]),
    .extra_i(extra_b), .horizon_o(horizon_b)
  );

  // Wires of these names are joined to the registers when the hierarchy is flattened.
  (* hierconn *) wire [1:0] \a.state_q ;
  (* hierconn *) wire [1:0] \b.state_q ;
  (* hierconn *) wire [2:0] \a.timer_q ;
  (* hierconn *) wire [2:0] \b.timer_q ;
  (* hierconn *) wire [3:0] \a.waits_q ;
  (* hierconn *) wire [3:0] \b.waits_q ;
  (* hierconn *) wire \a.write_q , \a.pc_ior_no , \a.pc_iow_no ;
  (* hierconn *) wire \b.write_q , \b.pc_ior_no , \b.pc_iow_no ;
  (* hierconn *) wire [15:0] \a.pc_a_o ;
  (* hierconn *) wire [15:0] \b.pc_a_o ;
  (* hierconn *) wire [7:0] \a.pc_d_o , \a.rdata_o ;
  (* hierconn *) wire [7:0] \b.pc_d_o , \b.rdata_o ;
  logic [43:0] state_a, state_b;
  assign state_a = `STATE(a);
  assign state_b = `STATE(b);

  logic [36:0] pins;
  assign pins = {start_i, write_i, a_i, wdata_i, link_ok_i, clk_en_i, pc_d_i, pc_wait_i};

  `MMCS_GIVEN(Still, phase != 2'd1 || pins == $past(pins), "the inputs stay during a jump")
  `MMCS_PROVE(JumpIsSteps, "4.3.2", phase == 2'd2, state_b == $past(state_a),
              "k clocks at once end where k single clocks end")
  `MMCS_PROVE(Quiet, "4.3.2", phase == 2'd1, pins_b[10:0] == $past(pins_b[10:0]),
              "answer and command stay until the last clock of a jump")
  `MMCS_PROVE(Advances, "4.3.2", 1'b1, horizon_a != '0, "one clock can always be taken")

  `MMCS_LEMMA(Alike, phase != 2'd0 || (state_a == state_b),
              "before the jump the copies are alike")

endmodule

`default_nettype wire
