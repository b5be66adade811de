// SPDX-License-Identifier: Apache-2.0
// The Mark I card alone, a slave in the slot of a PC: a top by pins. §5.3
//
// The card has a clock of its own. Commands, RESET DRV and SCLOCK go through synchronisers; address
// and data are sampled with every clock, and what was sampled a clock before a command's edge goes
// with it, so that the card sees both stand around its commands as a PC's do. BALE is not needed: a
// PC's A19-A0 stand for the whole cycle. IOCHRDY stays released: data are on the bus at most 7 clocks
// after IOR#, 292 ns; a PC samples them 450 ns after it or later.
`default_nettype none
`include "mmcs_require.svh"

module isa_mark1 #(
  parameter int ClkHz = 24_000_000,
  parameter int SclockDrq = 3,
  parameter int PanicIrq = 7,
  parameter int HeartbeatUs = 50_000
) (
  input  wire logic        clk,
  input  wire logic        rst_n,         // power is good, the PLL has locked
  // Slot
  input  wire logic [15:0] isa_a,
  input  wire logic        isa_aen,
  input  wire logic        isa_ior_n,
  input  wire logic        isa_iow_n,
  input  wire logic        isa_reset_drv,
  inout  wire       [ 7:0] isa_d,         // the FPGA's side of the transceiver
  output logic             isa_d_dir,     // 1: to the bus
  output logic             isa_d_oe_n,
  input  wire logic [ 3:1] isa_drq,       // SCLOCK: an adaptor drives it, §4.2.2
  output logic      [ 7:3] isa_irq_oe_n,  // low pulls IRQ high: PANIC, a wired OR
  // Card
  input  wire logic [ 3:0] dip,           // the card's number
  input  wire logic [ 1:0] enable_n,
  input  wire logic [ 1:0] enc_a,
  input  wire logic [ 1:0] enc_b,
  input  wire logic [ 1:0] enc_i,
  output logic             spi_sclk,
  output logic             adc_cs_n,
  output logic             adc_din,
  input  wire logic        adc_dout,
  output logic             dac_sync_n,
  output logic             dac_din,
  output logic             dac_clr_n,
  output logic             dac_ldac_n,
  output logic      [10:0] led
);

  `MMCS_REQUIRE(ReqClkHz, ClkHz >= 24_000_000 && ClkHz % 8_000_000 == 0,
                "isa_mark1: ClkHz must be a multiple of 8 MHz, 24 MHz or more: data take 7 clocks")

  localparam int EnClks = ClkHz / 8_000_000;
  localparam int EnWidth = $clog2(EnClks);

  logic rst_n_q, reset_drv;
  mmcs_sync u_reset (.clk_i(clk), .rst_ni(rst_n), .d_i(1'b1), .q_o(rst_n_q));
  mmcs_sync #(.ResetValue(1'b1)) u_reset_drv (
    .clk_i(clk), .rst_ni(rst_n_q), .d_i(isa_reset_drv), .q_o(reset_drv)
  );

  // --- bus in -----------------------------------------------------------------------------

  logic ior_n, iow_n, ior_late_q, iow_late_q, card_ior_n, card_iow_n;
  logic [3:1] drq;
  logic [15:0] bus_a, a_d, a_q;
  logic bus_aen, aen_d, aen_q;
  logic [7:0] bus_d, d_d, d_q;
  logic idle;

  mmcs_sync #(.Width(2), .ResetValue(2'b11)) u_commands (
    .clk_i(clk), .rst_ni(rst_n_q), .d_i({isa_ior_n, isa_iow_n}), .q_o({ior_n, iow_n})
  );
  mmcs_sync #(.Width(25), .ResetValue({1'b1, 24'd0})) u_bus (
    .clk_i(clk), .rst_ni(rst_n_q), .d_i({isa_aen, isa_a, isa_d}),
    .q_o({bus_aen, bus_a, bus_d})
  );
  mmcs_sync #(.Width(3)) u_sclock (.clk_i(clk), .rst_ni(rst_n_q), .d_i(isa_drq), .q_o(drq));

  // The card's commands begin a clock late, with the address that stands by then, and end with the
  // command. What they go with is kept: the address while they last, data of the clock before the
  // end, when the command was low on the bus still.
  assign card_ior_n = ior_n | ior_late_q;
  assign card_iow_n = iow_n | iow_late_q;
  assign idle = ior_n & iow_n;
  assign {aen_d, a_d} = (idle | (ior_late_q & iow_late_q)) ? {bus_aen, bus_a} : {aen_q, a_q};
  assign d_d = iow_n ? d_q : bus_d;

  always_ff @(posedge clk or negedge rst_n_q) begin
    if (!rst_n_q) begin
      ior_late_q <= 1'b1;
      iow_late_q <= 1'b1;
      a_q <= '0;
      aen_q <= 1'b1;
      d_q <= '0;
    end else begin
      ior_late_q <= ior_n;
      iow_late_q <= iow_n;
      {aen_q, a_q} <= {aen_d, a_d};
      d_q <= d_d;
    end
  end

  // --- bus out ----------------------------------------------------------------------------

  logic reading_sync;        // IOR# is low, two clocks late; high, without a clock
  logic card_oe, drive;
  logic [7:0] rdata;
  logic [7:3] irq;

  logic reading;
  assign reading = ~isa_ior_n;
  mmcs_sync u_reading (.clk_i(clk), .rst_ni(reading), .d_i(1'b1), .q_o(reading_sync));

  data_turn u_turn (
    .clk_i(clk), .rst_ni(rst_n_q),
    .out_i(card_oe),
    .in_i(1'b1),
    .gate_i(reading_sync),
    .dir_o(isa_d_dir),
    .oe_no(isa_d_oe_n),
    .drive_o(drive)
  );

  assign isa_d = drive ? rdata : 8'hzz;
  assign isa_irq_oe_n = ~irq;

  // --- card -------------------------------------------------------------------------------

  logic [EnWidth-1:0] en_d, en_q;
  logic clk_en;
  logic [31:0] drive_v, adc_v;

  assign clk_en = (en_q == EnWidth'(EnClks - 1));
  assign en_d = clk_en ? '0 : en_q + 1'b1;

  always_ff @(posedge clk or negedge rst_n_q) begin
    if (!rst_n_q) en_q <= '0;
    else en_q <= en_d;
  end

  mark1 #(
    .ClkHz(ClkHz),
    .SclockDrq(SclockDrq),
    .PanicIrq(PanicIrq),
    .HeartbeatUs(HeartbeatUs)
  ) u_card (
    .clk_i(clk), .rst_ni(rst_n_q),
    .pc_clk_en_i(clk_en),
    .pc_reset_drv_i(reset_drv),
    .pc_a_i(a_q), .pc_aen_i(aen_q), .pc_ior_ni(card_ior_n), .pc_iow_ni(card_iow_n),
    .pc_d_i(d_q), .pc_d_o(rdata), .pc_d_oe_o(card_oe),
    .pc_drq_i(drq), .pc_irq_o(irq),
    .dip_i(dip), .axis_enable_i(~enable_n), .power_i(1'b1),
    .enc_a_i(enc_a), .enc_b_i(enc_b), .enc_i_i(enc_i),
    .adc_v_i(adc_v), .drive_v_o(drive_v), .leds_o(led)
  );

  spi_converters #(
    .ClkHz(ClkHz)
  ) u_converters (
    .clk_i(clk),
    .rst_ni(rst_n_q),
    .run_i(~reset_drv),
    .sclk_o(spi_sclk),
    .adc_cs_no(adc_cs_n), .adc_din_o(adc_din), .adc_dout_i(adc_dout),
    .dac_sync_no(dac_sync_n), .dac_din_o(dac_din), .dac_clr_no(dac_clr_n),
    .dac_ldac_no(dac_ldac_n),
    .drive_v_i(drive_v),
    .adc_v_o(adc_v)
  );

endmodule

`default_nettype wire
