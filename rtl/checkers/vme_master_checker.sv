// SPDX-License-Identifier: Apache-2.0
// What a VME master owes to its slaves, seen from the pins on every clock. §4.3.1
//
// The proofs assume these rules. In simulation tests break some on purpose, so that bind.sv
// attaches it without Stop: it then says so once for each rule. What is shorter than a clock is
// in vme_timing.sv.
`default_nettype none
`include "checkers/mmcs_rule.svh"

module vme_master_checker #(
  parameter logic [4:0] BaseA15A11 = 5'b01100,
  parameter int BusTimerClks = 128,   // 16 us at 8 MHz: after that BERR* has ended the cycle
  parameter bit Stop = 1'b1
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic [15:1] vme_a_i,
  input  wire logic [ 5:0] vme_am_i,
  input  wire logic        vme_as_ni,
  input  wire logic [ 1:0] vme_ds_ni,
  input  wire logic        vme_write_ni,
  input  wire logic        vme_lword_ni,
  input  wire logic        vme_iack_ni,
  input  wire logic        vme_iackin_ni,
  input  wire logic [15:0] vme_d_i,
  input  wire logic        vme_dtack_no,
  output logic      [ 7:0] broken_o   // sticky, one bit per rule in the order below
);

  localparam int Width = 12;

  logic [7:0] bad;
  logic strobed, strobed_q, strobed2_q, as_q, dtack_q, write_q, chain_q, ours;
  logic [1:0] ds_q;
  logic [22:0] cycle, cycle_q;
  logic [15:0] d_q;
  logic [Width-1:0] low_q;   // clocks that a strobe has been low

  assign strobed = ~(&vme_ds_ni);
  assign cycle = {vme_a_i, vme_am_i, vme_lword_ni, vme_iack_ni};
  // Only our own answer is seen here, so only our own cycles can be judged.
  assign ours = cycle_q[0] && cycle_q[1] && (cycle_q[22:18] == BaseA15A11) && !ds_q[0] &&
                (cycle_q[7:2] == 6'h29 || cycle_q[7:2] == 6'h2D);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      strobed_q  <= 1'b0;
      strobed2_q <= 1'b0;
      as_q       <= 1'b0;
      dtack_q    <= 1'b0;
      write_q    <= 1'b1;
      chain_q    <= 1'b0;
      ds_q       <= '1;
      cycle_q    <= '0;
      d_q        <= '0;
      low_q      <= '0;
      broken_o   <= '0;
    end else begin
      strobed_q  <= strobed;
      strobed2_q <= strobed && strobed_q;
      as_q       <= ~vme_as_ni;
      dtack_q    <= ~vme_dtack_no;
      write_q    <= vme_write_ni;
      chain_q    <= ~vme_iackin_ni;
      ds_q       <= vme_ds_ni;
      cycle_q    <= cycle;
      d_q        <= vme_d_i;
      if (!strobed) low_q <= '0;
      else if (low_q != '1) low_q <= low_q + 1'b1;
      broken_o <= broken_o | bad;
    end
  end

  logic open;   // a data transfer under way and not yet answered
  assign open = strobed && strobed_q && vme_dtack_no && !dtack_q;

  `MMCS_RULE(0, AddressFirst, !(open && vme_as_ni),
             "a data strobe falls in an address cycle, and AS* stands until DTACK*")
  `MMCS_RULE(1, AddressHeld, !open || cycle == cycle_q,
             "address, modifier, LWORD* and IACK* stand until DTACK*")
  `MMCS_RULE(2, WriteHeld, !(strobed && strobed_q) || vme_write_ni == write_q,
             "WRITE* stands while a data strobe is low")
  `MMCS_RULE(3, DataHeld, !(open && !vme_write_ni && !write_q) || vme_d_i == d_q,
             "write data stands until DTACK*")
  `MMCS_RULE(4, StrobeHeld,
             !(strobed_q && !strobed && vme_dtack_no && !dtack_q && ours) ||
             low_q >= Width'(BusTimerClks),
             "data strobes stay low until DTACK* or BERR*")
  `MMCS_RULE(5, AnswerGone, !(strobed && !strobed_q && !vme_dtack_no && dtack_q),
             "the next data strobe waits for DTACK* to be high")
  `MMCS_RULE(6, OneSize, !(open && strobed2_q) || vme_ds_ni == ds_q,
             "the two data strobes fall together")
  `MMCS_RULE(7, ChainInCycle,
             !(!vme_iackin_ni && (vme_iack_ni || vme_as_ni) && (!chain_q || cycle_q[0] || !as_q)),
             "IACKIN* is low only in an acknowledge cycle")

`ifndef FORMAL
`ifndef SYNTHESIS
`ifndef YOSYS
  always @(posedge clk_i) begin
    if (rst_ni && !Stop && |(bad & ~broken_o)) begin
      $display("BROKEN vme_master rules %b at %0t", bad & ~broken_o, $time);
    end
  end
`endif
`endif
`endif

endmodule

`default_nettype wire
