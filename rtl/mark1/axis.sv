// SPDX-License-Identifier: Apache-2.0
// One axis of a card: encoder counter, A/D, D/A, heartbeat, index latch. §5.3
`default_nettype none
`include "mmcs_assert.svh"

module axis #(
  parameter bit AdcSpan10 = 1'b0,            // E001-E003: 10 V instead of 20 V
  parameter bit DacSpan10 = 1'b0,            // E007-E008
  parameter int ConvClks = 200,
  parameter int HeartbeatClks = 400_000,
  parameter logic [11:0] DacPowerUp = 12'h800,
  parameter bit Gate = 1'b0,                 // see rtl/mmcs.sv
  parameter bit Skip = 1'b0
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic        reset_i,          // RESET DRV, or no power
  input  wire logic        power_i,
  input  wire logic        asleep_i,         // no input but clk_en_i changes, and all is settled
  // Bus: strobes are high while their command is low
  input  wire logic        clk_en_i,
  input  wire logic        enc_cs_ni,
  input  wire logic        ior_ni,
  input  wire logic        iow_ni,
  input  wire logic        a0_i,
  input  wire logic [ 7:0] d_i,
  input  wire logic        dac_lo_i,
  input  wire logic        dac_hi_i,
  input  wire logic        adc_read_i,
  output logic      [ 7:0] enc_d_o,
  output logic             enc_d_oe_o,
  output logic      [11:0] adc_code_o,       // 0 while it is not read
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
  output logic             converting_o,
  // Faults and skipping
  input  wire logic [11:0] dac_stuck1_i,
  input  wire logic [11:0] dac_stuck0_i,
  input  wire logic        adc_stuck_i,
  input  wire logic        clk_free_i,
  output logic             due_o,            // a timer ends on this clock
  input  wire logic [15:0] extra_i,
  output logic      [15:0] horizon_o
);

  // --- index latch --------------------------------------------------------------------------

  // A and B pass two flip-flops in the counter and are counted at the third clock. The index passes
  // three, so that an edge of A or B which comes with it is in the count that it latches.
  logic [2:0] index_sync_q;
  logic armed_index, armed_index_q, index_latch_q, index_moving, index_synced;

  assign index_synced = index_sync_q[2];

  always_comb begin
    armed_index = 1'b0;
    index_moving = 1'b0;
    if (!asleep_i) begin
      armed_index = index_synced & index_en_i;
      index_moving = index_sync_q != {3{i_i}} || armed_index != armed_index_q ||
                     (index_latch_q && !index_en_i);
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      index_sync_q  <= '0;
      armed_index_q <= 1'b0;
      index_latch_q <= 1'b0;
    end else if (index_moving) begin
      if (clk_en_i) index_sync_q <= {index_sync_q[1:0], i_i};
      armed_index_q <= armed_index;
      if (!index_en_i) index_latch_q <= 1'b0;
      else if (armed_index) index_latch_q <= 1'b1;
    end
  end

  assign index_o = index_latch_q;

  // --- encoder counter ----------------------------------------------------------------------

  logic [15:0] enc_horizon;

  logic enc_latch;
  always_comb begin
    enc_latch = 1'b0;
    if (!asleep_i) enc_latch = latch_i | (armed_index & ~armed_index_q);
  end

  /* verilator lint_off PINCONNECTEMPTY */  // debugging outputs
  thct2000 #(
    .Skip(Skip),
    .Sleeps(1'b1)
  ) u_encoder (
    .clk_i, .rst_ni, .reset_i, .clk_en_i,
    .m_i(enc_mode_i),
    .a_i, .b_i, .asleep_i,
    .latch_i(enc_latch),
    .cs_ni(enc_cs_ni),
    .rd_ni(ior_ni),
    .wr_ni(iow_ni),
    .rs_i(a0_i),
    .d_i,
    .d_o(enc_d_o),
    .d_oe_o(enc_d_oe_o),
    .count_o(),
    .illegal_o(),
    .extra_i,
    .horizon_o(enc_horizon)
  );
  /* verilator lint_on PINCONNECTEMPTY */

  // --- D/A: two ranks; the low byte waits in the first for the high nibble -------------------

  logic [11:0] dac_chip, dac_code;
  logic [15:0] dac_v, drive_q;
  logic dac_cs;

  always_comb begin
    dac_cs = 1'b0;
    if (!asleep_i) dac_cs = dac_lo_i | dac_hi_i | dac_update_i;
  end

  ad667 #(
    .PowerUp(DacPowerUp)
  ) u_dac (
    .clk_i, .rst_ni,
    .cs_ni(~dac_cs),
    .a_ni({~(dac_update_i | (dac_hi_i & ~dac_double_i)), ~dac_hi_i, {2{~dac_lo_i}}}),
    .d_i({d_i[3:0], d_i}),
    .code_o(dac_chip)
  );

  always_comb begin
    dac_code = 12'h000;
    if (!asleep_i) dac_code = (dac_chip | dac_stuck1_i) & ~dac_stuck0_i;
  end
  // Offset binary to signed, 32768 = 10 V; the narrow span is half as much per step.
  if (DacSpan10) begin : g_dac10
    assign dac_v = {{2{~dac_code[11]}}, dac_code[10:0], 3'b000};
  end else begin : g_dac20
    assign dac_v = {~dac_code[11], dac_code[10:0], 4'b0000};
  end

  // While asleep the output stands in a register: what it is made of need not be looked at.
  always_comb begin
    drive_v_o = drive_q;
    if (!asleep_i) drive_v_o = drive_i ? dac_v : 16'h0000;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) drive_q <= 16'h0000;
    else if (!asleep_i) drive_q <= drive_v_o;
  end

  // --- A/D: the code of the last conversion stays readable while the next one runs -----------

  logic adc_sts, adc_oe;
  logic [15:0] adc_v;
  logic [11:0] adc_db, adc_q;
  logic [15:0] adc_horizon;

  always_comb begin
    adc_v = 16'h0000;
    if (latch_i) adc_v = loop_i ? dac_v : adc_v_i;
  end

  logic adc_due, hb_due;
  assign due_o = adc_due | hb_due;

  ad574 #(
    .Skip(Skip),
    .Gate(Gate),
    .ConvClks(ConvClks)
  ) u_adc (
    .clk_i, .rst_ni,
    .ce_i(1'b1),
    .cs_ni(1'b0),
    .rc_ni(~latch_i),
    .a0_i(1'b0),
    .mode12_i(1'b1),
    .span10_i(AdcSpan10),
    .vin_i(adc_v),
    .hold_i(adc_stuck_i),
    .sts_o(adc_sts),
    .db_o(adc_db),
    .db_oe_o(adc_oe),
    .clk_free_i,
    .due_o(adc_due),
    .extra_i,
    .horizon_o(adc_horizon)
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) adc_q <= 12'h000;
    else if (!asleep_i && adc_oe) adc_q <= adc_db;
  end

  always_comb begin
    adc_code_o = 12'h000;
    if (adc_read_i) adc_code_o = adc_oe ? adc_db : adc_q;
  end

  assign converting_o = adc_sts;

  // --- heartbeat ----------------------------------------------------------------------------

  logic [15:0] hb_horizon;

  oneshot #(
    .Skip(Skip),
    .Gate(Gate),
    .PulseClks(HeartbeatClks)
  ) u_heartbeat (
    .clk_i, .rst_ni,
    .trig_i(dac_lo_i),
    .clr_ni(power_i),
    .q_o(heartbeat_o),
    .clk_free_i,
    .due_o(hb_due),
    .extra_i,
    .horizon_o(hb_horizon)
  );

  // --- skipping -----------------------------------------------------------------------------

  if (Skip) begin : g_skip
    always_comb begin
      horizon_o = enc_horizon;
      if (adc_horizon < horizon_o) horizon_o = adc_horizon;
      if (hb_horizon < horizon_o) horizon_o = hb_horizon;
      if (index_moving || (adc_oe && adc_q != adc_db)) horizon_o = 16'd1;
    end
  end else begin : g_step
    assign horizon_o = 16'd1;
    logic unused;
    assign unused = ^{enc_horizon, adc_horizon, hb_horizon};
  end

  `MMCS_ASSERT(OneRank, !(dac_lo_i && dac_hi_i), "a write reaches one rank of the D/A")

endmodule

`default_nettype wire
