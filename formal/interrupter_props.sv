// SPDX-License-Identifier: Apache-2.0
// The interrupter in its daisy chain, for all inputs. §4.3.6
`default_nettype none
`include "mmcs_formal.svh"

module interrupter_props #(
  parameter int IrqLevel = 5,
  parameter int AckLevel = 5
) (
  input wire logic       clk_i,
  input wire logic       sys_reset_i,
  input wire logic       irq_req_i,
  input wire logic [3:1] vme_a_i,
  input wire logic       vme_as_ni,
  input wire logic [1:0] vme_ds_ni,
  input wire logic       vme_iack_ni,
  input wire logic       vme_iackin_ni
);

  logic rst_ni = 1'b0;
  always @(posedge clk_i) rst_ni <= 1'b1;

  logic iackout_n, d_oe, dtack;
  logic [7:1] irq_n;

  vme_interrupter #(
    .IrqLevel(IrqLevel),
    .AckLevel(AckLevel)
  ) dut (
    .clk_i, .rst_ni, .sys_reset_i, .irq_req_i, .vme_a_i, .vme_as_ni, .vme_ds_ni, .vme_iack_ni,
    .vme_iackin_ni,
    .vme_iackout_no(iackout_n),
    .vme_irq_no(irq_n),
    .d_oe_o(d_oe),
    .dtack_o(dtack)
  );

  // Whose an acknowledge is, decided by ourselves: by the request in the clock in which IACKIN* is
  // first seen low, and by the level in the clock after.
  logic iackin_q = 1'b1, fell_q = 1'b0, req_q = 1'b0, own_q = 1'b0;
  logic level, stands;
  logic [2:0] rest_q = '0;    // clocks that chain and strobes have been high
  logic [2:0] low_q = '0;     // clocks that IACKIN* and AS* have been low since
  logic [3:0] wait_q = '0;    // clocks that DS0* has been low in our own acknowledge
  logic rested_q = 1'b0, strobed_q = 1'b0;

  assign level = !vme_iack_ni && vme_a_i == 3'(AckLevel);
  assign stands = own_q && !vme_iackin_ni && !vme_ds_ni[0] && !vme_iack_ni && !sys_reset_i;

  always @(posedge clk_i) begin
    if (rst_ni) begin
      iackin_q  <= vme_iackin_ni;
      fell_q    <= iackin_q && !vme_iackin_ni;
      if (iackin_q && !vme_iackin_ni) req_q <= irq_req_i;
      strobed_q <= ~vme_ds_ni[0];
      if (fell_q) begin
        own_q <= req_q && level && !sys_reset_i && rested_q && !(strobed_q && vme_ds_ni[0]);
      end else if (sys_reset_i || vme_iack_ni || (vme_ds_ni[0] && strobed_q)) own_q <= 1'b0;
      if (vme_iackin_ni && vme_as_ni && (&vme_ds_ni)) begin
        if (rest_q != '1) rest_q <= rest_q + 1'b1;
        rested_q <= rest_q >= 3'd4;
      end else begin
        rest_q <= '0;
        if (!iackin_q && (vme_iackin_ni || vme_as_ni)) rested_q <= 1'b0;   // it is over
      end
      if (vme_iackin_ni || vme_as_ni) low_q <= '0;
      else if (low_q != '1) low_q <= low_q + 1'b1;
      if (!stands) wait_q <= '0;
      else if (wait_q != '1) wait_q <= wait_q + 1'b1;
    end
  end

  // Only our own: since IACKIN* fell last it was decided that it is ours.
  logic ours_q = 1'b0;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      if (fell_q && !dtack) ours_q <= req_q && level && !sys_reset_i;
    end
  end

  `MMCS_PROVE(LineExact, "4.3.6", irq_req_i, irq_n == ~(7'd1 << (IrqLevel - 1)),
              "a request pulls its jumpered line and no other")
  `MMCS_PROVE(LineQuiet, "4.3.6", !irq_req_i, &irq_n, "without a request no line is pulled")
  `MMCS_PROVE(VectorOwn, "4.3.6", d_oe, ours_q && !vme_iack_ni && !(&vme_ds_ni),
              "the vector is driven only in an acknowledge of our level that found us asking")
  `MMCS_PROVE(VectorFresh, "4.3.6", d_oe && !dtack, !iackin_q && strobed_q,
              "before DTACK* it is driven only if the last clock still saw that acknowledge")
  `MMCS_PROVE(AnswerOwn, "4.3.6", dtack, ours_q,
              "DTACK* is given only to an acknowledge of our level that found us asking")
  `MMCS_PROVE(PassInside, "4.3.6", !iackout_n, !vme_iackin_ni && !vme_as_ni,
              "IACKOUT* is low only inside the cycle: it rises with AS* without a clock")
  `MMCS_PROVE(NeverBlocks, "4.3.6",
              rested_q && low_q >= 3'd3 && !ours_q && !vme_iackin_ni && !vme_as_ni, !iackout_n,
              "an acknowledge that is not ours is passed on within three clocks")
  `MMCS_PROVE(OwnKept, "4.3.6", ours_q && own_q && !fell_q && !vme_iackin_ni, iackout_n,
              "an acknowledge that is ours is not passed on")
  `MMCS_PROVE(OwnAnswered, "4.3.6", wait_q >= 4'd5, dtack,
              "an acknowledge that is ours is answered within five clocks of its strobe")

endmodule

`default_nettype wire
