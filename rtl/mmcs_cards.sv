// SPDX-License-Identifier: Apache-2.0
// The Mark I cards, and the lines wired between them and an adaptor. §4.2.1, §5
//
// Vectors are packed with card or axis 0 in the low bits. Per-card jumpers take one hexadecimal
// digit per card.
`default_nettype none
`include "mmcs_require.svh"

module mmcs_cards #(
  parameter int NumCards = 3,
  parameter int ClkHz = 8_000_000,
  // Jumpers
  parameter logic [63:0] CardSclockDrq = 64'h3333_3333_3333_3333,
  parameter logic [63:0] CardPanicIrq = 64'h7777_7777_7777_7777,
  parameter logic [15:0] SoftLatchDac = 16'hFFFF,
  parameter logic [31:0] AdcSpan10 = 32'h0,
  parameter logic [31:0] DacSpan10 = 32'h0,
  // Times
  parameter int AdcConvNs = 25_000,
  parameter int RelayUs = 1_000,
  parameter int HeartbeatUs = 50_000,
  // What the report leaves open
  parameter logic [7:0] PpiFloatB = 8'h00,
  parameter bit RandomPowerUp = 1'b0
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_ni,
  // PC bus, as the adaptor drives and reads it
  input  wire logic                   pc_clk_en_i,
  input  wire logic                   pc_reset_drv_i,
  input  wire logic [           15:0] pc_a_i,
  input  wire logic                   pc_aen_i,
  input  wire logic                   pc_ior_ni,
  input  wire logic                   pc_iow_ni,
  input  wire logic [            7:0] pc_d_i,
  output logic      [            7:0] pc_d_o,
  input  wire logic [            3:1] pc_drq_i,
  output logic      [            7:3] pc_irq_o,
  input  wire logic                   pc_power_i,
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
  input  wire logic [            7:0] pcx_d_i,
  input  wire logic                   pcx_d_oe_i,
  input  wire logic [            7:3] pcx_irq_i
);

  // --- parameters that cannot be ------------------------------------------------------------

  `MMCS_REQUIRE(ReqNumCards, NumCards >= 1 && NumCards <= 16, "mmcs: NumCards must be 1 to 16")
  `MMCS_REQUIRE(ReqClkHz, ClkHz >= 8_000_000 && ClkHz % 8_000_000 == 0 && ClkHz <= 80_000_000,
                "mmcs: ClkHz must be a multiple of 8 MHz, at most 80 MHz")
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
      .pc_clk_en_i, .pc_reset_drv_i, .pc_a_i, .pc_aen_i, .pc_ior_ni, .pc_iow_ni, .pc_d_i,
      .pc_d_o(card_d[8*n+:8]),
      .pc_d_oe_o(card_d_oe[n]),
      .pc_drq_i,
      .pc_irq_o(card_irq[5*n+:5]),
      .dip_i(dip_i[4*n+:4]),
      .axis_enable_i(axis_enable_i[2*n+:2]),
      .power_i(pc_power_i),
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
    pc_d_o = pcx_d_oe_i ? pcx_d_i : 8'hFF;
    for (int n = 0; n < NumCards; n++) begin
      if (card_d_oe[n]) pc_d_o = pc_d_o & card_d[8*n+:8];
    end
  end

  always_comb begin
    pc_irq_o = pcx_irq_i;
    for (int n = 0; n < NumCards; n++) pc_irq_o = pc_irq_o | card_irq[5*n+:5];
  end

endmodule

`default_nettype wire
