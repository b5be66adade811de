// SPDX-License-Identifier: Apache-2.0
// PC control and status register with the two interrupt latches. §4.3.3, §4.3.6, Table 4.1
//
// A latch is set by the rising edge of its signal while LATCH_EN is 1 and held clear while it is 0.
// An edge that falls on the very clock edge that sets LATCH_EN counts; one clock earlier it is lost.
// The write that clears LATCH_EN clears them at once, and no request comes of what else it sets.
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

  logic [7:0] csr_d, csr_q;
  logic sclock_q, panic_q;               // a clock ago
  logic sclock_rise, panic_rise;
  logic armed;                           // before and after the clock
  logic sclock_latch_d, sclock_latch_q, panic_latch_d, panic_latch_q;
  logic irq_req_d, irq_req_q;            // a flip-flop: IRQ* must not glitch

  always_comb begin
    csr_d = csr_q;
    if (sys_reset_i) csr_d = mmcs_regs_pkg::PCCSR_RESET;
    else if (write_i) csr_d = wdata_i;
  end

  assign sclock_rise = sclock_i & ~sclock_q;
  assign panic_rise = panic_i & ~panic_q;
  assign armed = csr_q[LatchEn] & csr_d[LatchEn];
  assign sclock_latch_d = armed & (sclock_latch_q | sclock_rise);
  assign panic_latch_d = armed & (panic_latch_q | panic_rise);
  assign irq_req_d = (sclock_latch_d & csr_d[SclockEn]) | (panic_latch_d & csr_d[PanicEn]);

  // Starting at 1, a level that is high from the beginning is no edge.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      csr_q          <= mmcs_regs_pkg::PCCSR_RESET;
      sclock_q       <= 1'b1;
      panic_q        <= 1'b1;
      sclock_latch_q <= 1'b0;
      panic_latch_q  <= 1'b0;
      irq_req_q      <= 1'b0;
    end else begin
      csr_q          <= csr_d;
      sclock_q       <= sclock_i;
      panic_q        <= panic_i;
      sclock_latch_q <= sclock_latch_d;
      panic_latch_q  <= panic_latch_d;
      irq_req_q      <= irq_req_d;
    end
  end

  // The latches are read where their enables are written.
  logic [7:0] latches;
  assign latches = (8'(sclock_latch_q) << mmcs_regs_pkg::PCCSR_SCLOCK_LATCHED) |
                   (8'(panic_latch_q) << mmcs_regs_pkg::PCCSR_PANIC_LATCHED);
  assign rdata_o = (csr_q & ~LatchBits) | latches;

  assign base_o = csr_q[Base+:5];
  assign irq_req_o = irq_req_q;

  `MMCS_ASSERT(RequestHasLatch, !irq_req_o || sclock_latch_q || panic_latch_q,
               "an interrupt is requested only by a latch that is set")

endmodule

`default_nettype wire
