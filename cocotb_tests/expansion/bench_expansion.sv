// SPDX-License-Identifier: Apache-2.0
// The machine with one Mark I card and a third-party card on its expansion connector. §4.2.2
`default_nettype none

module bench_expansion #(
  parameter int HeartbeatUs = 400
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic [15:1] vme_a_i,
  input  wire logic [ 5:0] vme_am_i,
  input  wire logic        vme_as_ni,
  input  wire logic [ 1:0] vme_ds_ni,
  input  wire logic        vme_write_ni,
  input  wire logic        vme_lword_ni,
  input  wire logic [15:0] vme_d_i,
  output logic      [15:0] vme_d_o,
  output logic             vme_d_oe_o,
  output logic             vme_dtack_no,
  input  wire logic        vme_iack_ni,
  input  wire logic        vme_iackin_ni,
  output logic             vme_iackout_no,
  output logic      [ 7:1] vme_irq_no,
  input  wire logic        vme_sysreset_ni,
  input  wire logic        estop_closed_i,
  input  wire logic        cable_ok_i,
  input  wire logic        pc_power_i,
  output logic             panic_o,
  output logic             sclock_o,
  input  wire logic [ 1:0] enc_a_i,
  input  wire logic [ 1:0] enc_b_i,
  input  wire logic [ 1:0] enc_i_i,
  input  wire logic [ 1:0] axis_enable_i,
  // The third-party card
  output logic      [15:0] pcx_a_o,
  output logic      [ 7:0] pcx_d_o,
  output logic             pcx_ior_no,
  output logic             pcx_iow_no,
  output logic             pcx_aen_o,
  output logic      [ 7:0] dio_o,
  input  wire logic [ 7:0] dio_i
);

  logic pcx_clk_en, pcx_reset_drv, dio_wait, dio_irq, dio_oe;
  logic [7:0] dio_d;

  /* verilator lint_off PINCONNECTEMPTY */
  mmcs #(
    .NumCards(1),
    .HeartbeatUs(HeartbeatUs),
    .RelayUs(20),
    .PanicIrq(7)
  ) u_mmcs (
    .clk_i, .rst_ni,
    .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni, .vme_d_i, .vme_d_o,
    .vme_d_oe_o, .vme_dtack_no, .vme_iack_ni, .vme_iackin_ni, .vme_iackout_no, .vme_irq_no,
    .vme_sysreset_ni, .estop_closed_i, .cable_ok_i, .pc_power_i,
    .brake_release_o(),
    .alive_o(),
    .panic_o, .sclock_o,
    .led_irq_o(),
    .enc_a_i, .enc_b_i, .enc_i_i, .axis_enable_i,
    .dip_i('0),
    .adc_v_i(32'h0),
    .drive_v_o(),
    .card_leds_o(),
    .pcx_a_o, .pcx_d_o, .pcx_ior_no, .pcx_iow_no, .pcx_aen_o,
    .pcx_clk_en_o(pcx_clk_en),
    .pcx_reset_drv_o(pcx_reset_drv),
    .pcx_drq_o(),
    .pcx_d_oe_o(),
    .pcx_d_i(dio_d),
    .pcx_d_oe_i(dio_oe),
    .pcx_wait_i(dio_wait),
    .pcx_irq_i({dio_irq, 4'h0})
  );
  /* verilator lint_on PINCONNECTEMPTY */

  dio_card u_dio (
    .clk_i, .rst_ni,
    .clk_en_i(pcx_clk_en),
    .reset_drv_i(pcx_reset_drv),
    .a_i(pcx_a_o),
    .aen_i(pcx_aen_o),
    .ior_ni(pcx_ior_no),
    .iow_ni(pcx_iow_no),
    .d_i(pcx_d_o),
    .d_o(dio_d),
    .d_oe_o(dio_oe),
    .wait_o(dio_wait),
    .irq_o(dio_irq),
    .out_o(dio_o),
    .in_i(dio_i)
  );

endmodule

`default_nettype wire
