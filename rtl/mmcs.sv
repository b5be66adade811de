// SPDX-License-Identifier: Apache-2.0
// The machine: VME adaptor and Mark I cards. §4, §5
//
// Axis n = 2 * card + joint - 1; vectors are packed with axis or card 0 in the low bits. Every
// input after adc_v_i is inert at 0. Per-card jumpers take one hexadecimal digit per card.
`default_nettype none
`include "mmcs_require.svh"

module mmcs #(
  parameter int NumCards = 3,
  parameter int ClkHz = 8_000_000,
  // Jumpers of the adaptor
  parameter logic [4:0] BaseA15A11 = 5'b01100,
  parameter int IrqLevel = 5,            // J5
  parameter int AckLevel = 5,            // J7
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
  // VME
  input  wire logic [           15:1] vme_a_i,
  input  wire logic [            5:0] vme_am_i,
  input  wire logic                   vme_as_ni,
  input  wire logic [            1:0] vme_ds_ni,
  input  wire logic                   vme_write_ni,
  input  wire logic                   vme_lword_ni,
  input  wire logic [           15:0] vme_d_i,
  output logic      [           15:0] vme_d_o,
  output logic                        vme_d_oe_o,
  output logic                        vme_dtack_no,
  input  wire logic                   vme_iack_ni,
  input  wire logic                   vme_iackin_ni,
  output logic                        vme_iackout_no,
  output logic      [            7:1] vme_irq_no,
  input  wire logic                   vme_sysreset_ni,
  // Safety
  input  wire logic                   estop_closed_i,
  input  wire logic                   cable_ok_i,
  input  wire logic                   pc_power_i,
  output logic                        brake_release_o,
  output logic                        alive_o,      // toggles while the clock runs
  output logic                        panic_o,
  output logic                        sclock_o,
  output logic                        led_irq_o,
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

  // --- parameters that cannot be ------------------------------------------------------------

  `MMCS_REQUIRE(ReqIrq, IrqLevel >= 1 && IrqLevel <= 7, "mmcs: IrqLevel (J5) must be 1 to 7")
  `MMCS_REQUIRE(ReqAck, AckLevel >= 1 && AckLevel <= 7, "mmcs: AckLevel (J7) must be 1 to 7")

  // --- adaptor and cards --------------------------------------------------------------------

  logic [7:0] pc_rdata;   // read data of the PC bus
  logic [7:3] pc_irq;
  logic pc_power;
  logic [7:0] vme_d;

  adaptor_vme #(
    .ClkHz(ClkHz),
    .BaseA15A11(BaseA15A11),
    .IrqLevel(IrqLevel),
    .AckLevel(AckLevel),
    .SysClkMHz(SysClkMHz),
    .SclockDrq(SclockDrq),
    .PanicIrq(PanicIrq),
    .CmdNs(CmdNs),
    .IochrdyLimitClks(IochrdyLimitClks),
    .RandomPowerUp(RandomPowerUp)
  ) u_adaptor (
    .clk_i, .rst_ni,
    .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni,
    .vme_d_i(vme_d_i[7:0]),
    .vme_d_o(vme_d),
    .vme_d_oe_o, .vme_dtack_no, .vme_iack_ni, .vme_iackin_ni, .vme_iackout_no, .vme_irq_no,
    .vme_sysreset_ni,
    .estop_closed_i, .cable_ok_i, .pc_power_i, .panic_o, .brake_release_o, .alive_o, .sclock_o,
    .led_irq_o,
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

  // D15-D08 have no driver: the bus reads 1 there.
  assign vme_d_o = {8'hFF, vme_d};
  logic unused_upper;
  assign unused_upper = ^vme_d_i[15:8];

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
