// SPDX-License-Identifier: Apache-2.0
// The bus of the 8254: what each counter is told. §4.3.4
`default_nettype none
`include "mmcs_formal.svh"

module i8254_props (
  input wire logic       clk_i,
  input wire logic       no_reset_i,
  input wire logic       cs_ni,
  input wire logic       rd_ni,
  input wire logic       wr_ni,
  input wire logic [1:0] a_i,
  input wire logic [7:0] d_i,
  input wire logic [2:0] rise_i,
  input wire logic [2:0] fall_i,
  input wire logic [2:0] gate_i
);

  `MMCS_RESET(no_reset_i)

  logic [7:0] d;
  logic oe;
  i8254 dut (
    .clk_i, .rst_ni, .cs_ni, .rd_ni, .wr_ni, .a_i, .d_i, .d_o(d), .d_oe_o(oe),
    .clk0_rise_i(rise_i[0]), .clk0_fall_i(fall_i[0]), .clk1_rise_i(rise_i[1]),
    .clk1_fall_i(fall_i[1]), .clk2_rise_i(rise_i[2]), .clk2_fall_i(fall_i[2]), .gate_i
  );

  // The last clock of each strobe, and what stood on the bus then. A read with a write is a read.
  logic [1:0] strobe, strobe_q, at_q;  // 1 read, 2 write
  logic [7:0] data_q;
  logic read_ends, write_ends;
  assign strobe = cs_ni ? 2'd0 : !rd_ni ? 2'd1 : !wr_ni ? 2'd2 : 2'd0;
  assign read_ends  = strobe_q == 2'd1 && strobe != 2'd1;
  assign write_ends = strobe_q == 2'd2 && strobe != 2'd2;
  always @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {strobe_q, at_q, data_q} <= '0;
    end else begin
      strobe_q <= strobe;
      if (strobe != 2'd0) at_q <= a_i;
      if (strobe == 2'd2) data_q <= d_i;
    end
  end

  // Wires of these names are joined to those of the design when the hierarchy is flattened.
  (* hierconn *) wire [2:0] \dut.write , \dut.read_end , \dut.control , \dut.latch_count ;
  (* hierconn *) wire [2:0] \dut.latch_status ;
  (* hierconn *) wire [7:0] \dut.d_q ;
  (* hierconn *) wire [23:0] \dut.d ;   // what each counter shows
  (* hierconn *) wire [1:0] \dut.a_q ;
  (* hierconn *) wire \dut.rd_q , \dut.wr_q ;

  // What each counter is to be told.
  logic to_control;
  logic [2:0] named, at, control, latches, counts, states;
  assign to_control = write_ends && at_q == 2'd3;
  assign named   = 3'(8'd1 << data_q[7:6]);  // 3 names none: it is the read-back
  assign at      = 3'(8'd1 << at_q);
  assign control = to_control && data_q[5:4] != 2'b00 ? named : 3'b000;
  assign latches = to_control && data_q[5:4] == 2'b00 ? named : 3'b000;
  assign counts  = to_control && data_q[7:5] == 3'b110 ? data_q[3:1] : 3'b000;
  assign states  = to_control && data_q[7:6] == 2'b11 && !data_q[4] ? data_q[3:1] : 3'b000;

  `MMCS_PROVE(Control, "4.3.4", control != 3'b000, dut.control == control && dut.d_q == data_q,
              "a control word reaches the counter that it names")
  `MMCS_PROVE(NoControl, "4.3.4", control == 3'b000, dut.control == 3'b000,
              "nothing else sets a counter's mode")
  `MMCS_PROVE(Write, "4.3.4", write_ends && at_q != 2'd3, dut.write == at && dut.d_q == data_q,
              "a write at a counter's address gives it that byte")
  `MMCS_PROVE(NoWrite, "4.3.4", !write_ends || at_q == 2'd3, dut.write == 3'b000,
              "nothing else writes a counter")
  `MMCS_PROVE(LatchCount, "4.3.4", latches != 3'b000, dut.latch_count == latches,
              "a counter latch command reaches the counter that it names")
  `MMCS_PROVE(ReadBack, "4.3.4", (counts | states) != 3'b000,
              dut.latch_count == counts && dut.latch_status == states,
              "a read-back latches count or status or both of all counters that it selects")
  `MMCS_PROVE(NoLatch, "4.3.4", (latches | counts | states) == 3'b000,
              dut.latch_count == 3'b000 && dut.latch_status == 3'b000, "nothing else latches")
  `MMCS_PROVE(ReadEnd, "4.3.4", read_ends && at_q != 2'd3, dut.read_end == at,
              "the end of a read moves its counter to the next byte")
  `MMCS_PROVE(NoReadEnd, "4.3.4", !read_ends || at_q == 2'd3, dut.read_end == 3'b000,
              "nothing else does")
  `MMCS_PROVE(OneThing, "4.3.4", 1'b1,
              (dut.control & dut.write) == 3'b000 && (dut.control & dut.read_end) == 3'b000 &&
              (dut.write & dut.read_end) == 3'b000 && (dut.latch_count | dut.latch_status) ==
              ((dut.latch_count | dut.latch_status) & ~(dut.control | dut.write | dut.read_end)),
              "a counter is told one thing at a time")
  `MMCS_PROVE(Reads, "4.3.4", strobe == 2'd1 && a_i != 2'd3,
              oe && d == (a_i == 2'd0 ? dut.d[7:0] : a_i == 2'd1 ? dut.d[15:8] : dut.d[23:16]),
              "a read shows the counter that it names")

  `MMCS_LEMMA(Bus, {dut.wr_q, dut.rd_q} == strobe_q && dut.a_q == at_q &&
              (!dut.wr_q || dut.d_q == data_q), "both see the same strobes")

endmodule

`default_nettype wire
