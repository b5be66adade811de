// SPDX-License-Identifier: Apache-2.0
// One axis: when its D/A and its index latch act. §5.3.1, §5.3.2, §5.3.3
`default_nettype none
`include "mmcs_formal.svh"

module axis_props (
  input wire logic       clk_i,
  input wire logic       no_reset_i,
  input wire logic       reset_i,
  input wire logic       clk_en_i,
  input wire logic       card_i,
  input wire logic       enc_cs_ni,
  input wire logic       ior_ni,
  input wire logic       iow_ni,
  input wire logic       a0_i,
  input wire logic [7:0] d_i,
  input wire logic       dac_lo_i,
  input wire logic       dac_hi_i,
  input wire logic       latch_i,
  input wire logic       dac_update_i,
  input wire logic [2:0] enc_mode_i,
  input wire logic       dac_double_i,
  input wire logic       index_en_i,
  input wire logic       loop_i,
  input wire logic       drive_i,
  input wire logic       a_i,
  input wire logic       b_i,
  input wire logic       i_i,
  input wire logic [15:0] adc_v_i
);

  `MMCS_RESET(no_reset_i)

  logic [15:0] drive_v;
  logic index;
  mark1_axis dut (
    .clk_i, .rst_ni, .reset_i, .clk_en_i, .card_i, .enc_cs_ni, .ior_ni, .iow_ni,
    .a0_i, .d_i, .dac_lo_i, .dac_hi_i,
    .latch_i, .dac_update_i, .enc_mode_i, .dac_double_i, .index_en_i, .loop_i, .drive_i, .a_i,
    .b_i, .i_i, .adc_v_i, .drive_v_o(drive_v), .index_o(index)
  );

  // --- the model: what was written to the D/A, and what of it has reached the output -----------

  logic [11:0] written, written_q, output_q;
  assign written = dac_lo_i ? {written_q[11:8], d_i} : dac_hi_i ? {d_i[3:0], written_q[7:0]}
                                                                : written_q;
  always @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {written_q, output_q} <= {12'h800, 12'h800};
    end else begin
      written_q <= written;
      if (dac_update_i || (dac_hi_i && !dac_double_i)) output_q <= written;
    end
  end

  // --- the model: an index on its way, in ticks of the PC's clock ------------------------------

  // It was seen in a tick, this many ticks ago, and the latch has been armed since.
  logic [1:0] seen_q;
  always @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) seen_q <= 2'd0;
    else if (!index_en_i) seen_q <= 2'd0;
    else if (clk_en_i && seen_q != 2'd0 && seen_q != 2'd3) seen_q <= seen_q + 2'd1;
    else if (clk_en_i && seen_q == 2'd0 && i_i) seen_q <= 2'd1;
  end

  // --- properties -----------------------------------------------------------------------------

  logic [11:0] code;
  assign code = dut.dac_code;

  `MMCS_GIVEN(OneByte, !(dac_lo_i && dac_hi_i), "a write reaches one byte of the D/A")
  `MMCS_PROVE(Output, "5.3.3", drive_i, drive_v == {~output_q[11], output_q[10:0], 4'h0},
              "the output stands where the last transfer put it, ten volts for 2048 steps")
  `MMCS_PROVE(OnlyLatch, "5.3.3", $past(dac_double_i && rst_ni) && code != $past(code),
              $past(dac_update_i),
              "in double-buffer mode the output changes on the latch only")
  `MMCS_PROVE(NextSample, "5.3.3", $past(dac_double_i && dac_update_i && rst_ni),
              code == $past(written),
              "the latch that follows a write puts it out, all bytes written by then and no other")
  `MMCS_PROVE(Direct, "5.3.3", $past(!dac_double_i && dac_hi_i && rst_ni),
              code == {$past(d_i[3:0]), $past(written_q[7:0])},
              "else the high byte takes the low byte with it at once")
  `MMCS_PROVE(LowWaits, "5.3.3", $past(dac_lo_i && !dac_update_i && rst_ni),
              code == $past(code),
              "a low byte by itself changes no output")
  `MMCS_PROVE(IndexCaught, "5.3.2", $past(seen_q == 2'd3 && index_en_i && rst_ni), index,
              "an index that any tick of the clock has seen sets its latch while armed")
  `MMCS_PROVE(IndexStays, "5.3.2", $past(index && index_en_i && rst_ni), index,
              "the index latch stays set while armed")
  `MMCS_PROVE(IndexCleared, "5.3.2", $past(!index_en_i && rst_ni), !index,
              "disarming clears the index latch")
  `MMCS_PROVE(IndexLatches, "5.3.2",
              $past(rst_ni && !reset_i) && index && !$past(index),
              dut.u_encoder.latched_q && dut.u_encoder.latch_q == $past(dut.u_encoder.count_q),
              "when the index latch sets, the counter latches its count, whatever it did before")
  `MMCS_PROVE(LatchLatches, "5.3.2", $past(rst_ni && !reset_i && latch_i),
              dut.u_encoder.latched_q && dut.u_encoder.latch_q == $past(dut.u_encoder.count_q),
              "every latch of the card takes the count of its clock")

  // --- steps on the way -----------------------------------------------------------------------

  // Wires of these names are joined to those of the design when the hierarchy is flattened.
  (* hierconn *) wire [11:0] \dut.dac_code , \dut.u_dac.rank1_q ;
  (* hierconn *) wire [15:0] \dut.u_encoder.latch_q , \dut.u_encoder.count_q ;
  (* hierconn *) wire \dut.u_index.first_q , \dut.u_index.second_q , \dut.index_late_q ;
  wire [2:0] index_stages = {dut.index_late_q, dut.u_index.second_q, dut.u_index.first_q};
  (* hierconn *) wire \dut.u_encoder.latched_q , \dut.index_q , \dut.index_latch_q ;

  `MMCS_LEMMA(Ranks, code == output_q && dut.u_dac.rank1_q == written_q,
              "both hold the same codes")
  `MMCS_LEMMA(Seen, seen_q == 2'd0 || seen_q == 2'd3 || index_stages[seen_q - 2'd1],
              "an index seen travels through the synchroniser")
  `MMCS_LEMMA(Third, seen_q != 2'd3 || index_stages[2] || dut.index_latch_q,
              "the third flip-flop sets the latch")
  `MMCS_LEMMA(Armed, !dut.index_q || dut.index_latch_q, "what is armed has set the latch")

endmodule

`default_nettype wire
