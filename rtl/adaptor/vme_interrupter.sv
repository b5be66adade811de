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

  typedef enum logic [1:0] {
    StIdle,     // waits for IACKIN* to fall
    StRespond,  // the cycle is ours: wait for DS0*, then answer
    StAnswer,   // vector and DTACK* until the strobes go
    StPass      // not ours: IACKOUT* until the cycle ends
  } state_e;

  state_e state_q;
  logic iackin0_q, iackin1_q;   // active high, two stages
  logic strobe0_q, strobe1_q;   // DS0* low
  logic both_high_q;            // first stage: both data strobes high; DTACK* is the second
  logic cycle_q;                // AS* low
  logic req_q;                  // the request when iackin0_q was taken
  logic strobed, ready, dtack_q;

  assign strobed = ~(&vme_ds_ni);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      iackin0_q   <= 1'b0;
      iackin1_q   <= 1'b0;
      strobe0_q   <= 1'b0;
      strobe1_q   <= 1'b0;
      both_high_q <= 1'b1;
      cycle_q     <= 1'b0;
      req_q       <= 1'b0;
    end else begin
      iackin0_q   <= ~vme_iackin_ni;
      iackin1_q   <= iackin0_q;
      strobe0_q   <= ~vme_ds_ni[0];
      strobe1_q   <= strobe0_q;
      both_high_q <= ~strobed;
      cycle_q     <= ~vme_as_ni;
      req_q       <= irq_req_i;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= StIdle;
      dtack_q <= 1'b0;
    end else begin
      case (state_q)
        StIdle: begin
          if (iackin0_q && !iackin1_q) begin
            state_q <= (req_q && !vme_iack_ni && !sys_reset_i &&
                        vme_a_i == 3'(AckLevel)) ? StRespond : StPass;
          end
        end
        StRespond: begin
          if (!iackin0_q || sys_reset_i) begin
            state_q <= StIdle;
          end else if (strobe1_q && strobe0_q) begin
            state_q <= StAnswer;
            dtack_q <= strobed && !vme_iack_ni;  // else withdrawn: the strobe is another cycle's
          end
        end
        StAnswer: begin
          if (both_high_q || sys_reset_i) dtack_q <= 1'b0;
          if (!dtack_q) state_q <= StIdle;
        end
        default: begin
          if (!iackin0_q || !cycle_q) state_q <= StIdle;
        end
      endcase
    end
  end

  // IACKOUT* follows AS* without a clock: it must be high 40 ns after it.
  assign vme_iackout_no = ~(state_q == StPass) | vme_as_ni | vme_iackin_ni;

  assign vme_irq_no = ~({6'b0, irq_req_i} << (IrqLevel - 1));

  // Before DTACK* only while the last edge still saw our acknowledge: what is there after a cycle
  // broken off is another's.
  assign ready = (state_q == StRespond) && iackin0_q && strobe1_q && strobe0_q;
  assign d_oe_o = (dtack_q | ready) & strobed & ~vme_iack_ni;
  assign dtack_o = dtack_q;

  `MMCS_ASSERT(OneFate, !(dtack_q && !vme_iackout_no),
               "an acknowledge is answered or passed on, never both")

endmodule

`default_nettype wire
