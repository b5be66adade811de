// SPDX-License-Identifier: Apache-2.0
// One card on a board: a serial line is the host, SPI converters are the analog side, encoders,
// switches, lights and the e-stop loop are pins. docs/hardware/fpga.md
`default_nettype none
`include "board_pins.svh"

module mmcs_board #(
  parameter int ClkHz = 24_000_000,
  parameter int Baud = 1_000_000,
  parameter int HeartbeatUs = 50_000
) (
  input  wire logic       clk_i,
  input  wire logic       locked_i,       // the PLL has
  input  wire logic       button_ni,      // reset while pressed
  output logic            panic_o,
  output logic            sclock_o,
  output logic      [1:0] beat_o,         // heartbeats: the servo light of each axis
  `BOARD_PINS
);

  localparam int BeatLed = 6;   // of card_leds, Table 5.2

  logic rst_n;
  logic spi_rst_n;              // of the converters: with the PLL, not with the button
  logic rst_nd, button_n;
  logic [1:0] reset_d, reset_q;
  logic hp_req, hp_write, hp_ack;
  logic [10:1] hp_a;
  logic [7:0] hp_wdata, hp_rdata;
  logic [31:0] drive, adc;
  logic [10:0] leds;

  sync u_spi_reset (.clk_i, .rst_ni(locked_i), .en_i(1'b1), .d_i(1'b1), .q_o(spi_rst_n));

  sync u_button (.clk_i, .rst_ni(locked_i), .en_i(1'b1), .d_i(button_ni), .q_o(button_n));

  assign reset_d = {reset_q[0], button_n};
  assign rst_nd = &{reset_q, button_n};

  always_ff @(posedge clk_i or negedge locked_i) begin
    if (!locked_i) {rst_n, reset_q} <= '0;
    else {rst_n, reset_q} <= {rst_nd, reset_d};
  end

  uart_host #(
    .ClkHz(ClkHz),
    .Baud(Baud)
  ) u_host (
    .clk_i, .rst_ni(rst_n), .rx_i(ftdi_txd), .tx_o(ftdi_rxd),
    .hp_req_o(hp_req), .hp_write_o(hp_write), .hp_a_o(hp_a), .hp_wdata_o(hp_wdata),
    .hp_ack_i(hp_ack), .hp_rdata_i(hp_rdata)
  );

  spi_converters #(
    .ClkHz(ClkHz)
  ) u_converters (
    .clk_i,
    .rst_ni(spi_rst_n),
    .run_i(rst_n),
    .sclk_o(spi_sclk),
    .adc_cs_no(adc_cs_n), .adc_din_o(adc_din), .adc_dout_i(adc_dout),
    .dac_sync_no(dac_sync_n), .dac_din_o(dac_din), .dac_clr_no(dac_clr_n),
    .dac_ldac_no(dac_ldac_n),
    .drive_v_i(drive),
    .adc_v_o(adc)
  );

  /* verilator lint_off PINCONNECTEMPTY */
  mmcs_core #(
    .NumCards(1),
    .ClkHz(ClkHz),
    .HeartbeatUs(HeartbeatUs)
  ) u_mmcs (
    .clk_i, .rst_ni(rst_n),
    .hp_req_i(hp_req), .hp_write_i(hp_write), .hp_a_i(hp_a), .hp_wdata_i(hp_wdata),
    .hp_ack_o(hp_ack), .hp_rdata_o(hp_rdata),
    .irq_req_o(),
    .vector_o(),
    .sysreset_ni(1'b1),
    .estop_closed_i(~estop_n),
    .cable_ok_i(1'b1),
    .pc_power_i(1'b1),
    .brake_release_o(brake_release), .alive_o(alive), .panic_o, .sclock_o,
    .enc_a_i(enc_a), .enc_b_i(enc_b), .enc_i_i(enc_i), .axis_enable_i(~enable_n),
    .dip_i('0),
    .adc_v_i(adc),
    .drive_v_o(drive),
    .card_leds_o(leds),
    .pcx_a_o(), .pcx_d_o(), .pcx_d_oe_o(), .pcx_ior_no(), .pcx_iow_no(),
    .pcx_aen_o(), .pcx_clk_en_o(), .pcx_reset_drv_o(), .pcx_drq_o(),
    .pcx_d_i('0),
    .pcx_d_oe_i(1'b0),
    .pcx_wait_i(1'b0),
    .pcx_irq_i('0)
  );
  /* verilator lint_on PINCONNECTEMPTY */

  assign beat_o = leds[BeatLed+:2];
  logic unused;
  assign unused = ^{leds[10:8], leds[5:0]};

endmodule

`default_nettype wire
