// SPDX-License-Identifier: Apache-2.0
// D08(O) interrupter on one level, with the IACK* daisy chain. §4.3.6
//
// Who answers is decided by one flip-flop, which IACKIN* clocks as it falls: a request that comes
// later does not steal the cycle. The request is released by the register
// (PCCSR bit 7), not by the acknowledge. J5 and J7 set apart, no acknowledge is ever answered.
`default_nettype none

module vme_interrupter #(
  parameter int IrqLevel = 5,  // J5: the line that is pulled
  parameter int AckLevel = 5   // J7: the level that is answered
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic        sys_reset_i,   // SYSRESET*, synchronised
  input  wire logic        irq_req_i,
  // VME
  input  wire logic [ 3:1] vme_a_i,
  input  wire logic        vme_as_ni,
  input  wire logic [ 1:0] vme_ds_ni,
  input  wire logic        vme_iack_ni,
  input  wire logic        vme_iackin_ni,
  output logic             vme_iackout_no,
  output logic      [ 7:1] vme_irq_no,
  output logic             d_oe_o,        // drive the vector on D07-D00
  output logic             dtack_o        // pull DTACK* low
);

  logic strobed, low;           // a data strobe is low: the pins; synchronised
  logic level, seen;            // an acknowledge of our level; its DS0*
  logic [1:0] number, number_q; // of the bus cycle; of that in which IACKIN* fell
  logic mine_q;                 // it found us asking: answered, else passed on
  logic in_low, in, here;       // IACKIN* is low; synchronised; in the same bus cycle still
  logic void_q;                 // answered already, or SYSRESET* came in between
  logic answers, answer_q;

  assign strobed = ~(&vme_ds_ni);

  vme_strobe u_strobe (
    .clk_i, .rst_ni,
    .as_ni(vme_as_ni),
    .ds0_ni(vme_ds_ni[0]),
    .ours_i(~vme_iack_ni && vme_a_i == 3'(AckLevel)),
    .number_o(number),
    .cycle_o(level),
    .seen_o(seen)
  );

  always_ff @(negedge vme_iackin_ni or negedge rst_ni) begin
    if (!rst_ni) {mine_q, number_q} <= '0;
    else {mine_q, number_q} <= {IrqLevel == AckLevel && irq_req_i && level, number};
  end

  // Low with IACKIN* high, at once.
  assign in_low = ~vme_iackin_ni;
  sync u_in (.clk_i, .rst_ni(in_low), .d_i(1'b1), .q_o(in));
  sync u_low (.clk_i, .rst_ni, .d_i(strobed), .q_o(low));

  assign here = in & (number_q == number);
  assign answers = here & mine_q & ~void_q & seen & low & ~sys_reset_i;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      void_q   <= 1'b0;
      answer_q <= 1'b0;
    end else begin
      void_q   <= sys_reset_i | answer_q | (void_q & in);
      answer_q <= answer_q ? (low & ~sys_reset_i) : answers;
    end
  end

  assign vme_iackout_no = ~(here & ~mine_q & ~answer_q & ~vme_as_ni);
  assign vme_irq_no = ~({6'b0, irq_req_i} << (IrqLevel - 1));
  assign dtack_o = answer_q & low;
  // Not after both strobes were high: a strobe there is already the next cycle's.
  assign d_oe_o = (answers | answer_q) & low & strobed;

endmodule

`default_nettype wire
