// SPDX-License-Identifier: Apache-2.0
// PC control and status register with the two interrupt latches. §4.3.3, §4.3.6, Table 4.1
//
// A latch is set by the rising edge of its signal while LATCH_EN is 1 and held clear while it is 0.
// An edge that falls on the very clock edge that sets LATCH_EN counts; one clock earlier it is lost.
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
  // What it controls
  output logic      [4:0] base_o,        // PC address bits A09-A05
  output logic            irq_req_o
);

  localparam int Base = mmcs_regs_pkg::PCCSR_BASE;
  localparam int SclockEn = mmcs_regs_pkg::PCCSR_SCLOCK_EN;
  localparam int PanicEn = mmcs_regs_pkg::PCCSR_PANIC_EN;
  localparam int LatchEn = mmcs_regs_pkg::PCCSR_LATCH_EN;
  localparam logic [7:0] LatchBits = 8'((1 << mmcs_regs_pkg::PCCSR_SCLOCK_LATCHED) |
                                        (1 << mmcs_regs_pkg::PCCSR_PANIC_LATCHED));

  logic [7:0] csr_q;
  logic sclock_q, panic_q;               // a clock ago
  logic sclock_rise, panic_rise;
  logic sclock_latch_q, panic_latch_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) csr_q <= mmcs_regs_pkg::PCCSR_RESET;
    else if (sys_reset_i) csr_q <= mmcs_regs_pkg::PCCSR_RESET;
    else if (write_i) csr_q <= wdata_i;
  end

  assign sclock_rise = sclock_i & ~sclock_q;
  assign panic_rise = panic_i & ~panic_q;

  // Starting at 1, a level that is high from the beginning is no edge.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sclock_q       <= 1'b1;
      panic_q        <= 1'b1;
      sclock_latch_q <= 1'b0;
      panic_latch_q  <= 1'b0;
    end else begin
      sclock_q       <= sclock_i;
      panic_q        <= panic_i;
      sclock_latch_q <= csr_q[LatchEn] & (sclock_latch_q | sclock_rise);
      panic_latch_q  <= csr_q[LatchEn] & (panic_latch_q | panic_rise);
    end
  end

  // The latches are read where their enables are written.
  logic [7:0] latches;
  assign latches = (8'(sclock_latch_q) << mmcs_regs_pkg::PCCSR_SCLOCK_LATCHED) |
                   (8'(panic_latch_q) << mmcs_regs_pkg::PCCSR_PANIC_LATCHED);
  assign rdata_o = (csr_q & ~LatchBits) | latches;

  assign base_o = csr_q[Base+:5];
  assign irq_req_o = (sclock_latch_q & csr_q[SclockEn]) | (panic_latch_q & csr_q[PanicEn]);

  `MMCS_ASSERT(RequestHasLatch, !irq_req_o || sclock_latch_q || panic_latch_q,
               "an interrupt is requested only by a latch that is set")

endmodule

`default_nettype wire
