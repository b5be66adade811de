// SPDX-License-Identifier: Apache-2.0
// The machine: VME adaptor, Mark I cards, and the lines wired between them. §4, §5
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
  parameter bit RandomPowerUp = 1'b0,
  parameter bit HostPort = 1'b0          // the host port comes out in place of the VME front
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
  output logic                        pcx_ior_no,
  output logic                        pcx_iow_no,
  output logic                        pcx_aen_o,
  output logic                        pcx_clk_en_o,
  output logic                        pcx_reset_drv_o,
  output logic      [            3:1] pcx_drq_o,
  input  wire logic [            7:0] pcx_d_i,
  input  wire logic                   pcx_d_oe_i,
  input  wire logic                   pcx_wait_i,
  input  wire logic [            7:3] pcx_irq_i,
  // Host port; left open and ignored if HostPort = 0
  input  wire logic                   hp_req_i,
  input  wire logic                   hp_write_i,
  input  wire logic [           10:1] hp_a_i,
  input  wire logic [            7:0] hp_wdata_i,
  output logic                        hp_ack_o,
  output logic      [            7:0] hp_rdata_o
);

  // --- parameters that cannot be ------------------------------------------------------------

  `MMCS_REQUIRE(ReqNumCards, NumCards >= 1 && NumCards <= 16, "mmcs: NumCards must be 1 to 16")
  `MMCS_REQUIRE(ReqClkHz, ClkHz >= 8_000_000 && ClkHz % 8_000_000 == 0 && ClkHz <= 80_000_000,
                "mmcs: ClkHz must be a multiple of 8 MHz, at most 80 MHz")
  `MMCS_REQUIRE(ReqSysClk, SysClkMHz == 8 || SysClkMHz == 4 || SysClkMHz == 2 || SysClkMHz == 1,
                "mmcs: SysClkMHz must be 8, 4, 2 or 1")
  `MMCS_REQUIRE(ReqIrq, IrqLevel >= 1 && IrqLevel <= 7, "mmcs: IrqLevel (J5) must be 1 to 7")
  `MMCS_REQUIRE(ReqAck, AckLevel >= 1 && AckLevel <= 7, "mmcs: AckLevel (J7) must be 1 to 7")
  `MMCS_REQUIRE(ReqDrq, SclockDrq >= 1 && SclockDrq <= 3, "mmcs: SclockDrq must be 1 to 3")
  `MMCS_REQUIRE(ReqPanic, PanicIrq >= 3 && PanicIrq <= 7, "mmcs: PanicIrq must be 3 to 7")
  `MMCS_REQUIRE(ReqCmd, CmdNs >= 125 && CmdNs <= 10_000, "mmcs: CmdNs must be 125 to 10000")
  `MMCS_REQUIRE(ReqIochrdy, IochrdyLimitClks >= 1 && IochrdyLimitClks <= 100,
                "mmcs: IochrdyLimitClks must be 1 to 100")
  `MMCS_REQUIRE(ReqConv, AdcConvNs >= 1_000 && AdcConvNs <= 50_000,
                "mmcs: AdcConvNs must be 1000 to 50000")
  `MMCS_REQUIRE(ReqRelay, RelayUs >= 1 && RelayUs <= 100_000, "mmcs: RelayUs must be 1 to 100000")
  `MMCS_REQUIRE(ReqBeat, HeartbeatUs >= 1 && HeartbeatUs <= 10_000_000,
                "mmcs: HeartbeatUs must be 1 to 10000000")
  for (genvar n = 0; n < NumCards; n++) begin : g_check
    `MMCS_REQUIRE(ReqCardDrq, CardSclockDrq[4*n+:4] >= 1 && CardSclockDrq[4*n+:4] <= 3,
                  "mmcs: CardSclockDrq must be 1 to 3 for each card")
    `MMCS_REQUIRE(ReqCardPanic, CardPanicIrq[4*n+:4] >= 3 && CardPanicIrq[4*n+:4] <= 7,
                  "mmcs: CardPanicIrq must be 3 to 7 for each card")
  end

  // --- adaptor ------------------------------------------------------------------------------

  logic [15:0] pc_a;
  logic [ 7:0] pc_wdata, pc_rdata;
  logic pc_aen, pc_ior_n, pc_iow_n, pc_clk_en, pc_reset_drv, pc_power;
  logic [3:1] pc_drq;
  logic [7:3] pc_irq;
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
    .RandomPowerUp(RandomPowerUp),
    .HostPort(HostPort)
  ) u_adaptor (
    .clk_i, .rst_ni,
    .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni,
    .vme_d_i(vme_d_i[7:0]),
    .vme_d_o(vme_d),
    .vme_d_oe_o, .vme_dtack_no, .vme_iack_ni, .vme_iackin_ni, .vme_iackout_no, .vme_irq_no,
    .vme_sysreset_ni,
    .hp_req_i, .hp_write_i, .hp_a_i, .hp_wdata_i, .hp_ack_o, .hp_rdata_o,
    .estop_closed_i, .cable_ok_i, .pc_power_i, .panic_o, .brake_release_o, .alive_o, .sclock_o,
    .led_irq_o,
    .pc_a_o(pc_a),
    .pc_aen_o(pc_aen),
    .pc_d_o(pc_wdata),
    .pc_ior_no(pc_ior_n),
    .pc_iow_no(pc_iow_n),
    .pc_clk_en_o(pc_clk_en),
    .pc_reset_drv_o(pc_reset_drv),
    .pc_drq_o(pc_drq),
    .pc_power_o(pc_power),
    .pc_d_i(pc_rdata),
    .pc_wait_i(pcx_wait_i),
    .pc_irq_i(pc_irq)
  );

  // D15-D08 have no driver: the bus reads 1 there.
  assign vme_d_o = {8'hFF, vme_d};
  logic unused_upper;
  assign unused_upper = ^vme_d_i[15:8];

  // --- cards --------------------------------------------------------------------------------

  logic [8*NumCards-1:0] card_d;
  logic [5*NumCards-1:0] card_irq;
  logic [  NumCards-1:0] card_d_oe;

  for (genvar n = 0; n < NumCards; n++) begin : g_card
    mark1 #(
      .ClkHz(ClkHz),
      .SclockDrq(int'(CardSclockDrq[4*n+:4])),
      .PanicIrq(int'(CardPanicIrq[4*n+:4])),
      .SoftLatchDac(SoftLatchDac[n]),
      .AdcSpan10(AdcSpan10[2*n+:2]),
      .DacSpan10(DacSpan10[2*n+:2]),
      .AdcConvNs(AdcConvNs),
      .RelayUs(RelayUs),
      .HeartbeatUs(HeartbeatUs),
      .PpiFloatB(PpiFloatB),
      .PowerUpSeed(RandomPowerUp ? 32'h1989_0217 + 32'(n) : 32'h0)
    ) u_card (
      .clk_i, .rst_ni,
      .pc_clk_en_i(pc_clk_en),
      .pc_reset_drv_i(pc_reset_drv),
      .pc_a_i(pc_a),
      .pc_aen_i(pc_aen),
      .pc_ior_ni(pc_ior_n),
      .pc_iow_ni(pc_iow_n),
      .pc_d_i(pc_wdata),
      .pc_d_o(card_d[8*n+:8]),
      .pc_d_oe_o(card_d_oe[n]),
      .pc_drq_i(pc_drq),
      .pc_irq_o(card_irq[5*n+:5]),
      .dip_i(dip_i[4*n+:4]),
      .axis_enable_i(axis_enable_i[2*n+:2]),
      .power_i(pc_power),
      .enc_a_i(enc_a_i[2*n+:2]),
      .enc_b_i(enc_b_i[2*n+:2]),
      .enc_i_i(enc_i_i[2*n+:2]),
      .adc_v_i(adc_v_i[32*n+:32]),
      .drive_v_o(drive_v_o[32*n+:32]),
      .leds_o(card_leds_o[11*n+:11])
    );
  end

  // --- wired lines --------------------------------------------------------------------------

  // Undriven data lines read 1; two drivers at once give their AND. PANIC and the other interrupt
  // lines are a wired OR.
  always_comb begin
    pc_rdata = pcx_d_oe_i ? pcx_d_i : 8'hFF;
    for (int n = 0; n < NumCards; n++) begin
      if (card_d_oe[n]) pc_rdata = pc_rdata & card_d[8*n+:8];
    end
  end

  always_comb begin
    pc_irq = pcx_irq_i;
    for (int n = 0; n < NumCards; n++) pc_irq = pc_irq | card_irq[5*n+:5];
  end

  assign pcx_a_o = pc_a;
  assign pcx_d_o = pc_wdata;
  assign pcx_ior_no = pc_ior_n;
  assign pcx_iow_no = pc_iow_n;
  assign pcx_aen_o = pc_aen;
  assign pcx_clk_en_o = pc_clk_en;
  assign pcx_reset_drv_o = pc_reset_drv;
  assign pcx_drq_o = pc_drq;

endmodule

`default_nettype wire
