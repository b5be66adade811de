// SPDX-License-Identifier: Apache-2.0
// The board's top with its lights by name; the clock is what its PLL would put out.
`default_nettype none
`include "board_pins.svh"

module bench_ulx3s_soc (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  output logic            panic_o,
  output logic      [1:0] beat_o,
  `BOARD_PINS
);

  logic [7:0] led;
  logic unused_gpio0, unused;

  ulx3s_soc u_board (.clk_25mhz(clk_i), .btn_pwr_n(rst_ni), .wifi_gpio0(unused_gpio0), .*);

  assign panic_o = led[6];
  assign beat_o = led[1:0];
  assign unused = ^{led[7], led[5:2]};

endmodule

`default_nettype wire
