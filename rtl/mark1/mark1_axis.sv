// SPDX-License-Identifier: Apache-2.0
// One axis of a card: encoder counter, A/D, D/A, heartbeat, index latch. §5.3
`default_nettype none
`include "mmcs_assert.svh"

module mark1_axis #(
  parameter bit AdcSpan10 = 1'b0,            // E001-E003: 10 V instead of 20 V
  parameter bit DacSpan10 = 1'b0,            // E007-E008
  parameter int ConvClks = 200,
  parameter int HeartbeatClks = 400_000,
  // What stands in the chips before they are told anything
  parameter logic [11:0] DacPowerUp = 12'h800,
  parameter logic [11:0] AdcPowerUp = 12'h000,
  parameter logic [15:0] CountPowerUp = 16'h0000
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic        reset_i,          // RESET DRV
  // Bus: strobes are high while their command is low
  input  wire logic        clk_en_i,
  input  wire logic        card_i,           // this card is accessed
  input  wire logic        enc_cs_ni,
  input  wire logic        ior_ni,
  input  wire logic        iow_ni,
  input  wire logic        a0_i,
  input  wire logic [ 7:0] d_i,
  input  wire logic        dac_lo_i,
  input  wire logic        dac_hi_i,
  output logic      [ 7:0] enc_d_o,
  output logic             enc_d_oe_o,
  output logic      [11:0] adc_code_o,
  // Board control
  input  wire logic        latch_i,          // one clock
  input  wire logic        dac_update_i,     // one clock
  input  wire logic [ 2:0] enc_mode_i,
  input  wire logic        dac_double_i,
  input  wire logic        index_en_i,
  input  wire logic        loop_i,           // the A/D sees the D/A
  input  wire logic        drive_i,          // the D/A reaches the joint
  // Joint; a, b, i are what the counter is to see
  input  wire logic        a_i,
  input  wire logic        b_i,
  input  wire logic        i_i,
  input  wire logic [15:0] adc_v_i,
  output logic      [15:0] drive_v_o,
  // Status
  output logic             heartbeat_o,
  output logic             index_o,          // index has been latched
  output logic             converting_o
);

  // --- index latch --------------------------------------------------------------------------

  // A and B pass two flip-flops in the counter and are counted at the third clock. The index passes
  // three, so that an edge of A or B which comes with it is in the count that it latches.
  logic index_late_d, index_late_q;
  logic index_in, index, index_q, index_latch_d, index_latch_q;

  mmcs_sync_en u_index (.clk_i, .rst_ni, .en_i(clk_en_i), .d_i(i_i), .q_o(index_in));

  assign index = index_late_q & index_en_i;
  assign index_late_d = clk_en_i ? index_in : index_late_q;
  assign index_latch_d = index_en_i & (index_latch_q | index);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      index_late_q  <= 1'b0;
      index_q       <= 1'b0;
      index_latch_q <= 1'b0;
    end else begin
      index_late_q  <= index_late_d;
      index_q       <= index;
      index_latch_q <= index_latch_d;
    end
  end

  assign index_o = index_latch_q;

  // --- encoder counter ----------------------------------------------------------------------

  /* verilator lint_off PINCONNECTEMPTY */  // debugging outputs
  thct2000 #(
    .PowerUp(CountPowerUp)
  ) u_encoder (
    .clk_i, .rst_ni, .reset_i, .clk_en_i,
    .m_i(enc_mode_i),
    .a_i, .b_i,
    .latch_i(latch_i | (index & ~index_q)),
    .other_i(card_i & enc_cs_ni),
    .cs_ni(enc_cs_ni),
    .rd_ni(ior_ni),
    .wr_ni(iow_ni),
    .rs_i(a0_i),
    .d_i,
    .d_o(enc_d_o),
    .d_oe_o(enc_d_oe_o),
    .count_o(),
    .illegal_o()
  );
  /* verilator lint_on PINCONNECTEMPTY */

  // --- D/A: two ranks; the low byte waits in the first for the high nibble -------------------

  logic [11:0] dac_code;
  logic [15:0] dac_v;

  ad667 #(
    .PowerUp(DacPowerUp)
  ) u_dac (
    .clk_i, .rst_ni,
    .cs_ni(~(dac_lo_i | dac_hi_i | dac_update_i)),
    .a_ni({~(dac_update_i | (dac_hi_i & ~dac_double_i)), ~dac_hi_i, {2{~dac_lo_i}}}),
    .d_i({d_i[3:0], d_i}),
    .code_o(dac_code)
  );

  // Offset binary to signed, 32768 = 10 V; the narrow span is half as much per step.
  assign dac_v = DacSpan10 ? {{2{~dac_code[11]}}, dac_code[10:0], 3'b000}
                           : {~dac_code[11], dac_code[10:0], 4'b0000};
  assign drive_v_o = drive_i ? dac_v : 16'h0000;

  // --- A/D: the code of the last conversion stays readable while the next one runs -----------

  logic [15:0] adc_v;
  logic [11:0] adc_db, adc_code_q;
  logic adc_oe;

  assign adc_v = loop_i ? dac_v : adc_v_i;

  ad574 #(
    .ConvClks(ConvClks),
    .PowerUp(AdcPowerUp)
  ) u_adc (
    .clk_i, .rst_ni,
    .ce_i(1'b1),
    .cs_ni(1'b0),
    .rc_ni(~latch_i),
    .a0_i(1'b0),
    .mode12_i(1'b1),
    .span10_i(AdcSpan10),
    .vin_i(adc_v),
    .sts_o(converting_o),
    .db_o(adc_db),
    .db_oe_o(adc_oe)
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) adc_code_q <= AdcPowerUp;
    else adc_code_q <= adc_code_o;
  end

  assign adc_code_o = adc_oe ? adc_db : adc_code_q;

  // --- heartbeat ----------------------------------------------------------------------------

  oneshot #(
    .PulseClks(HeartbeatClks)
  ) u_heartbeat (
    .clk_i, .rst_ni,
    .trig_i(dac_lo_i),
    .clr_ni(1'b1),
    .q_o(heartbeat_o)
  );

  `MMCS_ASSERT(OneRank, !(dac_lo_i && dac_hi_i), "a write reaches one rank of the D/A")

endmodule

`default_nettype wire
