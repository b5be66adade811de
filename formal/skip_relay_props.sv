// SPDX-License-Identifier: Apache-2.0
// Skipping in the loopback relay. §5.3.5
`default_nettype none
`include "mmcs_formal.svh"

module skip_relay_props #(
  parameter int SettleClks = 8000
) (
  input wire logic        clk_i,
  input wire logic        no_reset_i,
  input wire logic        try_i,
  input wire logic [15:0] extra_i,
  input wire logic        joint_i
);

  logic rst_ni, started = 1'b0;
  always @(posedge clk_i) started <= 1'b1;
  assign rst_ni = started & no_reset_i;

  logic [15:0] horizon_a, horizon_b, extra_a, extra_b;
  logic [1:0] phase, pins_a, pins_b;

  skip_phase frame (
    .clk_i, .rst_ni, .try_i, .extra_i,
    .horizon_i(horizon_a),
    .extra_a_o(extra_a),
    .extra_b_o(extra_b),
    .phase_o(phase)
  );
  relay #(.SettleClks(SettleClks), .Skip(1'b1)) a (
    .clk_i, .rst_ni, .joint_i, .drive_o(pins_a[0]), .loop_o(pins_a[1]), .clk_free_i(1'b0),
    .due_o(), .extra_i(extra_a), .horizon_o(horizon_a)
  );
  relay #(.SettleClks(SettleClks), .Skip(1'b1)) b (
    .clk_i, .rst_ni, .joint_i, .drive_o(pins_b[0]), .loop_o(pins_b[1]), .clk_free_i(1'b0),
    .due_o(), .extra_i(extra_b), .horizon_o(horizon_b)
  );

  // Wires of these names are joined to the registers when the hierarchy is flattened.
  (* hierconn *) wire [16:0] \a.left_q , \b.left_q ;
  (* hierconn *) wire \a.joint_q , \b.joint_q ;
  logic [17:0] state_a, state_b;
  assign state_a = {a.left_q, a.joint_q};
  assign state_b = {b.left_q, b.joint_q};

  `MMCS_GIVEN(Still, phase != 2'd1 || joint_i == $past(joint_i), "the input stays during a jump")
  `MMCS_PROVE(JumpIsSteps, "5.3.5", phase == 2'd2, state_b == $past(state_a),
              "k clocks at once end where k single clocks end")
  `MMCS_PROVE(Quiet, "5.3.5", phase == 2'd1, pins_b == $past(pins_b),
              "the contacts stay until the last clock of a jump")
  `MMCS_PROVE(Advances, "5.3.5", 1'b1, horizon_a != '0, "one clock can always be taken")

  `MMCS_LEMMA(Alike, phase != 2'd0 || state_a == state_b, "before the jump the copies are alike")
  `MMCS_LEMMA(Left, a.left_q != '0 && a.left_q <= SettleClks, "the contacts move some time")

endmodule

`default_nettype wire
