// SPDX-License-Identifier: Apache-2.0
// The board's top with its lights by name; the clock is what its PLL would put out.
`default_nettype none
`include "board_pins.svh"

module bench_icebreaker (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  output logic            panic_o,
  output logic      [1:0] beat_o,
  `BOARD_PINS
);

  logic ledr_n;
  logic [4:0] led;
  logic unused_green, unused;

  icebreaker u_board (.clk_12mhz(clk_i), .btn_n(rst_ni), .ledg_n(unused_green), .*);

  assign panic_o = ~ledr_n;
  assign beat_o = led[1:0];
  assign unused = ^led[4:2];

endmodule

`default_nettype wire
