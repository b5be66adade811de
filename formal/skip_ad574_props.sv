// SPDX-License-Identifier: Apache-2.0
// Skipping in the A/D converter. §5.3.4
`default_nettype none
`include "mmcs_formal.svh"

`define STATE(x) {x.start_q, x.busy_q, x.next_q, x.code_q, x.busy_q ? x.left_q : 18'd0}

module skip_ad574_props #(
  parameter int ConvClks = 200
) (
  input wire logic               clk_i,
  input wire logic               no_reset_i,
  input wire logic               try_i,
  input wire logic        [15:0] extra_i,
  input wire logic               ce_i,
  input wire logic               cs_ni,
  input wire logic               rc_ni,
  input wire logic               a0_i,
  input wire logic               mode12_i,
  input wire logic               span10_i,
  input wire logic signed [15:0] vin_i,
  input wire logic               hold_i
);

  logic rst_ni, started = 1'b0;
  always @(posedge clk_i) started <= 1'b1;
  assign rst_ni = started & no_reset_i;

  logic [15:0] horizon_a, horizon_b, extra_a, extra_b;
  logic [1:0] phase;
  logic [13:0] pins_a, pins_b;

  skip_phase frame (
    .clk_i, .rst_ni, .try_i, .extra_i,
    .horizon_i(horizon_a),
    .extra_a_o(extra_a),
    .extra_b_o(extra_b),
    .phase_o(phase)
  );
  ad574 #(.Skip(1'b1), .ConvClks(ConvClks)) a (
    .clk_i, .rst_ni, .ce_i, .cs_ni, .rc_ni, .a0_i, .mode12_i, .sts_o(pins_a[0]),
    .db_o(pins_a[12:1]), .db_oe_o(pins_a[13]), .span10_i, .vin_i, .hold_i, .clk_free_i(1'b0),
    .due_o(), .extra_i(extra_a), .horizon_o(horizon_a)
  );
  ad574 #(.Skip(1'b1), .ConvClks(ConvClks)) b (
    .clk_i, .rst_ni, .ce_i, .cs_ni, .rc_ni, .a0_i, .mode12_i, .sts_o(pins_b[0]),
    .db_o(pins_b[12:1]), .db_oe_o(pins_b[13]), .span10_i, .vin_i, .hold_i, .clk_free_i(1'b0),
    .due_o(), .extra_i(extra_b), .horizon_o(horizon_b)
  );

  // Wires of these names are joined to the registers when the hierarchy is flattened. What is left
  // counts during a conversion and means nothing else.
  (* hierconn *) wire [17:0] \a.left_q , \b.left_q ;
  (* hierconn *) wire [11:0] \a.next_q , \a.code_q , \b.next_q , \b.code_q ;
  (* hierconn *) wire \a.start_q , \a.busy_q , \b.start_q , \b.busy_q ;
  logic [43:0] state_a, state_b;
  assign state_a = `STATE(a);
  assign state_b = `STATE(b);

  logic [23:0] pins;
  assign pins = {ce_i, cs_ni, rc_ni, a0_i, mode12_i, span10_i, vin_i, hold_i};

  `MMCS_GIVEN(Still, phase != 2'd1 || pins == $past(pins), "the inputs stay during a jump")
  `MMCS_PROVE(JumpIsSteps, "5.3.4", phase == 2'd2, state_b == $past(state_a),
              "k clocks at once end where k single clocks end")
  `MMCS_PROVE(Quiet, "5.3.4", phase == 2'd1, pins_b == $past(pins_b),
              "the outputs stay until the last clock of a jump")
  `MMCS_PROVE(Advances, "5.3.4", 1'b1, horizon_a != '0, "one clock can always be taken")

  `MMCS_LEMMA(Alike, phase != 2'd0 || state_a == state_b, "before the jump the copies are alike")
  `MMCS_LEMMA(Left, !a.busy_q || (a.left_q != '0 && a.left_q <= ConvClks), "a conversion ends")

endmodule

`default_nettype wire
