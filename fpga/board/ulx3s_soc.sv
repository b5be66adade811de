// SPDX-License-Identifier: Apache-2.0
// A ULX3S that closes the loop by itself: the SoC with the driver in its memory, one card, encoders
// and converters at the pins of ulx3s.sv, a serial console. docs/hardware/fpga.md
`default_nettype none
`include "board_pins.svh"

module ulx3s_soc #(
  parameter InitFile = "build/fpga/loop.hex"
) (
  input  wire logic       clk_25mhz,
  input  wire logic       btn_pwr_n,       // reset while pressed
  output logic            wifi_gpio0,      // high: the board does not start anew
  output logic      [7:0] led,
  `BOARD_PINS
);

  localparam int ClkHz = 24_000_000;
  localparam int BeatLed = 6;   // of card_leds, Table 5.2

  logic clk, locked, fed, rst_n, spi_rst_n;
  logic panic, sclock, irq;
  logic hp_req, hp_write, hp_ack, box_req, box_write, box_ack, ring, report_valid, report_take;
  logic [10:1] hp_a;
  logic [7:0] hp_wdata, hp_rdata, report;
  logic [31:2] box_a;
  logic [31:0] box_wdata, box_rdata, drive, adc;
  logic [10:0] leds;
  logic rst_nd, button_n;
  logic [1:0] reset_d, reset_q;

  // 25 MHz * 24 = 600 MHz, of which CLKOP is the 24th part again and CLKOS the 25th.
  EHXPLLL #(
    .CLKI_DIV(1),
    .CLKFB_DIV(1),
    .CLKOP_DIV(24),
    .CLKOP_CPHASE(23),
    .CLKOS_DIV(25),
    .CLKOS_CPHASE(24),
    .CLKOS_ENABLE("ENABLED"),
    .FEEDBK_PATH("CLKOP")
  ) u_pll (
    .CLKI(clk_25mhz),
    .CLKFB(fed),
    .CLKOP(fed),
    .CLKOS(clk),
    .LOCK(locked),
    .RST(1'b0),
    .STDBY(1'b0),
    .PHASESEL0(1'b0),
    .PHASESEL1(1'b0),
    .PHASEDIR(1'b0),
    .PHASESTEP(1'b0),
    .PHASELOADREG(1'b0),
    .PLLWAKESYNC(1'b0),
    .ENCLKOP(1'b0),
    .ENCLKOS(1'b0)
  );

  sync u_spi_reset (.clk_i(clk), .rst_ni(locked), .en_i(1'b1), .d_i(1'b1), .q_o(spi_rst_n));

  sync u_button (.clk_i(clk), .rst_ni(locked), .en_i(1'b1), .d_i(btn_pwr_n), .q_o(button_n));

  assign reset_d = {reset_q[0], button_n};
  assign rst_nd = &{reset_q, button_n};

  always_ff @(posedge clk or negedge locked) begin
    if (!locked) {rst_n, reset_q} <= '0;
    else {rst_n, reset_q} <= {rst_nd, reset_d};
  end

  // --- console ----------------------------------------------------------------------------

  uart_host #(
    .ClkHz(ClkHz)
  ) u_host (
    .clk_i(clk), .rst_ni(rst_n), .rx_i(ftdi_txd), .tx_o(ftdi_rxd),
    .hp_req_o(hp_req), .hp_write_o(hp_write), .hp_a_o(hp_a), .hp_wdata_o(hp_wdata),
    .hp_ack_i(hp_ack), .hp_rdata_i(hp_rdata)
  );

  soc_console u_console (
    .clk_i(clk), .rst_ni(rst_n),
    .hp_req_i(hp_req), .hp_write_i(hp_write), .hp_a_i(hp_a), .hp_wdata_i(hp_wdata),
    .hp_ack_o(hp_ack), .hp_rdata_o(hp_rdata),
    .box_req_o(box_req), .box_write_o(box_write), .box_a_o(box_a), .box_wdata_o(box_wdata),
    .box_ack_i(box_ack), .box_rdata_i(box_rdata),
    .ring_o(ring),
    .report_valid_i(report_valid), .report_i(report), .report_take_o(report_take)
  );

  // --- machine ----------------------------------------------------------------------------

  mmcs_soc #(
    .NumCards(1),
    .ClkHz(ClkHz),
    .InitFile(InitFile)
  ) u_soc (
    .clk_i(clk), .cpu_clk_i(clk), .rst_ni(rst_n),
    .run_i(1'b1),
    .box_req_i(box_req), .box_write_i(box_write), .box_a_i(box_a), .box_wdata_i(box_wdata),
    .box_ack_o(box_ack), .box_rdata_o(box_rdata),
    .ring_i(ring),
    .report_valid_o(report_valid), .report_o(report), .report_take_i(report_take),
    .sysreset_ni(1'b1),
    .estop_closed_i(~estop_n), .cable_ok_i(1'b1), .pc_power_i(1'b1),
    .brake_release_o(brake_release), .alive_o(alive), .panic_o(panic), .sclock_o(sclock),
    .led_irq_o(irq),
    .enc_a_i(enc_a), .enc_b_i(enc_b), .enc_i_i(enc_i), .axis_enable_i(~enable_n),
    .dip_i('0),
    .adc_v_i(adc),
    .drive_v_o(drive),
    .card_leds_o(leds)
  );

  spi_converters #(
    .ClkHz(ClkHz)
  ) u_converters (
    .clk_i(clk), .rst_ni(spi_rst_n), .run_i(rst_n),
    .sclk_o(spi_sclk),
    .adc_cs_no(adc_cs_n), .adc_din_o(adc_din), .adc_dout_i(adc_dout),
    .dac_sync_no(dac_sync_n), .dac_din_o(dac_din), .dac_clr_no(dac_clr_n),
    .dac_ldac_no(dac_ldac_n),
    .drive_v_i(drive),
    .adc_v_o(adc)
  );

  assign led = {locked, panic, brake_release, sclock, irq, 1'b0, leds[BeatLed+:2]};
  assign wifi_gpio0 = 1'b1;
  logic unused;
  assign unused = ^{leds[10:8], leds[5:0]};

endmodule

`default_nettype wire
