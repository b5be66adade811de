// SPDX-License-Identifier: Apache-2.0
// iCEBreaker (iCE40 UP5K): 12 MHz in, 8 MHz inside; pins in icebreaker.pcf. docs/hardware/fpga.md
//
// All inputs from outside have pull-ups in the pin file: an open e-stop loop is a pressed button.
`default_nettype none
`include "board_pins.svh"

module icebreaker (
  input  wire logic       clk_12mhz,
  input  wire logic       btn_n,           // reset while pressed
  output logic            ledr_n,          // PANIC
  output logic            ledg_n,          // the PLL has locked
  output logic      [4:0] led,
  `BOARD_PINS
);

  localparam int ClkHz = 8_000_000;

  logic fast, locked, clk;
  logic [1:0] third_d, third_q;
  logic panic, sclock;
  logic [1:0] beat;

  // 12 MHz * 64 / 32: the PLL makes no less than 16 MHz, so a third of it is taken.
  SB_PLL40_PAD #(
    .FEEDBACK_PATH("SIMPLE"),
    .DIVR(4'd0),
    .DIVF(7'd63),
    .DIVQ(3'd5),
    .FILTER_RANGE(3'd1)
  ) u_pll (
    .PACKAGEPIN(clk_12mhz),
    .PLLOUTCORE(fast),
    .LOCK(locked),
    .RESETB(1'b1),
    .BYPASS(1'b0)
  );

  assign third_d = {third_q[0], third_q == '0};

  always_ff @(posedge fast or negedge locked) begin
    if (!locked) third_q <= '0;
    else third_q <= third_d;
  end

  SB_GB u_clk (
    .USER_SIGNAL_TO_GLOBAL_BUFFER(third_q[1]),
    .GLOBAL_BUFFER_OUTPUT(clk)
  );

  mmcs_board #(
    .ClkHz(ClkHz)
  ) u_board (
    .clk_i(clk),
    .locked_i(locked),
    .button_ni(btn_n),
    .panic_o(panic),
    .sclock_o(sclock),
    .beat_o(beat),
    .*
  );

  assign ledr_n = ~panic;
  assign ledg_n = ~locked;
  assign led = {brake_release, sclock, 1'b0, beat};

endmodule

`default_nettype wire
