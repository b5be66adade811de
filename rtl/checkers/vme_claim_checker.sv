// SPDX-License-Identifier: Apache-2.0
// Which cycles of the VMEbus are ours: none but these is answered or driven. §4.3.1, §4.3.6
//
// Decodes the bus a second time, from its pins, and holds the answers against it.
`default_nettype none
`include "checkers/mmcs_rule.svh"

module vme_claim_checker #(
  parameter logic [4:0] BaseA15A11 = 5'b01100,
  parameter int IrqLevel = 5,
  parameter int AckLevel = 5,
  parameter bit Stop = 1'b1
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic [15:1] vme_a_i,
  input  wire logic [ 5:0] vme_am_i,
  input  wire logic        vme_as_ni,
  input  wire logic [ 1:0] vme_ds_ni,
  input  wire logic        vme_lword_ni,
  input  wire logic        vme_iack_ni,
  input  wire logic        vme_iackin_ni,
  input  wire logic        vme_sysreset_ni,
  input  wire logic        vme_iackout_no,
  input  wire logic [ 7:1] vme_irq_no,
  input  wire logic        vme_d_oe_o,
  input  wire logic        vme_dtack_no,
  output logic      [ 6:0] broken_o   // sticky, one bit per rule in the order below
);

  logic [6:0] bad;
  logic data_cycle, ack_cycle, level;
  logic ours_q, dtack_q, iackin_q, as_q, fresh_ours_q;
  logic ack_q;            // an acknowledge of our level
  logic asked_q;          // we were asking when IACKIN* fell, with our level on the bus
  logic irq_q, either_q;  // asking a clock ago; asking in only one of the two, which may be either
  logic [2:0] reset_q;    // clocks of SYSRESET*, saturating
  logic [2:0] up_q;       // the last clocks were without it
  logic calm_q;           // no SYSRESET* since before IACKIN* fell

  logic unused;
  assign unused = ^{vme_a_i[10:4], vme_ds_ni[1]};

  assign level = (vme_a_i[3:1] == 3'(AckLevel)) && !vme_iack_ni;
  assign data_cycle = vme_iack_ni && vme_lword_ni && !vme_ds_ni[0] &&
                      (vme_a_i[15:11] == BaseA15A11) && (vme_am_i == 6'h29 || vme_am_i == 6'h2D);
  assign ack_cycle = level && !vme_iackin_ni && !vme_ds_ni[0];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      ours_q       <= 1'b0;
      dtack_q      <= 1'b0;
      iackin_q     <= 1'b0;
      as_q         <= 1'b0;
      fresh_ours_q <= 1'b0;
      ack_q        <= 1'b0;
      asked_q      <= 1'b0;
      irq_q        <= 1'b0;
      either_q     <= 1'b0;
      reset_q      <= '0;
      up_q         <= '1;
      calm_q       <= 1'b0;
      broken_o     <= '0;
    end else begin
      ours_q       <= data_cycle || ack_cycle;
      fresh_ours_q <= ours_q;
      dtack_q      <= ~vme_dtack_no;
      iackin_q     <= ~vme_iackin_ni;
      as_q         <= ~vme_as_ni;
      ack_q        <= ack_cycle;
      irq_q <= !vme_irq_no[IrqLevel];
      if (!vme_iackin_ni && !iackin_q) begin
        asked_q  <= level && !vme_irq_no[IrqLevel] && irq_q;
        either_q <= level && (!vme_irq_no[IrqLevel] || irq_q);
      end
      if (vme_sysreset_ni) reset_q <= '0;
      else if (reset_q != '1) reset_q <= reset_q + 1'b1;
      up_q <= {up_q[1:0], vme_sysreset_ni};
      if (!vme_sysreset_ni) calm_q <= 1'b0;
      else if (!vme_iackin_ni && !iackin_q) calm_q <= &up_q;
      broken_o <= broken_o | bad;
    end
  end

  logic answers;   // DTACK* has just fallen
  assign answers = !vme_dtack_no && !dtack_q;

  `MMCS_RULE(0, AnswerOurs, !answers || ours_q || fresh_ours_q,
             "DTACK* falls only in a cycle that is ours by address, modifier, size and level")
  `MMCS_RULE(1, DriveOurs,
             !vme_d_oe_o || data_cycle || level || vme_dtack_no == 1'b0 || ours_q,
             "data is driven only in a cycle that is ours")
  `MMCS_RULE(2, AnswerAsked, !(answers && ack_q) || either_q,
             "an acknowledge is answered only if we asked when IACKIN* fell")
  // Lines that rise with the clock are vme_edge_checker's business.
  `MMCS_RULE(3, PassInChain,
             vme_iackout_no || !((vme_iackin_ni && !iackin_q) || (vme_as_ni && !as_q)),
             "IACKOUT* is low only while IACKIN* and AS* are")
  `MMCS_RULE(4, PassOthers,
             vme_iackout_no || !(asked_q && iackin_q && level && calm_q && vme_sysreset_ni),
             "an acknowledge that is ours is not passed on")
  `MMCS_RULE(5, OneLine, (vme_irq_no | (7'd1 << (IrqLevel - 1))) == 7'h7F,
             "no request line but the jumpered one is pulled")
  `MMCS_RULE(6, QuietInReset, reset_q < 3'd5 || (vme_dtack_no && !vme_d_oe_o && (&vme_irq_no)),
             "SYSRESET* stops drivers and releases the request")

endmodule

`default_nettype wire
