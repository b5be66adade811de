// SPDX-License-Identifier: Apache-2.0
// ULX3S (ECP5): 25 MHz in, 24 MHz inside; pins in ulx3s.lpf. docs/hardware/fpga.md
//
// All inputs from outside have pull-ups in the pin file: an open e-stop loop is a pressed button.
`default_nettype none

module ulx3s (
  input  wire logic       clk_25mhz,
  input  wire logic       btn_pwr_n,       // reset while pressed
  input  wire logic       ftdi_txd,        // from the PC
  output logic            ftdi_rxd,
  output logic            wifi_gpio0,      // high: the board does not start anew
  output logic      [7:0] led,
  output logic            spi_sclk,
  output logic            adc_cs_n,
  output logic            adc_din,
  input  wire logic       adc_dout,
  output logic            dac_sync_n,
  output logic            dac_din,
  input  wire logic [1:0] enc_a,
  input  wire logic [1:0] enc_b,
  input  wire logic [1:0] enc_i,
  input  wire logic [1:0] enable_n,        // switches to ground
  input  wire logic       estop_n,         // the loop to ground is closed
  output logic            brake_release
);

  localparam int ClkHz = 24_000_000;

  logic clk, locked, fed;
  logic [3:0] reset_q;
  logic rst_n, panic, sclock;
  logic [1:0] beat;

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

  always_ff @(posedge clk or negedge locked) begin
    if (!locked) {rst_n, reset_q} <= '0;
    else {rst_n, reset_q} <= {&reset_q, reset_q[2:0], btn_pwr_n};
  end

  mmcs_board #(
    .ClkHz(ClkHz)
  ) u_board (
    .clk_i(clk),
    .rst_ni(rst_n),
    .rx_i(ftdi_txd),
    .tx_o(ftdi_rxd),
    .sclk_o(spi_sclk),
    .adc_cs_no(adc_cs_n),
    .adc_din_o(adc_din),
    .adc_dout_i(adc_dout),
    .dac_sync_no(dac_sync_n),
    .dac_din_o(dac_din),
    .enc_a_i(enc_a),
    .enc_b_i(enc_b),
    .enc_i_i(enc_i),
    .axis_enable_i(~enable_n),
    .estop_closed_i(~estop_n),
    .brake_release_o(brake_release),
    .panic_o(panic),
    .sclock_o(sclock),
    .beat_o(beat)
  );

  assign led = {locked, panic, brake_release, sclock, 2'b00, beat};
  assign wifi_gpio0 = 1'b1;

endmodule

`default_nettype wire
