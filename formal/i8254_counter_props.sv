// SPDX-License-Identifier: Apache-2.0
// A counter of the 8254, for all events of CLK, GATE and the bus. §4.3.4
`default_nettype none
`include "mmcs_formal.svh"

module i8254_counter_props #(
  parameter bit NmosRewrite = 1'b1,
  parameter bit SplitCr = 1'b1
) (
  input wire logic       clk_i,
  input wire logic       no_reset_i,
  input wire logic       rise_i,
  input wire logic       fall_i,
  input wire logic       gate_i,
  input wire logic       control_i,
  input wire logic       latch_count_i,
  input wire logic       latch_status_i,
  input wire logic       write_i,
  input wire logic       read_i,
  input wire logic       read_end_i,
  input wire logic [7:0] d_i
);

  `MMCS_RESET(no_reset_i)

  logic out, up, down;
  logic [7:0] d;
  i8254_counter #(.NmosRewrite(NmosRewrite), .SplitCr(SplitCr)) dut (
    .clk_i, .rst_ni, .clk_rise_i(rise_i), .clk_fall_i(fall_i), .gate_i, .out_o(out),
    .out_rise_o(up), .out_fall_o(down), .control_i, .latch_count_i, .latch_status_i, .write_i,
    .read_i, .read_end_i, .d_i, .d_o(d)
  );

  logic golden_out;
  logic [7:0] golden_d, status, low_byte, flags;
  logic [8:0] events;
  logic [5:0] control;
  logic [15:0] written, cr, ce, latched;
  i8254_golden #(.NmosRewrite(NmosRewrite), .SplitCr(SplitCr)) golden (
    .clk_i, .rst_ni, .rise_i, .fall_i, .gate_i, .control_i, .latch_count_i, .latch_status_i,
    .write_i, .read_end_i, .d_i, .d_o(golden_d), .out(golden_out), .control, .written, .cr, .ce,
    .latched, .status, .low_byte, .flags, .events
  );

  logic [2:0] mode;
  logic calm;  // nothing but CLK with GATE high
  assign mode = control[3:1];
  assign calm = gate_i && !control_i && !write_i;

  `MMCS_GIVEN(OneEvent, control_i + (latch_count_i || latch_status_i) + write_i + read_end_i <= 1,
              "the bus does one thing at a time")
  `MMCS_GIVEN(HasFormat, !control_i || d_i[5:4] != 2'b00, "a control word names a format")
  `MMCS_PROVE(Out, "4.3.4", 1'b1, out == golden_out, "OUT follows the data sheet in all six modes")
  `MMCS_PROVE(Reads, "4.3.4", read_i, d == golden_d,
              "a read shows status latch, count latch or count, byte by byte")
  `MMCS_PROVE(OutRose, "4.3.4", $past(up) && $past(rst_ni), golden_out && !$past(golden_out),
              "a rise of OUT is announced")
  `MMCS_PROVE(OutFell, "4.3.4", $past(down) && $past(rst_ni), !golden_out && $past(golden_out),
              "a fall of OUT is announced")
  `MMCS_REACH(Period3, mode == 3'd3 && flags[0] && flags[3] && out && $past(!out && calm) && calm,
              "mode 3 counts half a period of an odd count")
  `MMCS_REACH(Strobe5, mode == 3'd5 && !out && flags[3], "mode 5 gives its strobe")

  // --- steps on the way -----------------------------------------------------------------------

  // Wires of these names are joined to the registers when the hierarchy is flattened.
  (* hierconn *) wire [1:0] \dut.rw_q ;
  (* hierconn *) wire [2:0] \dut.m_q ;
  (* hierconn *) wire [7:0] \dut.low_q , \dut.status_q ;
  (* hierconn *) wire [15:0] \dut.written_q , \dut.cr_q , \dut.ce_q , \dut.ol_q ;
  (* hierconn *) wire \dut.rolled_q ;
  (* hierconn *) wire \dut.bcd_q , \dut.half_write_q , \dut.half_read_q , \dut.count_latched_q ;
  (* hierconn *) wire \dut.status_latched_q , \dut.armed_q , \dut.fresh_q , \dut.ready_q ;
  (* hierconn *) wire \dut.loaded_q , \dut.stop_q , \dut.odd_q , \dut.strobe_q , \dut.gate_q ;
  (* hierconn *) wire \dut.level_q , \dut.edge_q , \dut.trigger_q ;

  `MMCS_LEMMA(Words, control == {dut.rw_q, dut.m_q, dut.bcd_q} && written == dut.written_q &&
              cr == dut.cr_q && ce == dut.ce_q, "both hold the same counts")
  `MMCS_LEMMA(Latches, (!dut.count_latched_q || latched == dut.ol_q) && low_byte == dut.low_q &&
              (!dut.status_latched_q || status == dut.status_q), "both have latched the same")
  `MMCS_LEMMA(Flags, flags == {dut.half_write_q, dut.half_read_q, dut.count_latched_q,
              dut.status_latched_q, dut.loaded_q, !dut.loaded_q || dut.fresh_q || dut.ready_q,
              dut.stop_q, dut.odd_q}, "both are in the same phase")
  `MMCS_LEMMA(Events, events == {dut.rolled_q, dut.fresh_q, dut.ready_q, dut.armed_q, dut.gate_q,
              dut.level_q,
              dut.edge_q, dut.trigger_q, dut.strobe_q}, "both wait for the same")
  `MMCS_LEMMA(Even, mode[1:0] != 2'd3 || !flags[3] || !ce[0], "mode 3 counts evens")
  `MMCS_LEMMA(Stop, !flags[1] || mode == 3'd0, "only mode 0 is stopped by half a count")
  `MMCS_LEMMA(Halves, flags[7:6] == 2'b00 || control[5:4] == 2'b11, "two bytes have halves")

endmodule

`default_nettype wire
