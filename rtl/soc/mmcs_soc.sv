// SPDX-License-Identifier: Apache-2.0
// The machine with its own processor: an RV32 core at the host port of the adaptor, no VMEbus
// between. docs/hardware/soc.md; the machine's ports are those of rtl/mmcs.sv.
//
// cpu_clk_i may be clk_i itself, a multiple, or any other clock.
`default_nettype none

module mmcs_soc #(
  parameter int NumCards = 3,
  parameter int ClkHz = 8_000_000,      // of clk_i
  parameter int RamWords = 32_768,
  parameter InitFile = "",              // memory at power-on, $readmemh
  parameter int AdcConvNs = 25_000,
  parameter int RelayUs = 1_000,
  parameter int HeartbeatUs = 50_000,
  parameter bit RandomPowerUp = 1'b0
) (
  input  wire logic                   clk_i,
  input  wire logic                   cpu_clk_i,
  input  wire logic                   rst_ni,
  // Window of a computer above: see soc_host
  input  wire logic                   run_i,
  input  wire logic                   box_req_i,
  input  wire logic                   box_write_i,
  input  wire logic [           31:2] box_a_i,
  input  wire logic [           31:0] box_wdata_i,
  output logic                        box_ack_o,
  output logic      [           31:0] box_rdata_o,
  input  wire logic                   ring_i,
  output logic                        report_valid_o,
  output logic      [            7:0] report_o,
  input  wire logic                   report_take_i,
  // Safety
  input  wire logic                   sysreset_ni,
  input  wire logic                   estop_closed_i,
  input  wire logic                   cable_ok_i,
  input  wire logic                   pc_power_i,
  output logic                        brake_release_o,
  output logic                        alive_o,
  output logic                        panic_o,
  output logic                        sclock_o,
  output logic                        led_irq_o,
  // Joints
  input  wire logic [ 2*NumCards-1:0] enc_a_i,
  input  wire logic [ 2*NumCards-1:0] enc_b_i,
  input  wire logic [ 2*NumCards-1:0] enc_i_i,
  input  wire logic [ 2*NumCards-1:0] axis_enable_i,
  input  wire logic [ 4*NumCards-1:0] dip_i,
  input  wire logic [32*NumCards-1:0] adc_v_i,
  output logic      [32*NumCards-1:0] drive_v_o,
  output logic      [11*NumCards-1:0] card_leds_o
);

  logic hp_req, hp_write, hp_ack;
  logic [10:1] hp_a;
  logic [7:0] hp_wdata, hp_rdata;

  soc_host #(
    .ClkHz(ClkHz),
    .RamWords(RamWords),
    .InitFile(InitFile),
    .TimeoutClks(16 * (ClkHz / 1_000_000))
  ) u_host (
    .clk_i, .cpu_clk_i, .rst_ni, .run_i,
    .box_req_i, .box_write_i, .box_a_i, .box_wdata_i, .box_ack_o, .box_rdata_o,
    .ring_i, .report_valid_o, .report_o, .report_take_i,
    .irq_i(led_irq_o),
    .hp_req_o(hp_req),
    .hp_write_o(hp_write),
    .hp_a_o(hp_a),
    .hp_wdata_o(hp_wdata),
    .hp_ack_i(hp_ack),
    .hp_rdata_i(hp_rdata)
  );

  /* verilator lint_off PINCONNECTEMPTY */  // no vector is fetched; no expansion card
  mmcs_core #(
    .NumCards(NumCards),
    .ClkHz(ClkHz),
    .AdcConvNs(AdcConvNs),
    .RelayUs(RelayUs),
    .HeartbeatUs(HeartbeatUs),
    .RandomPowerUp(RandomPowerUp)
  ) u_mmcs (
    .clk_i, .rst_ni,
    .hp_req_i(hp_req),
    .hp_write_i(hp_write),
    .hp_a_i(hp_a),
    .hp_wdata_i(hp_wdata),
    .hp_ack_o(hp_ack),
    .hp_rdata_o(hp_rdata),
    .irq_req_o(led_irq_o),
    .vector_o(),
    .sysreset_ni, .estop_closed_i, .cable_ok_i, .pc_power_i,
    .brake_release_o, .alive_o, .panic_o, .sclock_o,
    .enc_a_i, .enc_b_i, .enc_i_i, .axis_enable_i, .dip_i, .adc_v_i, .drive_v_o, .card_leds_o,
    .pcx_a_o(), .pcx_d_o(), .pcx_d_oe_o(), .pcx_ior_no(), .pcx_iow_no(),
    .pcx_aen_o(), .pcx_clk_en_o(), .pcx_reset_drv_o(), .pcx_drq_o(),
    .pcx_d_i('0),
    .pcx_d_oe_i(1'b0),
    .pcx_wait_i(1'b0),
    .pcx_irq_i('0)
  );
  /* verilator lint_on PINCONNECTEMPTY */

endmodule

`default_nettype wire
