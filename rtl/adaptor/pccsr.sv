// SPDX-License-Identifier: Apache-2.0
// PC control and status register with the two interrupt latches. §4.3.3, §4.3.6, Table 4.1
//
// A latch is set by the rising edge of its signal while bit 7 is 1 and held clear while it is 0.
// An edge that falls on the very clock edge that sets bit 7 counts; one clock earlier it is lost.
`default_nettype none
`include "mmcs_assert.svh"

module pccsr (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  input  wire logic       sys_reset_i,   // SYSRESET*, synchronised
  // Register access
  input  wire logic       write_i,       // one clock
  input  wire logic [7:0] wdata_i,
  output logic      [7:0] rdata_o,
  // Signals that interrupt
  input  wire logic       sclock_i,
  input  wire logic       panic_i,
  input  wire logic       irq_lost_i,    // fault: edges of SCLOCK are not seen
  // What it controls
  output logic      [4:0] base_o,        // PC address bits A09-A05
  output logic            irq_req_o,
  output logic            settled_o      // no edge is on its way into a latch
);

  logic [7:0] csr_q;
  logic sclock_q, panic_q;
  logic sclock_latch_q, panic_latch_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) csr_q <= mmcs_regs_pkg::PCCSR_RESET;
    else if (sys_reset_i) csr_q <= mmcs_regs_pkg::PCCSR_RESET;
    else if (write_i) csr_q <= wdata_i;
  end

  // Starting at 1, a level that is high from the beginning is no edge.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sclock_q       <= 1'b1;
      panic_q        <= 1'b1;
      sclock_latch_q <= 1'b0;
      panic_latch_q  <= 1'b0;
    end else if (!settled_o) begin
      sclock_q <= sclock_i;
      panic_q  <= panic_i;
      if (!csr_q[mmcs_regs_pkg::PCCSR_LATCH_EN]) begin
        sclock_latch_q <= 1'b0;
        panic_latch_q  <= 1'b0;
      end else begin
        if (sclock_i && !sclock_q && !irq_lost_i) sclock_latch_q <= 1'b1;
        if (panic_i && !panic_q) panic_latch_q <= 1'b1;
      end
    end
  end

  assign base_o = csr_q[4:0];
  assign rdata_o = {csr_q[7], panic_latch_q, sclock_latch_q, csr_q[4:0]};
  assign irq_req_o = (sclock_latch_q & csr_q[mmcs_regs_pkg::PCCSR_SCLOCK_EN]) |
                     (panic_latch_q & csr_q[mmcs_regs_pkg::PCCSR_PANIC_EN]);
  assign settled_o = (sclock_i == sclock_q) && (panic_i == panic_q) &&
                     (csr_q[mmcs_regs_pkg::PCCSR_LATCH_EN] || !(sclock_latch_q || panic_latch_q));

  `MMCS_ASSERT(RequestHasLatch, !irq_req_o || sclock_latch_q || panic_latch_q,
               "an interrupt is requested only by a latch that is set")

endmodule

`default_nettype wire
