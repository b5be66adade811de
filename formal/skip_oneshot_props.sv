// SPDX-License-Identifier: Apache-2.0
// Skipping in the one-shot. §5.3.6
`default_nettype none
`include "mmcs_formal.svh"

`define STATE(x) {x.trig_q, x.run_q, x.run_q ? x.left_q : 19'd0}

module skip_oneshot_props #(
  parameter int PulseClks = 400_000
) (
  input wire logic        clk_i,
  input wire logic        reset_i,
  input wire logic        try_i,
  input wire logic [15:0] extra_i,
  input wire logic        trig_i,
  input wire logic        clr_ni
);

  logic rst_ni, started = 1'b0;
  always @(posedge clk_i) started <= 1'b1;
  assign rst_ni = started & ~reset_i;

  logic [15:0] horizon_a, horizon_b, extra_a, extra_b;
  logic [1:0] phase;
  logic q_a, q_b;

  skip_phase frame (
    .clk_i, .rst_ni, .try_i, .extra_i,
    .horizon_i(horizon_a),
    .extra_a_o(extra_a),
    .extra_b_o(extra_b),
    .phase_o(phase)
  );
  oneshot #(.Skip(1'b1), .PulseClks(PulseClks)) a (
    .clk_i, .rst_ni, .trig_i, .clr_ni, .q_o(q_a), .clk_free_i(1'b0), .due_o(),
    .extra_i(extra_a), .horizon_o(horizon_a)
  );
  oneshot #(.Skip(1'b1), .PulseClks(PulseClks)) b (
    .clk_i, .rst_ni, .trig_i, .clr_ni, .q_o(q_b), .clk_free_i(1'b0), .due_o(),
    .extra_i(extra_b), .horizon_o(horizon_b)
  );

  // Wires of these names are joined to the registers when the hierarchy is flattened. What is left
  // counts while a pulse runs and means nothing else.
  (* hierconn *) wire [18:0] \a.left_q , \b.left_q ;
  (* hierconn *) wire \a.trig_q , \a.run_q , \b.trig_q , \b.run_q ;
  logic [20:0] state_a, state_b;
  assign state_a = `STATE(a);
  assign state_b = `STATE(b);

  `MMCS_GIVEN(Still, phase != 2'd1 || {trig_i, clr_ni} == $past({trig_i, clr_ni}),
              "the inputs stay during a jump")
  `MMCS_PROVE(JumpIsSteps, "5.3.6", phase == 2'd2, state_b == $past(state_a),
              "k clocks at once end where k single clocks end")
  `MMCS_PROVE(Quiet, "5.3.6", phase == 2'd1, q_b == $past(q_b),
              "the output stays until the last clock of a jump")
  `MMCS_PROVE(Advances, "5.3.6", 1'b1, horizon_a != '0, "one clock can always be taken")

  `MMCS_LEMMA(Alike, phase != 2'd0 || state_a == state_b, "before the jump the copies are alike")
  `MMCS_LEMMA(Left, !a.run_q || (a.left_q != '0 && a.left_q <= PulseClks), "a pulse has an end")

endmodule

`default_nettype wire
