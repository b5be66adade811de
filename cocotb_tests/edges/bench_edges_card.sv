// SPDX-License-Identifier: Apache-2.0
// One card on a PC bus, its times short so that a sweep meets their ends.
`timescale 1ps/1ps
`default_nettype none

module bench_edges_card (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic [15:0] window_i,    // of metastability, ps
  input  wire logic        reset_drv_i,
  input  wire logic [15:0] a_i,
  input  wire logic        ior_ni,
  input  wire logic        iow_ni,
  input  wire logic [ 7:0] d_i,
  input  wire logic        sclock_i,
  input  wire logic [ 1:0] enable_i,
  input  wire logic        power_i,
  input  wire logic [ 1:0] enc_a_i,
  input  wire logic [ 1:0] enc_b_i,
  input  wire logic [ 1:0] enc_i_i,
  input  wire logic [31:0] adc_v_i,
  output logic      [ 7:0] d_o,
  output logic             d_oe_o,
  output logic             panic_o,
  output logic      [31:0] drive_v_o
);

  logic [7:3] irq;
  assign panic_o = |irq;
  always_comb metastable_pkg::window = int'(window_i);

  /* verilator lint_off PINCONNECTEMPTY */
  mark1 #(
    .AdcConvNs(2_000),
    .RelayUs(1),
    .HeartbeatUs(20)
  ) u_card (
    .clk_i, .rst_ni,
    .pc_clk_en_i(1'b1),
    .pc_reset_drv_i(reset_drv_i),
    .pc_a_i(a_i),
    .pc_aen_i(1'b0),
    .pc_ior_ni(ior_ni),
    .pc_iow_ni(iow_ni),
    .pc_d_i(d_i),
    .pc_d_o(d_o),
    .pc_d_oe_o(d_oe_o),
    .pc_drq_i({sclock_i, 2'b00}),
    .pc_irq_o(irq),
    .dip_i(4'd0),
    .axis_enable_i(enable_i),
    .power_i,
    .enc_a_i, .enc_b_i, .enc_i_i, .adc_v_i, .drive_v_o,
    .leds_o()
  );
  /* verilator lint_on PINCONNECTEMPTY */

endmodule

`default_nettype wire
