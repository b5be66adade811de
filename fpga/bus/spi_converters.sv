// SPDX-License-Identifier: Apache-2.0
// Real converters for the two axes of a card: an MCP3208 reads, a DAC8568 writes, again and again.
//
// One SCLK for both, 32 clocks a slot, one joint a slot; both converters have their own select and
// data lines. Data out change at the falling edge of SCLK for the A/D, at the rising one for the D/A,
// which takes them at the falling one. A value is at most two slots old, and as long on its way
// out; both joints' values are of one instant, and LDAC# puts them out together.
//
// The converters go on through the machine's reset, with zeros, and CLR# brings them there at once,
// even if the clock has stopped. As the D/A wakes, CLR# would mean the lowest voltage, not the
// middle: so it stays high until that has been told. None of this follows PANIC.
`default_nettype none
`include "mmcs_require.svh"

module spi_converters #(
  parameter int ClkHz = 24_000_000,
  parameter int SclkHz = 1_000_000
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,      // of the converters alone: the clock is good
  input  wire logic        run_i,       // the machine is not in reset
  output logic             sclk_o,
  output logic             adc_cs_no,
  output logic             adc_din_o,   // to the converter
  input  wire logic        adc_dout_i,
  output logic             dac_sync_no,
  output logic             dac_din_o,
  output logic             dac_clr_no,
  output logic             dac_ldac_no,
  input  wire logic [31:0] drive_v_i,   // two axes, signed, 32768 = 10 V
  output logic      [31:0] adc_v_o
);

  localparam int Half = ClkHz / SclkHz / 2;
  localparam int Width = $clog2(Half + 1);
  // CLR# means the middle; static reference on; then write to the input register of channel A or B.
  localparam logic [31:0] ClearCode = 32'h0500_0001;
  localparam logic [31:0] Reference = 32'h0800_0001;
  localparam logic [3:0] WriteInput = 4'h0;
  localparam int AdcClks = 24;

  `MMCS_REQUIRE(GoodSclk, Half >= 2, "SclkHz must be a quarter of ClkHz at most")

  logic [Width-1:0] half_d, half_q;
  logic [5:0] bit_d, bit_q;          // 0 to 31; 32 and 33: both selects high
  logic high_d, high_q, joint_d, joint_q, ldac_nd, ldac_nq;
  logic [1:0] told_d;
  /* verilator lint_off PROCASSINIT */
  logic [1:0] told_q = '0;           // words of the start that are on their way or out
  /* verilator lint_on PROCASSINIT */
  logic ready;
  logic known_d, known_q;            // the D/A knows what CLR# means; no reset takes that from it
  logic [15:0] other_d, other_q;     // of joint 2, when joint 1's was taken
  logic [31:0] dac_d, dac_q, adc_v_d, adc_v_q;
  logic [23:0] adc_out_d, adc_out_q;
  logic [11:0] adc_in_d, adc_in_q;
  logic [15:0] code, drive;
  logic tick, active;

  assign tick = (half_q == '0);
  assign active = ~bit_q[5];
  assign ready = told_q[1];
  assign drive = joint_q ? other_q : drive_v_i[15:0];

  assign code = {~adc_in_q[11], adc_in_q[10:0], 4'h0};  // offset binary beyond a level shifter
  assign known_d = known_q | (tick & high_q & (bit_q == 6'd32) & (told_q == 2'd1));

  always_comb begin
    half_d    = tick ? Width'(Half - 1) : half_q - 1'b1;
    high_d    = high_q ^ tick;
    bit_d     = bit_q;
    joint_d   = joint_q;
    ldac_nd   = ldac_nq;
    told_d    = told_q;
    other_d   = other_q;
    dac_d     = dac_q;
    adc_out_d = adc_out_q;
    adc_in_d  = adc_in_q;
    adc_v_d   = adc_v_q;
    if (tick && !high_q) begin
      // SCLK rises: the A/D's bit is taken, the D/A's next bit put out
      if (active && bit_q < 6'(AdcClks)) adc_in_d = {adc_in_q[10:0], adc_dout_i};
      if (active && bit_q != '0) dac_d = {dac_q[30:0], 1'b0};
    end
    if (tick && high_q) begin
      // SCLK falls
      adc_out_d = {adc_out_q[22:0], 1'b0};
      bit_d     = (bit_q == 6'd33) ? '0 : bit_q + 1'b1;
      if (bit_q == 6'd32) begin
        if (ready && joint_q) adc_v_d[31:16] = code;
        else if (ready) adc_v_d[15:0] = code;
        joint_d = ready & ~joint_q;
        ldac_nd = ~(ready & joint_q);
      end
      if (bit_q == 6'd33) begin
        // single-ended channel 0 or 1
        adc_out_d = {5'b0, 2'b11, 2'b00, joint_q, 14'b0};
        if (ready) dac_d = {4'h0, WriteInput, 3'b0, joint_q, ~drive[15], drive[14:0], 4'h0};
        else dac_d = told_q[0] ? Reference : ClearCode;
        if (!ready) told_d = told_q + 2'd1;
        if (!joint_q) other_d = drive_v_i[31:16];
        ldac_nd = 1'b1;
      end
    end
  end

  initial known_q = 1'b0;            // by configuration
  always_ff @(posedge clk_i) known_q <= known_d;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      half_q    <= '0;
      bit_q     <= 6'd32;
      high_q    <= 1'b0;
      joint_q   <= 1'b0;
      ldac_nq   <= 1'b1;
      told_q    <= '0;
      other_q   <= '0;
      dac_q     <= '0;
      adc_out_q <= '0;
      adc_in_q  <= '0;
      adc_v_q   <= '0;
    end else begin
      half_q    <= half_d;
      bit_q     <= bit_d;
      high_q    <= high_d;
      joint_q   <= joint_d;
      ldac_nq   <= ldac_nd;
      told_q    <= told_d;
      other_q   <= other_d;
      dac_q     <= dac_d;
      adc_out_q <= adc_out_d;
      adc_in_q  <= adc_in_d;
      adc_v_q   <= adc_v_d;
    end
  end

  assign adc_v_o = adc_v_q;
  assign sclk_o = high_q & active;
  assign adc_cs_no = ~(active & (bit_q < 6'(AdcClks)));
  assign adc_din_o = adc_out_q[23];
  // SYNC stays until after the last falling edge of SCLK.
  assign dac_sync_no = ~(active | (bit_q == 6'd32 & ~high_q));
  assign dac_din_o = dac_q[31];
  assign dac_clr_no = run_i | ~known_q;
  assign dac_ldac_no = ldac_nq;

endmodule

`default_nettype wire
