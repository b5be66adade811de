// SPDX-License-Identifier: Apache-2.0
// PCCSR and its two latches, against a second description of them. §4.3.3, §4.3.6
`default_nettype none
`include "mmcs_formal.svh"

module pccsr_props (
  input wire logic       clk_i,
  input wire logic       sys_reset_i,
  input wire logic       write_i,
  input wire logic [7:0] wdata_i,
  input wire logic       sclock_i,
  input wire logic       panic_i
);

  `MMCS_RESET(1'b1)

  logic [7:0] rdata;
  logic [4:0] base;
  logic irq;

  pccsr dut (
    .clk_i, .rst_ni, .sys_reset_i, .write_i, .wdata_i,
    .rdata_o(rdata),
    .sclock_i, .panic_i,
    .base_o(base),
    .irq_req_o(irq)
  );

  // What was written last, with 0 after either reset; the inputs and the register one clock ago.
  logic [7:0] csr_q = '0, rdata_q = '0;
  logic sclock_q = 1'b1, panic_q = 1'b1;
  always @(posedge clk_i) begin
    if (rst_ni) begin
      if (sys_reset_i) csr_q <= '0;
      else if (write_i) csr_q <= wdata_i;
      sclock_q <= sclock_i;
      panic_q  <= panic_i;
      rdata_q  <= rdata;
    end
  end

  logic sclock_edge_q = 1'b0, panic_edge_q = 1'b0;   // a rising edge while bit 7 was set, now shown
  always @(posedge clk_i) begin
    if (rst_ni) begin
      sclock_edge_q <= sclock_i & ~sclock_q & csr_q[7];
      panic_edge_q  <= panic_i & ~panic_q & csr_q[7];
    end
  end

  logic sclock_set, panic_set, sclock_was, panic_was;
  assign {panic_set, sclock_set} = rdata[6:5];
  assign {panic_was, sclock_was} = rdata_q[6:5];

  `MMCS_PROVE(SclockLatchSet, "4.3.6", sclock_set && !sclock_was, sclock_edge_q,
              "the SCLOCK latch is set by nothing but a rising edge with bit 7 set")
  `MMCS_PROVE(PanicLatchSet, "4.3.6", panic_set && !panic_was, panic_edge_q,
              "the PANIC latch is set by nothing but a rising edge with bit 7 set")
  `MMCS_PROVE(SclockEdgeTaken, "4.3.6", sclock_edge_q && csr_q[7], sclock_set,
              "every rising edge of SCLOCK with bit 7 set is latched, while it stays set")
  `MMCS_PROVE(PanicEdgeTaken, "4.3.6", panic_edge_q && csr_q[7], panic_set,
              "every rising edge of PANIC with bit 7 set is latched, while it stays set")
  `MMCS_PROVE(SclockLatchKept, "4.3.6", sclock_was && !sclock_set, !csr_q[7],
              "the SCLOCK latch is lost only while bit 7 is cleared")
  `MMCS_PROVE(PanicLatchKept, "4.3.6", panic_was && !panic_set, !csr_q[7],
              "the PANIC latch is lost only while bit 7 is cleared")
  `MMCS_PROVE(HeldClear, "4.3.6", !csr_q[7], !sclock_set && !panic_set && !irq,
              "while bit 7 is clear both latches are, and nothing interrupts, whatever else is set")
  `MMCS_PROVE(ReadsBack, "4.3.3", csr_q != '0, rdata[7] == csr_q[7] && rdata[4:0] == csr_q[4:0],
              "bits 7 and 4-0 read as written")
  `MMCS_REACH(BothLatched, sclock_set && panic_set && irq, "both latches at once")

endmodule

`default_nettype wire
