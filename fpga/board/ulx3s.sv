// SPDX-License-Identifier: Apache-2.0
// ULX3S (ECP5): 25 MHz in, 24 MHz inside; pins in ulx3s.lpf. docs/hardware/fpga.md
//
// All inputs from outside have pull-ups in the pin file: an open e-stop loop is a pressed button.
`default_nettype none
`include "board_pins.svh"

module ulx3s (
  input  wire logic       clk_25mhz,
  input  wire logic       btn_pwr_n,       // reset while pressed
  output logic            wifi_gpio0,      // high: the board does not start anew
  output logic      [7:0] led,
  `BOARD_PINS
);

  localparam int ClkHz = 24_000_000;

  logic clk, locked, fed;
  logic panic, sclock;
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

  mmcs_board #(
    .ClkHz(ClkHz)
  ) u_board (
    .clk_i(clk),
    .locked_i(locked),
    .button_ni(btn_pwr_n),
    .panic_o(panic),
    .sclock_o(sclock),
    .beat_o(beat),
    .*
  );

  assign led = {locked, panic, brake_release, sclock, 2'b00, beat};
  assign wifi_gpio0 = 1'b1;

endmodule

`default_nettype wire
