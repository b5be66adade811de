// SPDX-License-Identifier: Apache-2.0
// D08(O) interrupter on one level, with the IACK* daisy chain. §4.3.6
//
// Who answers is decided once per falling edge of IACKIN*, by the request as it stood then: a
// request that comes later does not steal the cycle. The request is released by the register
// (PCCSR bit 7), not by the acknowledge. J5 and J7 set apart, no acknowledge is ever answered.
`default_nettype none
`include "mmcs_assert.svh"

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

  logic strobed, seen;          // raw: a data strobe is low; first stage: DS0* of an acknowledge
  logic in0_q, in1_q;           // two stages: IACKIN* is low, and has not been high since
  logic req_q;                  // the request when in0_q was taken
  logic decides, mine;          // now; and for us
  logic claim_q;                // decided so, waits for DS0*
  logic pass_q;                 // decided against us: IACKOUT*
  logic ready_d, ready_q;       // the strobe has come
  logic own_q, own1_q;          // neither IACKIN*, AS* nor DS0* has gone since; a clock ago
  logic answer_q, busy;
  logic low0_q, low1_q;         // two stages: a data strobe is low, and has not been high since

  assign strobed = ~(&vme_ds_ni);

  vme_strobe u_strobe (
    .clk_i, .rst_ni,
    .as_ni(vme_as_ni),
    .ds0_ni(vme_ds_ni[0]),
    .ours_i(~vme_iack_ni),
    .seen_o(seen)
  );

  // --- flip-flops that the bus clears, however short a line is high --------------------------

  logic in_n, pass_n, own_n, low_n;
  assign in_n = rst_ni & ~vme_iackin_ni;
  assign pass_n = rst_ni & ~vme_iackin_ni & ~vme_as_ni;
  assign own_n = rst_ni & ((~vme_iackin_ni & ~vme_as_ni & ~vme_ds_ni[0]) | answer_q);
  assign low_n = rst_ni & strobed;

  always_ff @(posedge clk_i or negedge in_n) begin
    if (!in_n) in0_q <= 1'b0;
    else in0_q <= 1'b1;
  end

  always_ff @(posedge clk_i or negedge pass_n) begin
    if (!pass_n) {pass_q, claim_q} <= 2'b00;
    else if (decides) {pass_q, claim_q} <= {~mine, mine};
    else if (busy || sys_reset_i) claim_q <= 1'b0;
  end

  always_ff @(posedge clk_i or negedge own_n) begin
    if (!own_n) own_q <= 1'b0;
    else if (sys_reset_i) own_q <= 1'b0;
    else if (answer_q && !low1_q) own_q <= 1'b0;
    else if (!answer_q && !ready_q) own_q <= ready_d;
  end

  always_ff @(posedge clk_i or negedge low_n) begin
    if (!low_n) low0_q <= 1'b0;
    else low0_q <= 1'b1;
  end

  // --- decision and answer ------------------------------------------------------------------

  // A fall of IACKIN* that comes while another one is still answered waits for the end of that.
  assign busy = ready_q | answer_q;
  assign decides = in0_q & ~in1_q & ~busy;
  assign mine = (IrqLevel == AckLevel) && req_q && !sys_reset_i && !vme_iack_ni &&
                vme_a_i == 3'(AckLevel);
  assign ready_d = (decides ? mine : claim_q) & seen & ~busy & ~sys_reset_i;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      in1_q    <= 1'b0;
      req_q    <= 1'b0;
      ready_q  <= 1'b0;
      own1_q   <= 1'b0;
      low1_q   <= 1'b0;
      answer_q <= 1'b0;
    end else begin
      in1_q   <= in0_q & (in1_q | ~busy);
      if (!in0_q) req_q <= irq_req_i;
      ready_q <= ready_d;
      own1_q  <= own_q;
      low1_q  <= low0_q;
      if (answer_q) answer_q <= low1_q & own1_q & ~sys_reset_i;
      else answer_q <= ready_q & ~sys_reset_i;
    end
  end

  assign vme_iackout_no = ~pass_q;
  assign vme_irq_no = ~({6'b0, irq_req_i} << (IrqLevel - 1));
  assign dtack_o = answer_q & own_q;
  // Not after both strobes were high: a strobe there is already the next cycle's.
  assign d_oe_o = own_q & low0_q & low1_q & strobed;

  `MMCS_ASSERT(OneFate, !(own_q && pass_q), "an acknowledge is answered or passed on, never both")

endmodule

`default_nettype wire
