// SPDX-License-Identifier: Apache-2.0
// The machine at its host port: the adaptor's core and the cards, for hosts without VME. §4.2.1
//
// Masters of the host port: adaptor_axil, adaptor_wb, adaptor_apb. Every input after
// adc_v_i is inert at 0, sysreset_ni at 1.
`default_nettype none

module mmcs_core #(
  parameter int NumCards = 3,
  parameter int ClkHz = 8_000_000,
  // Jumpers of the adaptor
  parameter int SysClkMHz = 8,
  parameter int SclockDrq = 3,
  parameter int PanicIrq = 7,
  // Jumpers of the cards
  parameter logic [63:0] CardSclockDrq = 64'h3333_3333_3333_3333,
  parameter logic [63:0] CardPanicIrq = 64'h7777_7777_7777_7777,
  parameter logic [15:0] SoftLatchDac = 16'hFFFF,
  parameter logic [31:0] AdcSpan10 = 32'h0,
  parameter logic [31:0] DacSpan10 = 32'h0,
  // Times
  parameter int AdcConvNs = 25_000,
  parameter int RelayUs = 1_000,
  parameter int HeartbeatUs = 50_000,
  parameter int CmdNs = 500,
  parameter int IochrdyLimitClks = 10,
  // What the report leaves open
  parameter logic [7:0] PpiFloatB = 8'h00,
  parameter bit RandomPowerUp = 1'b0
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_ni,
  // Host port: req and the rest are held until ack; rdata is valid with ack and stays.
  input  wire logic                   hp_req_i,
  input  wire logic                   hp_write_i,
  input  wire logic [           10:1] hp_a_i,
  input  wire logic [            7:0] hp_wdata_i,
  output logic                        hp_ack_o,
  output logic      [            7:0] hp_rdata_o,
  // Interrupt
  output logic                        irq_req_o,    // SCLOCK or PANIC; the red light
  output logic      [            7:0] vector_o,
  // Safety
  input  wire logic                   sysreset_ni,  // SYSRESET*, asynchronous
  input  wire logic                   estop_closed_i,
  input  wire logic                   cable_ok_i,
  input  wire logic                   pc_power_i,
  output logic                        brake_release_o,
  output logic                        alive_o,      // toggles while the clock runs
  output logic                        panic_o,
  output logic                        sclock_o,
  // Joints
  input  wire logic [ 2*NumCards-1:0] enc_a_i,
  input  wire logic [ 2*NumCards-1:0] enc_b_i,
  input  wire logic [ 2*NumCards-1:0] enc_i_i,
  input  wire logic [ 2*NumCards-1:0] axis_enable_i,
  input  wire logic [ 4*NumCards-1:0] dip_i,        // address switches, a number per card
  input  wire logic [32*NumCards-1:0] adc_v_i,
  output logic      [32*NumCards-1:0] drive_v_o,
  output logic      [11*NumCards-1:0] card_leds_o,
  // PC bus expansion
  output logic      [           15:0] pcx_a_o,
  output logic      [            7:0] pcx_d_o,
  output logic                        pcx_d_oe_o,   // the adaptor drives the data of a write
  output logic                        pcx_ior_no,
  output logic                        pcx_iow_no,
  output logic                        pcx_aen_o,
  output logic                        pcx_clk_en_o,
  output logic                        pcx_reset_drv_o,
  output logic      [            3:1] pcx_drq_o,
  input  wire logic [            7:0] pcx_d_i,
  input  wire logic                   pcx_d_oe_i,
  input  wire logic                   pcx_wait_i,
  input  wire logic [            7:3] pcx_irq_i
);

  // --- adaptor and cards --------------------------------------------------------------------

  logic [7:0] pc_rdata;   // read data of the PC bus
  logic [7:3] pc_irq;
  logic pc_power;

  /* verilator lint_off PINCONNECTEMPTY */  // the synchronised SYSRESET* is for a front
  // The path of the core's registers is the same as in mmcs.
  // verilog_lint: waive generate-label-prefix
  if (1) begin : u_adaptor
    adaptor_core #(
      .ClkHz(ClkHz),
      .SysClkMHz(SysClkMHz),
      .SclockDrq(SclockDrq),
      .PanicIrq(PanicIrq),
      .CmdNs(CmdNs),
      .IochrdyLimitClks(IochrdyLimitClks),
      .RandomPowerUp(RandomPowerUp)
    ) u_core (
      .clk_i, .rst_ni,
      .hp_req_i, .hp_write_i, .hp_a_i, .hp_wdata_i, .hp_ack_o, .hp_rdata_o,
      .irq_req_o, .vector_o,
      .sys_reset_i(~sysreset_ni),
      .sys_reset_o(),
      .estop_closed_i, .cable_ok_i, .pc_power_i, .panic_o, .brake_release_o, .alive_o, .sclock_o,
      .pc_a_o(pcx_a_o),
      .pc_aen_o(pcx_aen_o),
      .pc_d_o(pcx_d_o),
      .pc_d_oe_o(pcx_d_oe_o),
      .pc_ior_no(pcx_ior_no),
      .pc_iow_no(pcx_iow_no),
      .pc_clk_en_o(pcx_clk_en_o),
      .pc_reset_drv_o(pcx_reset_drv_o),
      .pc_drq_o(pcx_drq_o),
      .pc_power_o(pc_power),
      .pc_d_i(pc_rdata),
      .pc_wait_i(pcx_wait_i),
      .pc_irq_i(pc_irq)
    );
  end
  /* verilator lint_on PINCONNECTEMPTY */

  mmcs_cards #(
    .NumCards(NumCards),
    .ClkHz(ClkHz),
    .CardSclockDrq(CardSclockDrq),
    .CardPanicIrq(CardPanicIrq),
    .SoftLatchDac(SoftLatchDac),
    .AdcSpan10(AdcSpan10),
    .DacSpan10(DacSpan10),
    .AdcConvNs(AdcConvNs),
    .RelayUs(RelayUs),
    .HeartbeatUs(HeartbeatUs),
    .PpiFloatB(PpiFloatB),
    .RandomPowerUp(RandomPowerUp)
  ) u_cards (
    .clk_i, .rst_ni,
    .pc_clk_en_i(pcx_clk_en_o),
    .pc_reset_drv_i(pcx_reset_drv_o),
    .pc_a_i(pcx_a_o),
    .pc_aen_i(pcx_aen_o),
    .pc_ior_ni(pcx_ior_no),
    .pc_iow_ni(pcx_iow_no),
    .pc_d_i(pcx_d_o),
    .pc_d_o(pc_rdata),
    .pc_drq_i(pcx_drq_o),
    .pc_irq_o(pc_irq),
    .pc_power_i(pc_power),
    .enc_a_i, .enc_b_i, .enc_i_i, .axis_enable_i, .dip_i, .adc_v_i, .drive_v_o, .card_leds_o,
    .pcx_d_i, .pcx_d_oe_i, .pcx_irq_i
  );

endmodule

`default_nettype wire
