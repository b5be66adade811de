// SPDX-License-Identifier: Apache-2.0
// The Mark I motor interface card: two axes on a PC I/O bus. §5.3
//
// Complete in itself: it needs an 8-bit PC bus, not the adaptor.
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
  parameter bit RandomPowerUp = 1'b0,
  parameter bit Sleeps = 1'b0,                  // asleep_i is connected
  parameter bit Gate = 1'b0,                    // see rtl/mmcs.sv
  parameter bit Skip = 1'b0
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
  input  wire logic        power_i,
  input  wire logic        asleep_i,   // see below; looked at if Sleeps
  // Connectors, joint 1 in the low half
  input  wire logic [ 1:0] enc_a_i,
  input  wire logic [ 1:0] enc_b_i,
  input  wire logic [ 1:0] enc_i_i,
  input  wire logic [31:0] adc_v_i,
  output logic      [31:0] drive_v_o,
  output logic      [10:0] leds_o,
  // Faults and skipping
  input  wire logic        absent_i,
  input  wire logic        sclock_open_i,
  input  wire logic        panic_open_i,
  input  wire logic [23:0] dac_stuck1_i,
  input  wire logic [23:0] dac_stuck0_i,
  input  wire logic [ 1:0] adc_stuck_i,
  input  wire logic        clk_free_i,
  output logic             awake_o,    // not asleep, or a timer ends on this clock
  input  wire logic [15:0] extra_i,
  output logic      [15:0] horizon_o
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

  localparam int ClkMHz = ClkHz / 1_000_000;
  // Two different arbitrary codes, one per axis.
  localparam logic [23:0] DacPowerUp = RandomPowerUp ? {12'h3D6, 12'hB29} : {12'h800, 12'h800};

  logic reset;
  assign reset = pc_reset_drv_i | ~power_i;

  // --- sleep --------------------------------------------------------------------------------

  // asleep_i: no input but adc_v_i and pc_clk_en_i has changed for so many ticks of pc_clk_en_i that
  // every synchroniser has settled, and no command is low. Only timers may run then; the clock after
  // one ends is spent awake, since outputs follow it.
  logic asleep, shakes, ticking;
  logic [5:0] timers, timers_q;
  logic [1:0] heartbeat, index_latched, converting;
  logic relay_drive, relay_loop, relay_due;
  logic [1:0] axis_due;

  assign timers = {relay_drive, relay_loop, converting, heartbeat};
  assign asleep = Sleeps && asleep_i && timers == timers_q && !ticking && !shakes;
  assign awake_o = !asleep | relay_due | (|axis_due);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) timers_q <= '0;
    else if (timers != timers_q) timers_q <= timers;
  end

  // --- bus ----------------------------------------------------------------------------------

  logic ppi_cs_n, adc_read, sw_latch, bus_busy;
  logic [1:0] enc_cs_n, dac_lo, dac_hi;

  decode u_decode (
    .pc_a_i(pc_a_i[13:0]),
    .pc_aen_i(pc_aen_i | absent_i | ~power_i),
    .pc_ior_ni, .pc_iow_ni, .dip_i,
    .ppi_cs_no(ppi_cs_n),
    .enc_cs_no(enc_cs_n),
    .dac_lo_o(dac_lo),
    .dac_hi_o(dac_hi),
    .adc_read_o(adc_read),
    .sw_latch_o(sw_latch),
    .busy_o(bus_busy)
  );

  // --- PPI ----------------------------------------------------------------------------------

  logic [7:0] ppi_d, pa, pb, pa_pins, pb_pins, pa_oe, pb_oe, pc_pins;
  logic ppi_d_oe;
  logic heartbeat1, heartbeat2, index1, index2;

  /* verilator lint_off PINCONNECTEMPTY */  // port C is an input of the board
  i8255 u_ppi (
    .clk_i, .rst_ni,
    .reset_i(reset),
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
    .pc_oe_o(),
    .shakes_o(shakes)
  );
  /* verilator lint_on PINCONNECTEMPTY */

  // What the board sees: the latch where it drives, else the floating level.
  assign pa = pa_pins & pa_oe;
  assign pb = (pb_pins & pb_oe) | (PpiFloatB & ~pb_oe);
  assign ticking = pa_pins[2:0] == 3'd6;  // the encoder counters count time
  assign {heartbeat2, heartbeat1, index2, index1} = {heartbeat, index_latched};

  assign pc_pins = {3'b111, ~(|converting), index2, heartbeat2, index1, heartbeat1};

  // --- latch and relay ----------------------------------------------------------------------

  logic latch_pulse, dac_update, latch_settled;
  logic [15:0] relay_horizon;

  latch #(
    .SoftLatchDac(SoftLatchDac)
  ) u_latch (
    .clk_i, .rst_ni,
    .asleep_i(asleep),
    .sclock_i(pc_drq_i[SclockDrq] & ~sclock_open_i),
    .sw_latch_i(sw_latch),
    .sclock_en_i(pb[SclockEn]),
    .dac_double_i(pb[DacDouble]),
    .latch_o(latch_pulse),
    .dac_update_o(dac_update),
    .settled_o(latch_settled)
  );

  relay #(
    .SettleClks(RelayUs * ClkMHz),
    .Gate(Gate),
    .Skip(Skip)
  ) u_relay (
    .clk_i, .rst_ni,
    .joint_i(pb[DacJoint] & power_i),
    .drive_o(relay_drive),
    .loop_o(relay_loop),
    .clk_free_i,
    .due_o(relay_due),
    .extra_i,
    .horizon_o(relay_horizon)
  );

  // --- two axes -----------------------------------------------------------------------------

  logic [15:0] enc_d;
  logic [1:0] enc_d_oe, mux_a, mux_b, mux_i;
  logic enc_joint, syn_a, syn_b, syn_i;
  logic [23:0] adc_code;
  logic [31:0] axis_horizon;

  assign enc_joint = pb[EncJoint];
  assign {syn_i, syn_b, syn_a} = {pa[SynI], pa[SynB], pa[SynA]};

  always_comb begin
    if (asleep) begin
      {mux_a, mux_b, mux_i} = 6'b0;
    end else if (enc_joint) begin
      mux_a = enc_a_i;
      mux_b = enc_b_i;
      mux_i = enc_i_i;
    end else begin
      mux_a = {2{syn_a}};
      mux_b = {2{syn_b}};
      mux_i = {2{syn_i}};
    end
  end

  for (genvar j = 0; j < 2; j++) begin : g_axis
    axis #(
      .AdcSpan10(AdcSpan10[j]),
      .DacSpan10(DacSpan10[j]),
      .ConvClks((AdcConvNs * ClkMHz + 999) / 1000),
      .HeartbeatClks(HeartbeatUs * ClkMHz),
      .DacPowerUp(DacPowerUp[12*j+:12]),
      .Gate(Gate),
      .Skip(Skip)
    ) u_axis (
      .clk_i, .rst_ni,
      .reset_i(reset),
      .power_i,
      .asleep_i(asleep),
      .clk_en_i(pc_clk_en_i),
      .enc_cs_ni(enc_cs_n[j]),
      .ior_ni(pc_ior_ni),
      .iow_ni(pc_iow_ni),
      .a0_i(pc_a_i[0]),
      .d_i(pc_d_i),
      .dac_lo_i(dac_lo[j]),
      .dac_hi_i(dac_hi[j]),
      .adc_read_i(adc_read),
      .enc_d_o(enc_d[8*j+:8]),
      .enc_d_oe_o(enc_d_oe[j]),
      .adc_code_o(adc_code[12*j+:12]),
      .latch_i(latch_pulse),
      .dac_update_i(dac_update),
      .enc_mode_i(pa[2:0]),
      .dac_double_i(pb[DacDouble]),
      .index_en_i(pb[IndexEn]),
      .loop_i(relay_loop),
      .drive_i(relay_drive & axis_enable_i[j] & power_i & ~absent_i),
      .a_i(mux_a[j]),
      .b_i(mux_b[j]),
      .i_i(mux_i[j]),
      .adc_v_i(adc_v_i[16*j+:16]),
      .drive_v_o(drive_v_o[16*j+:16]),
      .heartbeat_o(heartbeat[j]),
      .index_o(index_latched[j]),
      .converting_o(converting[j]),
      .dac_stuck1_i(dac_stuck1_i[12*j+:12]),
      .dac_stuck0_i(dac_stuck0_i[12*j+:12]),
      .adc_stuck_i(adc_stuck_i[j]),
      .clk_free_i,
      .due_o(axis_due[j]),
      .extra_i,
      .horizon_o(axis_horizon[16*j+:16])
    );
  end

  // --- read data ----------------------------------------------------------------------------

  localparam logic [4:0] AdcLo1 = mmcs_regs_pkg::CARD_ADC1_LO;
  localparam logic [4:0] AdcLo2 = mmcs_regs_pkg::CARD_ADC2_LO;

  logic [1:0] which;
  assign which = pc_a_i[1:0];

  assign pc_d_oe_o = ppi_d_oe | (|enc_d_oe) | adc_read;
  assign pc_d_o = !pc_d_oe_o ? 8'hFF
                : ppi_d_oe ? ppi_d
                : !adc_read ? enc_d[7:0] & enc_d[15:8]
                : which == AdcLo1[1:0] ? adc_code[7:0]
                : which == AdcLo2[1:0] ? adc_code[19:12] : {adc_code[23:20], adc_code[11:8]};

  // --- PANIC and lights ---------------------------------------------------------------------

  // While asleep both stand in registers: what they are made of need not be looked at.
  logic panic, panic_q;
  logic [10:0] leds_q;

  assign pc_irq_o = {4'b0000, panic} << (PanicIrq - 3);

  assign panic = asleep ? panic_q
               : |(axis_enable_i & ~heartbeat) & power_i & ~absent_i & ~panic_open_i;
  assign leds_o = asleep ? leds_q
                : {1'b1, pa[Led2], pa[Led1], heartbeat[1], heartbeat[0], enc_i_i[1], enc_b_i[1],
                   enc_a_i[1], enc_i_i[0], enc_b_i[0], enc_a_i[0]} & {11{power_i & ~absent_i}};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      panic_q <= 1'b0;
      leds_q  <= '0;
    end else if (!asleep) begin
      panic_q <= panic;
      leds_q  <= leds_o;
    end
  end

  // --- skipping -----------------------------------------------------------------------------

  if (Skip) begin : g_skip
    // A command acts on the first clock at which it is seen and on the first at which it is gone.
    logic [15:0] horizon1, horizon2;
    logic [1:0] bus_q;
    logic bus_moves;
    assign bus_moves = {pc_ior_ni, pc_iow_ni} != bus_q;
    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) bus_q <= 2'b11;
      else if (bus_moves) bus_q <= {pc_ior_ni, pc_iow_ni};
    end
    assign {horizon2, horizon1} = axis_horizon;
    always_comb begin
      horizon_o = relay_horizon;
      if (horizon1 < horizon_o) horizon_o = horizon1;
      if (horizon2 < horizon_o) horizon_o = horizon2;
      if (bus_moves || shakes || !latch_settled || reset) horizon_o = 16'd1;
    end
  end else begin : g_step
    assign horizon_o = 16'd1;
    logic unused;
    assign unused = ^{axis_horizon, relay_horizon, latch_settled};
  end

  logic unused_pins;
  assign unused_pins = ^{pc_a_i[15:14], bus_busy};

  `MMCS_ASSERT(OneDriver, !(ppi_d_oe && (enc_d_oe[0] || enc_d_oe[1] || adc_read)),
               "one device of a card drives the bus at a time")

endmodule

`default_nettype wire
