// SPDX-License-Identifier: Apache-2.0
// The encoder counter, for all pins, modes and bus accesses. §5.3.2
`default_nettype none
`include "mmcs_formal.svh"

module thct2000_props (
  input wire logic       clk_i,
  input wire logic       no_reset_i,
  input wire logic       reset_i,
  input wire logic       clk_en_i,
  input wire logic [2:0] m_i,
  input wire logic       a_i,
  input wire logic       b_i,
  input wire logic       latch_i,
  input wire logic       other_i,
  input wire logic       cs_ni,
  input wire logic       rd_ni,
  input wire logic       wr_ni,
  input wire logic       rs_i,
  input wire logic [7:0] d_i
);

  `MMCS_RESET(no_reset_i)

  logic [7:0] d;
  logic oe, illegal;
  logic [15:0] count;

  thct2000 dut (
    .clk_i, .rst_ni, .reset_i, .clk_en_i, .m_i, .a_i, .b_i, .latch_i, .other_i,
    .cs_ni, .rd_ni, .wr_ni, .rs_i, .d_i,
    .d_o(d),
    .d_oe_o(oe),
    .count_o(count),
    .illegal_o(illegal)
  );

  // --- the model: inputs ----------------------------------------------------------------------

  // Where an encoder stands in its cycle: 00, 10, 11, 01 are 0 to 3.
  function automatic logic [1:0] place(input logic [1:0] ab);
    place = {ab[0], ab[1] ^ ab[0]};
  endfunction

  // Samples of {A, B}, the last in [0]; all steps seen at the pins, and that as the chip sees it.
  logic [1:0] pins, seen1_q, seen2_q, seen3_q, moved, apart;
  logic [15:0] sum_q, sum1_q, sum2_q;
  assign pins = {a_i, b_i};
  assign moved = place(pins) - place(seen1_q);  // 3 is a step back, 2 is no step

  always @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {seen1_q, seen2_q, seen3_q} <= '0;
      {sum_q, sum1_q, sum2_q}     <= '0;
    end else if (clk_en_i) begin
      {seen3_q, seen2_q, seen1_q} <= {seen2_q, seen1_q, pins};
      {sum2_q, sum1_q} <= {sum1_q, sum_q};
      sum_q <= sum_q + (moved == 2'd1 ? 16'd1 : moved == 2'd3 ? 16'hFFFF : 16'd0);
    end
  end

  // --- the model: counting --------------------------------------------------------------------

  // A step passes one of four boundaries of the cycle: 0 and 2 are edges of A, 1 and 3 of B.
  function automatic logic passes(input logic [2:0] m, input logic [1:0] boundary);
    case (m)
      3'd1:    passes = boundary == 2'd0;
      3'd2:    passes = boundary == 2'd2;
      3'd3:    passes = !boundary[0];
      3'd4:    passes = boundary[0];
      3'd5:    passes = 1'b1;
      default: passes = 1'b0;
    endcase
  endfunction

  logic step_mode, up, down, closes, ticks;
  logic [15:0] count_q, latch_q, next;
  logic latched_q, illegal_q;
  assign step_mode = m_i != 3'd0 && m_i < 3'd6;
  assign apart  = place(seen2_q) - place(seen3_q);
  assign up     = apart == 2'd1 && passes(m_i, place(seen3_q));
  assign down   = apart == 2'd3 && passes(m_i, place(seen2_q));
  assign ticks  = m_i == 3'd6 ? seen2_q[1] : m_i == 3'd7 && seen2_q == 2'b11 && !seen3_q[1];
  assign closes = m_i == 3'd6 ? {seen3_q[1], seen2_q[1]} == 2'b10
                              : m_i == 3'd7 && {seen3_q[0], seen2_q[0]} == 2'b10;
  assign next   = closes ? 16'd0 : up || ticks ? count_q + 16'd1 : down ? count_q - 16'd1 : count_q;

  // --- the model: bus -------------------------------------------------------------------------

  // open_q: what came last was the first byte of a pair that the other byte may still complete.
  logic rd, wr, rd_q, wr_q, snaps, store, both;
  logic open_q, open_wr_q, open_rs_q, wr_rs_q;
  logic [2:0] mode_q;
  logic [7:0] wr_d_q, waits_q;
  logic [15:0] sample, sample_q, kept;
  assign rd    = !cs_ni && !rd_ni;
  assign wr    = !cs_ni && !wr_ni;
  assign snaps = rd && !rd_q && !(open_q && !open_wr_q && rs_i != open_rs_q);
  assign sample = !snaps ? sample_q : latched_q ? latch_q : count_q;
  assign store = wr_q && !wr;
  assign both  = open_q && open_wr_q && wr_rs_q != open_rs_q;
  assign kept  = both ? {2{waits_q}} : clk_en_i ? next : count_q;   // the byte not written now

  always @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {rd_q, wr_q, mode_q, wr_rs_q, wr_d_q} <= '0;
      {open_q, open_wr_q, open_rs_q, waits_q, sample_q} <= '0;
      {count_q, latch_q, latched_q, illegal_q} <= '0;
    end else begin
      {rd_q, wr_q, mode_q} <= {rd, wr, m_i};
      if (wr) {wr_rs_q, wr_d_q} <= {rs_i, d_i};
      if (reset_i) begin
        {open_q, waits_q, sample_q} <= '0;
        {count_q, latch_q, latched_q, illegal_q} <= '0;
      end else begin
        if (rd && !rd_q) {open_q, open_wr_q, open_rs_q} <= {snaps, 1'b0, rs_i};
        if (snaps) {sample_q, latched_q} <= {sample, 1'b0};
        if (latch_i || (clk_en_i && closes)) begin
          {latched_q, latch_q} <= {1'b1, count_q};
        end
        if (clk_en_i && step_mode && apart == 2'd2) illegal_q <= 1'b1;
        if (store) {open_q, open_wr_q, open_rs_q, waits_q} <= {!both, 1'b1, wr_rs_q, wr_d_q};
        if (store) count_q <= wr_rs_q ? {kept[15:8], wr_d_q} : {wr_d_q, kept[7:0]};
        else if (clk_en_i) count_q <= next;
        if (other_i || m_i != mode_q) open_q <= 1'b0;
      end
    end
  end

  // --- properties -----------------------------------------------------------------------------

  `MMCS_PROVE(Counts, "5.3.2", 1'b1, count == count_q,
              "the count is the sum of the steps that its mode counts, or the last write")
  `MMCS_PROVE(NoneLost, "5.3.2",
              $past(m_i) == 3'd5 && !$past(reset_i || store || !rst_ni) && count != $past(count),
              count - $past(count) == sum2_q - $past(sum2_q),
              "in mode 5 the count moves as the pins did, no step lost, none invented")
  `MMCS_PROVE(NoneKept, "5.3.2",
              $past(m_i) == 3'd5 && !$past(reset_i || store || !rst_ni) && sum2_q != $past(sum2_q),
              count - $past(count) == sum2_q - $past(sum2_q),
              "in mode 5 every step at the pins reaches the count three ticks later")
  `MMCS_PROVE(Illegal, "5.3.2", illegal_q, illegal,
              "two edges between two ticks are flagged")
  `MMCS_PROVE(Legal, "5.3.2", !illegal_q, !illegal,
              "nothing else is flagged")
  `MMCS_PROVE(High, "5.3.2", rd && !rs_i, oe && d == sample[15:8],
              "the high byte of a read is that of the sample which the first byte took")
  `MMCS_PROVE(Low, "5.3.2", rd && rs_i, oe && d == sample[7:0],
              "the low byte of a read is that of the sample which the first byte took")
  `MMCS_PROVE(Latched, "5.3.2", snaps && latched_q, sample == latch_q && {d, d} == (rs_i ?
              {2{latch_q[7:0]}} : {2{latch_q[15:8]}}),
              "the first read after a latch shows the count at the latch")
  `MMCS_PROVE(Fresh, "5.3.2", rd && !rd_q && $past(other_i || reset_i || !rst_ni), snaps,
              "after another access to the board, or RESET, a read takes a sample of its own")
  `MMCS_PROVE(StoredWhole, "5.3.2", $past(store && both && rst_ni && !reset_i),
              count == ($past(wr_rs_q) ? {$past(waits_q), $past(wr_d_q)} :
                                         {$past(wr_d_q), $past(waits_q)}),
              "the second byte written stores both, whatever was counted in between")
  `MMCS_REACH(BothBytes, rd && !rd_q && !snaps && sample[15:8] != 8'h00 && sample != count_q,
              "a second byte of an older sample is read")

  // --- steps on the way -----------------------------------------------------------------------

  // Wires of these names are joined to the registers when the hierarchy is flattened.
  (* hierconn *) wire [1:0] \dut.u_pins.first_q , \dut.u_pins.second_q , \dut.prev_q ;
  (* hierconn *) wire \dut.rd_q , \dut.wr_q , \dut.rs_q , \dut.latched_q ;
  (* hierconn *) wire \dut.pair_q , \dut.pair_wr_q , \dut.pair_rs_q ;
  (* hierconn *) wire [2:0] \dut.m_q ;
  (* hierconn *) wire [7:0] \dut.d_q , \dut.held_q ;
  (* hierconn *) wire [15:0] \dut.snap_q , \dut.latch_q ;

  `MMCS_LEMMA(Inputs, {dut.u_pins.first_q, dut.u_pins.second_q, dut.prev_q} ==
              {seen1_q, seen2_q, seen3_q} && {dut.rd_q, dut.wr_q, dut.m_q} == {rd_q, wr_q, mode_q},
              "both see the same pins")
  `MMCS_LEMMA(Sums, sum_q - sum1_q == (seen1_q == seen2_q ? 16'd0 :
              place(seen1_q) - place(seen2_q) == 2'd1 ? 16'd1 :
              place(seen1_q) - place(seen2_q) == 2'd3 ? 16'hFFFF : 16'd0) &&
              sum1_q - sum2_q == (apart == 2'd1 ? 16'd1 : apart == 2'd3 ? 16'hFFFF : 16'd0),
              "the sums differ by the steps between the samples")
  `MMCS_LEMMA(Latches, dut.latched_q == latched_q && dut.latch_q == latch_q &&
              dut.snap_q == sample_q, "both hold the same latch and sample")
  `MMCS_LEMMA(Pairs, dut.pair_q == open_q && dut.held_q == waits_q &&
              {dut.pair_wr_q, dut.pair_rs_q} == {open_wr_q, open_rs_q} &&
              (!wr_q || {dut.rs_q, dut.d_q} == {wr_rs_q, wr_d_q}),
              "both know the byte that waits for the other")

endmodule

`default_nettype wire
