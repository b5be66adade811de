// SPDX-License-Identifier: Apache-2.0
// Skipping in the VME interrupter. §4.3.6
`default_nettype none
`include "mmcs_formal.svh"

`define STATE(x) {x.state_q, x.iackin0_q, x.iackin1_q, x.strobe0_q, x.strobe1_q, x.both_high_q, \
                  x.cycle_q, x.req_q, x.dtack_q}

module skip_interrupter_props (
  input wire logic        clk_i,
  input wire logic        no_reset_i,
  input wire logic        try_i,
  input wire logic [15:0] extra_i,
  input wire logic        sys_reset_i,
  input wire logic        irq_req_i,
  input wire logic [ 3:1] vme_a_i,
  input wire logic        vme_as_ni,
  input wire logic [ 1:0] vme_ds_ni,
  input wire logic        vme_iack_ni,
  input wire logic        vme_iackin_ni
);

  logic rst_ni, started = 1'b0;
  always @(posedge clk_i) started <= 1'b1;
  assign rst_ni = started & no_reset_i;

  logic [15:0] horizon_a, horizon_b, extra_a, extra_b;
  logic [1:0] phase;
  logic [10:0] pins_a, pins_b;

  skip_phase frame (
    .clk_i, .rst_ni, .try_i, .extra_i,
    .horizon_i(horizon_a),
    .extra_a_o(extra_a),
    .extra_b_o(extra_b),
    .phase_o(phase)
  );
  vme_interrupter #(.Skip(1'b1)) a (
    .clk_i, .rst_ni, .sys_reset_i, .irq_req_i, .vme_a_i, .vme_as_ni, .vme_ds_ni, .vme_iack_ni,
    .vme_iackin_ni, .vme_iackout_no(pins_a[0]), .vme_irq_no(pins_a[7:1]), .d_oe_o(pins_a[8]),
    .dtack_o(pins_a[9]), .idle_o(pins_a[10]), .extra_i(extra_a), .horizon_o(horizon_a)
  );
  vme_interrupter #(.Skip(1'b1)) b (
    .clk_i, .rst_ni, .sys_reset_i, .irq_req_i, .vme_a_i, .vme_as_ni, .vme_ds_ni, .vme_iack_ni,
    .vme_iackin_ni, .vme_iackout_no(pins_b[0]), .vme_irq_no(pins_b[7:1]), .d_oe_o(pins_b[8]),
    .dtack_o(pins_b[9]), .idle_o(pins_b[10]), .extra_i(extra_b), .horizon_o(horizon_b)
  );

  // Wires of these names are joined to the registers when the hierarchy is flattened.
  (* hierconn *) wire [1:0] \a.state_q ;
  (* hierconn *) wire [1:0] \b.state_q ;
  (* hierconn *) wire \a.iackin0_q , \a.iackin1_q , \a.strobe0_q , \a.strobe1_q , \a.both_high_q ;
  (* hierconn *) wire \a.cycle_q , \a.req_q , \a.dtack_q , \a.pending_q ;
  (* hierconn *) wire \b.iackin0_q , \b.iackin1_q , \b.strobe0_q , \b.strobe1_q , \b.both_high_q ;
  (* hierconn *) wire \b.cycle_q , \b.req_q , \b.dtack_q , \b.pending_q ;
  logic [9:0] state_a, state_b;
  assign state_a = `STATE(a);
  assign state_b = `STATE(b);

  logic [9:0] pins;
  assign pins = {sys_reset_i, irq_req_i, vme_a_i, vme_as_ni, vme_ds_ni, vme_iack_ni,
                 vme_iackin_ni};

  `MMCS_GIVEN(Still, phase != 2'd1 || pins == $past(pins), "the inputs stay during a jump")
  `MMCS_PROVE(JumpIsSteps, "4.3.6", phase == 2'd2, state_b == $past(state_a),
              "k clocks at once end where k single clocks end")
  `MMCS_PROVE(Quiet, "4.3.6", phase == 2'd1, pins_b[9:0] == $past(pins_b[9:0]),
              "drivers, DTACK* and IACKOUT* stay until the last clock of a jump")
  `MMCS_PROVE(Advances, "4.3.6", 1'b1, horizon_a != '0, "one clock can always be taken")

  `MMCS_LEMMA(Alike, phase != 2'd0 || (state_a == state_b && a.pending_q == b.pending_q),
              "before the jump the copies are alike")
  `MMCS_LEMMA(Rest, (a.pending_q || state_a == {6'd0, 2'b10, a.req_q, 1'b0}) &&
                    (b.pending_q || state_b == {6'd0, 2'b10, b.req_q, 1'b0}),
              "who rests has nothing under way: the rest is invisible")
  `MMCS_LEMMA(Answer, (!a.dtack_q || a.state_q == 2'd2) && (!b.dtack_q || b.state_q == 2'd2),
              "DTACK* belongs to an answer")

endmodule

`default_nettype wire
