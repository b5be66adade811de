// SPDX-License-Identifier: Apache-2.0
// The Mark I motor interface card: two axes on a PC I/O bus. §5.3
//
// Complete in itself: it needs an 8-bit PC bus, not the adaptor. The bus moves with clk_i, as the
// adaptor's does; in a slot with a clock of its own, commands and what goes with them go through
// `mmcs_sync` first. Times hold at any ClkHz, rounded up to a clock.
`default_nettype none
`include "mmcs_assert.svh"

module mark1 #(
  parameter int ClkHz = 8_000_000,
  parameter int SclockDrq = 3,         // E020: DRQ1-3
  parameter int PanicIrq = 7,          // E011: IRQ3-7
  parameter bit SoftLatchDac = 1'b1,            // E023-E022
  parameter logic [1:0] AdcSpan10 = 2'b00,      // E001-E006
  parameter logic [1:0] DacSpan10 = 2'b00,      // E007-E010
  parameter int AdcConvNs = 25_000,
  parameter int RelayUs = 1_000,
  parameter int HeartbeatUs = 50_000,
  parameter logic [7:0] PpiFloatB = 8'h00,      // what the board sees while port B floats
  parameter logic [31:0] PowerUpSeed = 32'h0    // else chips without reset wake with contents of it
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // PC bus
  input  wire logic        pc_clk_en_i,
  input  wire logic        pc_reset_drv_i,
  input  wire logic [15:0] pc_a_i,
  input  wire logic        pc_aen_i,
  input  wire logic        pc_ior_ni,
  input  wire logic        pc_iow_ni,
  input  wire logic [ 7:0] pc_d_i,
  output logic      [ 7:0] pc_d_o,
  output logic             pc_d_oe_o,
  input  wire logic [ 3:1] pc_drq_i,
  output logic      [ 7:3] pc_irq_o,
  // Switches
  input  wire logic [ 3:0] dip_i,
  input  wire logic [ 1:0] axis_enable_i,
  input  wire logic        power_i,    // synchronous
  // Connectors, joint 1 in the low half
  input  wire logic [ 1:0] enc_a_i,
  input  wire logic [ 1:0] enc_b_i,
  input  wire logic [ 1:0] enc_i_i,
  input  wire logic [31:0] adc_v_i,
  output logic      [31:0] drive_v_o,
  output logic      [10:0] leds_o
);

  // Bits of ports A and B.
  localparam int EncJoint = mmcs_regs_pkg::CARD_PPI_B_ENC_JOINT;
  localparam int SclockEn = mmcs_regs_pkg::CARD_PPI_B_SCLOCK_EN;
  localparam int DacJoint = mmcs_regs_pkg::CARD_PPI_B_DAC_JOINT;
  localparam int DacDouble = mmcs_regs_pkg::CARD_PPI_B_DAC_DOUBLE;
  localparam int IndexEn = mmcs_regs_pkg::CARD_PPI_B_INDEX_EN;
  localparam int SynA = mmcs_regs_pkg::CARD_PPI_A_SYN_A;
  localparam int SynB = mmcs_regs_pkg::CARD_PPI_A_SYN_B;
  localparam int SynI = mmcs_regs_pkg::CARD_PPI_A_SYN_I;
  localparam int Led1 = mmcs_regs_pkg::CARD_PPI_A_LED1;
  localparam int Led2 = mmcs_regs_pkg::CARD_PPI_A_LED2;

  localparam logic [63:0] Hz = 64'(ClkHz);
  localparam int RelayClks = int'((64'(RelayUs) * Hz + 64'd999_999) / 64'd1_000_000);
  localparam int BeatClks = int'((64'(HeartbeatUs) * Hz + 64'd999_999) / 64'd1_000_000);
  localparam int ConvClks = int'((64'(AdcConvNs) * Hz + 64'd999_999_999) / 64'd1_000_000_000);
  // What an unpowered chip wakes with; two numbers, so that no code follows from another.
  localparam logic [63:0] Random1 = {32'h0, PowerUpSeed} * 64'h9E37_79B9_7F4A_7C15;
  localparam logic [63:0] Random2 = {32'h0, PowerUpSeed} * 64'hD1B5_4A32_D192_ED03;
  localparam logic [23:0] DacPowerUp = PowerUpSeed == '0 ? {12'h800, 12'h800} : Random1[47:24];
  localparam logic [23:0] AdcPowerUp = PowerUpSeed == '0 ? 24'h0 : Random2[47:24];
  localparam logic [31:0] CountPowerUp = PowerUpSeed == '0 ? 32'h0
                                                             : Random1[63:32] ^ Random2[63:32];

  // --- power and switches -------------------------------------------------------------------

  logic rst_n;   // a card without power is a card in reset
  assign rst_n = rst_ni & power_i;

  // A switch is asynchronous and has no state but its own, hence no reset.
  logic [1:0] axis_enable;

  mmcs_sync #(.Width(2)) u_axis_enable (
    .clk_i,
    .rst_ni(1'b1),
    .d_i(axis_enable_i),
    .q_o(axis_enable)
  );

  // --- bus ----------------------------------------------------------------------------------

  logic ppi_cs_n, adc_read, sw_latch, ours;
  logic [1:0] enc_cs_n, dac_lo, dac_hi;

  mark1_decode u_decode (
    .pc_a_i(pc_a_i[13:0]),
    .pc_aen_i(pc_aen_i | ~power_i),
    .pc_ior_ni, .pc_iow_ni, .dip_i,
    .ppi_cs_no(ppi_cs_n),
    .enc_cs_no(enc_cs_n),
    .dac_lo_o(dac_lo),
    .dac_hi_o(dac_hi),
    .adc_read_o(adc_read),
    .sw_latch_o(sw_latch),
    .ours_o(ours)
  );

  // --- PPI ----------------------------------------------------------------------------------

  logic [7:0] ppi_d, pa, pb, pa_pins, pb_pins, pa_oe, pb_oe, pc_pins;
  logic ppi_d_oe;
  logic [1:0] heartbeat, index_latched, converting;

  /* verilator lint_off PINCONNECTEMPTY */  // port C is an input of the board
  i8255 u_ppi (
    .clk_i,
    .rst_ni(rst_n),
    .reset_i(pc_reset_drv_i),
    .cs_ni(ppi_cs_n),
    .rd_ni(pc_ior_ni),
    .wr_ni(pc_iow_ni),
    .a_i(pc_a_i[1:0]),
    .d_i(pc_d_i),
    .d_o(ppi_d),
    .d_oe_o(ppi_d_oe),
    .pa_i(pa),
    .pa_o(pa_pins),
    .pa_oe_o(pa_oe),
    .pb_i(pb),
    .pb_o(pb_pins),
    .pb_oe_o(pb_oe),
    .pc_i(pc_pins),
    .pc_o(),
    .pc_oe_o()
  );
  /* verilator lint_on PINCONNECTEMPTY */

  // What the board sees: the latch where it drives, else the floating level.
  assign pa = pa_pins & pa_oe;
  assign pb = (pb_pins & pb_oe) | (PpiFloatB & ~pb_oe);
  assign pc_pins = {3'b111, ~(|converting), index_latched[1], heartbeat[1], index_latched[0],
                    heartbeat[0]};

  // --- latch and relay ----------------------------------------------------------------------

  logic sclock, latch_pulse, dac_update, relay_drive, relay_loop;

  assign sclock = pc_drq_i[SclockDrq];

  mark1_latch #(
    .SoftLatchDac(SoftLatchDac)
  ) u_latch (
    .clk_i,
    .rst_ni(rst_n),
    .sclock_i(sclock),
    .sw_latch_i(sw_latch),
    .sclock_en_i(pb[SclockEn]),
    .dac_double_i(pb[DacDouble]),
    .latch_o(latch_pulse),
    .dac_update_o(dac_update)
  );

  mark1_relay #(
    .SettleClks(RelayClks)
  ) u_relay (
    .clk_i,
    .rst_ni(rst_n),
    .joint_i(pb[DacJoint]),
    .drive_o(relay_drive),
    .loop_o(relay_loop)
  );

  // --- two axes -----------------------------------------------------------------------------

  logic [15:0] enc_d;
  logic [1:0] enc_d_oe, mux_a, mux_b, mux_i, index;
  logic [23:0] adc_code;

  assign mux_a = pb[EncJoint] ? enc_a_i : {2{pa[SynA]}};
  assign mux_b = pb[EncJoint] ? enc_b_i : {2{pa[SynB]}};
  assign mux_i = pb[EncJoint] ? index : {2{pa[SynI]}};

  for (genvar j = 0; j < 2; j++) begin : g_axis
    // Set by the pin, however short; the clock of the counters takes it back once it has seen it.
    logic index_pin, index_d, index_q;
    assign index_pin = enc_i_i[j];
    assign index_d = index_q & ~pc_clk_en_i;
    always_ff @(posedge clk_i or posedge index_pin) begin
      if (index_pin) index_q <= 1'b1;
      else index_q <= index_d;
    end
    assign index[j] = index_q;

    mark1_axis #(
      .AdcSpan10(AdcSpan10[j]),
      .DacSpan10(DacSpan10[j]),
      .ConvClks(ConvClks),
      .HeartbeatClks(BeatClks),
      .DacPowerUp(DacPowerUp[12*j+:12]),
      .AdcPowerUp(AdcPowerUp[12*j+:12]),
      .CountPowerUp(CountPowerUp[16*j+:16])
    ) u_axis (
      .clk_i,
      .rst_ni(rst_n),
      .reset_i(pc_reset_drv_i),
      .clk_en_i(pc_clk_en_i),
      .card_i(ours),
      .enc_cs_ni(enc_cs_n[j]),
      .ior_ni(pc_ior_ni),
      .iow_ni(pc_iow_ni),
      .a0_i(pc_a_i[0]),
      .d_i(pc_d_i),
      .dac_lo_i(dac_lo[j]),
      .dac_hi_i(dac_hi[j]),
      .enc_d_o(enc_d[8*j+:8]),
      .enc_d_oe_o(enc_d_oe[j]),
      .adc_code_o(adc_code[12*j+:12]),
      .latch_i(latch_pulse),
      .dac_update_i(dac_update),
      .enc_mode_i(pa[2:0]),
      .dac_double_i(pb[DacDouble]),
      .index_en_i(pb[IndexEn]),
      .loop_i(relay_loop),
      .drive_i(relay_drive & axis_enable[j]),
      .a_i(mux_a[j]),
      .b_i(mux_b[j]),
      .i_i(mux_i[j]),
      .adc_v_i(adc_v_i[16*j+:16]),
      .drive_v_o(drive_v_o[16*j+:16]),
      .heartbeat_o(heartbeat[j]),
      .index_o(index_latched[j]),
      .converting_o(converting[j])
    );
  end

  // --- read data ----------------------------------------------------------------------------

  logic [7:0] adc_d;

  assign adc_d = pc_a_i[4:0] == mmcs_regs_pkg::CARD_ADC1_LO ? adc_code[7:0]
               : pc_a_i[4:0] == mmcs_regs_pkg::CARD_ADC2_LO ? adc_code[19:12]
               : {adc_code[23:20], adc_code[11:8]};

  // What does not drive shows ones.
  assign pc_d_oe_o = ppi_d_oe | (|enc_d_oe) | adc_read;
  assign pc_d_o = ppi_d & enc_d[7:0] & enc_d[15:8] & (adc_read ? adc_d : 8'hFF);

  // --- PANIC and lights ---------------------------------------------------------------------

  // From a flip-flop: whoever hears the line takes any pulse of it, however short.
  logic panic_d, panic_q;
  assign panic_d = |(axis_enable & ~heartbeat);

  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) panic_q <= 1'b0;
    else panic_q <= panic_d;
  end

  assign pc_irq_o = {4'b0000, panic_q} << (PanicIrq - 3);
  assign leds_o = {1'b1, pa[Led2], pa[Led1], heartbeat[1], heartbeat[0], enc_i_i[1], enc_b_i[1],
                   enc_a_i[1], enc_i_i[0], enc_b_i[0], enc_a_i[0]} & {11{power_i}};

  logic unused_pins;
  assign unused_pins = ^{pc_a_i[15:14], pc_drq_i};

  `MMCS_ASSERT(OneDriver, !(ppi_d_oe && (enc_d_oe[0] || enc_d_oe[1] || adc_read)),
               "one device of a card drives the bus at a time")

endmodule

`default_nettype wire
