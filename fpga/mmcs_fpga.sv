// SPDX-License-Identifier: Apache-2.0
// The machine of rtl/mmcs.sv with its VME front and what a board ties off tied off, for small
// devices. docs/hardware/fpga.md
`default_nettype none

module mmcs_fpga #(
  parameter int NumCards = 1,
  parameter int ClkHz = 8_000_000
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_ni,
  input  wire logic [           15:1] vme_a_i,
  input  wire logic [            5:0] vme_am_i,
  input  wire logic                   vme_as_ni,
  input  wire logic [            1:0] vme_ds_ni,
  input  wire logic                   vme_write_ni,
  input  wire logic                   vme_lword_ni,
  input  wire logic [            7:0] vme_d_i,
  output logic      [            7:0] vme_d_o,
  output logic                        vme_d_oe_o,
  output logic                        vme_dtack_no,
  input  wire logic                   vme_iack_ni,
  input  wire logic                   vme_iackin_ni,
  output logic                        vme_iackout_no,
  output logic      [            7:1] vme_irq_no,
  input  wire logic                   vme_sysreset_ni,
  input  wire logic                   estop_closed_i,
  input  wire logic                   cable_ok_i,
  input  wire logic                   pc_power_i,
  output logic                        brake_release_o,
  output logic                        alive_o,
  output logic                        panic_o,
  output logic                        sclock_o,
  output logic                        led_irq_o,
  input  wire logic [ 2*NumCards-1:0] enc_a_i,
  input  wire logic [ 2*NumCards-1:0] enc_b_i,
  input  wire logic [ 2*NumCards-1:0] enc_i_i,
  input  wire logic [ 2*NumCards-1:0] axis_enable_i,
  input  wire logic [ 4*NumCards-1:0] dip_i,
  input  wire logic [32*NumCards-1:0] adc_v_i,
  output logic      [32*NumCards-1:0] drive_v_o,
  output logic      [11*NumCards-1:0] card_leds_o
);

  logic [7:0] upper;
  logic rst_n;   // begins at once, ends with the clock
  sync u_reset (.clk_i, .rst_ni, .en_i(1'b1), .d_i(1'b1), .q_o(rst_n));

  /* verilator lint_off PINCONNECTEMPTY */
  mmcs #(
    .NumCards(NumCards),
    .ClkHz(ClkHz)
  ) u_mmcs (
    .clk_i,
    .rst_ni(rst_n),
    .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni,
    .vme_d_i({8'hFF, vme_d_i}),
    .vme_d_o({upper, vme_d_o}),
    .vme_d_oe_o, .vme_dtack_no, .vme_iack_ni, .vme_iackin_ni, .vme_iackout_no, .vme_irq_no,
    .vme_sysreset_ni,
    .estop_closed_i, .cable_ok_i, .pc_power_i, .brake_release_o, .alive_o, .panic_o, .sclock_o,
    .led_irq_o,
    .enc_a_i, .enc_b_i, .enc_i_i, .axis_enable_i, .dip_i, .adc_v_i, .drive_v_o, .card_leds_o,
    .pcx_a_o(),
    .pcx_d_o(),
    .pcx_d_oe_o(),
    .pcx_ior_no(),
    .pcx_iow_no(),
    .pcx_aen_o(),
    .pcx_clk_en_o(),
    .pcx_reset_drv_o(),
    .pcx_drq_o(),
    .pcx_d_i('0),
    .pcx_d_oe_i(1'b0),
    .pcx_wait_i(1'b0),
    .pcx_irq_i('0)
  );
  /* verilator lint_on PINCONNECTEMPTY */

  logic unused;
  assign unused = ^upper;

endmodule

`default_nettype wire
