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

  logic ds_any, ds_any_sync;     // a data strobe is low: the pins; synchronised
  logic level_match, ds0_valid;  // an acknowledge of our level; its DS0*
  logic respond_d;
  /* verilator lint_off PROCASSINIT */
  logic respond_q = 1'b0;        // it found us asking: answered, else passed on
  logic iackin, iackin_sync;     // IACKIN* is low: the pin; synchronised
  logic iackin_stale_q = 1'b0;   // it stood as AS* rose: of a cycle that is over
  /* verilator lint_on PROCASSINIT */
  logic iackin_valid;
  logic done_d, done_q;          // answered already, or SYSRESET* came in between
  logic answer_start, answer_d, answer_q;

  assign ds_any = ~(&vme_ds_ni);

  vme_strobe u_strobe (
    .clk_i, .rst_ni,
    .as_ni(vme_as_ni),
    .ds0_ni(vme_ds_ni[0]),
    .match_i(~vme_iack_ni && vme_a_i == 3'(AckLevel)),
    .selected_o(level_match),
    .ds0_valid_o(ds0_valid)
  );

  assign respond_d = IrqLevel == AckLevel && irq_req_i && level_match;

  always_ff @(negedge vme_iackin_ni or negedge rst_ni) begin
    if (!rst_ni) respond_q <= 1'b0;
    else respond_q <= respond_d;
  end

  assign iackin = ~vme_iackin_ni;

  always_ff @(posedge vme_as_ni or negedge iackin) begin
    if (!iackin) iackin_stale_q <= 1'b0;
    else iackin_stale_q <= 1'b1;
  end

  // Low with IACKIN* high, at once.
  mmcs_sync u_iackin (.clk_i, .rst_ni(iackin), .d_i(1'b1), .q_o(iackin_sync));
  mmcs_sync u_ds_any (.clk_i, .rst_ni, .d_i(ds_any), .q_o(ds_any_sync));

  assign iackin_valid = iackin_sync & ~iackin_stale_q;
  assign answer_start = iackin_valid & respond_q & ~done_q & ds0_valid & ds_any_sync & ~sys_reset_i;
  assign done_d = sys_reset_i | answer_q | (done_q & iackin_sync);
  assign answer_d = answer_q ? (ds_any_sync & ~sys_reset_i) : answer_start;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      done_q   <= 1'b0;
      answer_q <= 1'b0;
    end else begin
      done_q   <= done_d;
      answer_q <= answer_d;
    end
  end

  assign vme_iackout_no = ~(iackin_valid & ~respond_q & ~answer_q & ~vme_as_ni);
  assign vme_irq_no = ~({6'b0, irq_req_i} << (IrqLevel - 1));
  assign dtack_o = answer_q & ds_any_sync;
  // Not after both strobes were high: a strobe there is already the next cycle's.
  assign d_oe_o = (answer_start | answer_q) & ds_any_sync & ds_any;

endmodule

`default_nettype wire
