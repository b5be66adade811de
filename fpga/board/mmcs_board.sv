// SPDX-License-Identifier: Apache-2.0
// One card on a board: a serial line is the host, SPI converters are the analog side, encoders,
// switches, lights and the e-stop loop are pins. docs/hardware/fpga.md
`default_nettype none

module mmcs_board #(
  parameter int ClkHz = 24_000_000,
  parameter int Baud = 1_000_000
) (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  input  wire logic       rx_i,
  output logic            tx_o,
  output logic            sclk_o,
  output logic            adc_cs_no,
  output logic            adc_din_o,
  input  wire logic       adc_dout_i,
  output logic            dac_sync_no,
  output logic            dac_din_o,
  input  wire logic [1:0] enc_a_i,
  input  wire logic [1:0] enc_b_i,
  input  wire logic [1:0] enc_i_i,
  input  wire logic [1:0] axis_enable_i,
  input  wire logic       estop_closed_i,
  output logic            brake_release_o,
  output logic            panic_o,
  output logic            sclock_o,
  output logic      [1:0] beat_o          // heartbeats: the servo light of each axis
);

  localparam int BeatLed = 6;   // of card_leds, Table 5.2

  logic hp_req, hp_write, hp_ack;
  logic [10:1] hp_a;
  logic [7:0] hp_wdata, hp_rdata;
  logic [31:0] drive, adc;
  logic [10:0] leds;

  uart_host #(
    .ClkHz(ClkHz),
    .Baud(Baud)
  ) u_host (
    .clk_i, .rst_ni, .rx_i, .tx_o,
    .hp_req_o(hp_req), .hp_write_o(hp_write), .hp_a_o(hp_a), .hp_wdata_o(hp_wdata),
    .hp_ack_i(hp_ack), .hp_rdata_i(hp_rdata)
  );

  spi_converters #(
    .ClkHz(ClkHz)
  ) u_converters (
    .clk_i, .rst_ni, .sclk_o, .adc_cs_no, .adc_din_o, .adc_dout_i, .dac_sync_no, .dac_din_o,
    .drive_v_i(drive),
    .adc_v_o(adc)
  );

  /* verilator lint_off PINCONNECTEMPTY */
  mmcs #(
    .NumCards(1),
    .ClkHz(ClkHz),
    .HostPort(1'b1)
  ) u_mmcs (
    .clk_i, .rst_ni,
    .vme_a_i('0), .vme_am_i('0), .vme_as_ni(1'b1), .vme_ds_ni('1), .vme_write_ni(1'b1),
    .vme_lword_ni(1'b1), .vme_d_i('0), .vme_d_o(), .vme_d_oe_o(), .vme_dtack_no(),
    .vme_iack_ni(1'b1), .vme_iackin_ni(1'b1), .vme_iackout_no(), .vme_irq_no(),
    .vme_sysreset_ni(1'b1),
    .estop_closed_i,
    .cable_ok_i(1'b1),
    .pc_power_i(1'b1),
    .brake_release_o, .panic_o, .sclock_o,
    .led_irq_o(),
    .enc_a_i, .enc_b_i, .enc_i_i, .axis_enable_i,
    .dip_i('0),
    .adc_v_i(adc),
    .drive_v_o(drive),
    .card_leds_o(leds),
    .pcx_a_o(), .pcx_d_o(), .pcx_ior_no(), .pcx_iow_no(), .pcx_aen_o(), .pcx_clk_en_o(),
    .pcx_reset_drv_o(), .pcx_drq_o(),
    .pcx_d_i('0),
    .pcx_d_oe_i(1'b0),
    .pcx_wait_i(1'b0),
    .pcx_irq_i('0),
    .hp_req_i(hp_req), .hp_write_i(hp_write), .hp_a_i(hp_a), .hp_wdata_i(hp_wdata),
    .hp_ack_o(hp_ack), .hp_rdata_o(hp_rdata)
  );
  /* verilator lint_on PINCONNECTEMPTY */

  assign beat_o = leds[BeatLed+:2];
  logic unused;
  assign unused = ^{leds[10:8], leds[5:0]};

endmodule

`default_nettype wire
