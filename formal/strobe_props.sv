// SPDX-License-Identifier: Apache-2.0
// A data strobe against clocks of any phase: every step is an instant, not a clock. §4.3.1
`default_nettype none
`include "mmcs_formal.svh"

module strobe_props (
  input wire logic board_clk_i,   // the board's clock: rises when it likes
  input wire logic as_ni,
  input wire logic ds0_ni,
  input wire logic ours_i
);

  (* gclk *) logic clk_i;         // the instants

  logic rst_ni = 1'b0;
  always @(posedge clk_i) rst_ni <= 1'b1;

  logic seen;
  vme_strobe dut (.clk_i(board_clk_i), .rst_ni, .as_ni, .ds0_ni, .ours_i, .seen_o(seen));

  // The strobe that is low now: under our address since it fell; clocks that it has stood so.
  logic good_q = 1'b0, good, clk_q = 1'b1, stands, stands_q = 1'b0, rises, high_q = 1'b1;
  logic awake_q = 1'b0, rst_q = 1'b0;            // the first clock after power-on has come
  logic [1:0] edges_q = '0;
  logic [1:0] falls_q = '0;        // of the strobe in this clock of the board
  assign rises  = board_clk_i && !clk_q;
  assign good   = !ds0_ni && ours_i && (high_q || good_q);
  assign stands = good && !as_ni;

  always @(posedge clk_i) begin
    clk_q <= board_clk_i;
    rst_q <= rst_ni;
    high_q <= ds0_ni;
    if (rises && rst_q) awake_q <= 1'b1;
    if (rises) falls_q <= {1'b0, !ds0_ni && high_q};
    else if (!ds0_ni && high_q && falls_q != '1) falls_q <= falls_q + 1'b1;
    if (rst_ni) begin
      good_q <= good;
      stands_q <= stands;
      if (!stands) edges_q <= '0;
      else if (rises && stands_q && edges_q != '1) edges_q <= edges_q + 1'b1;
    end
  end

  `MMCS_GIVEN(Pace, falls_q < 2'd2 || ds0_ni || $past(ours_i) == ours_i,
              "two strobes and an address pipelined under the second do not fit one clock")
  `MMCS_GIVEN(PowerOn, (awake_q || ds0_ni || ours_i) && (rst_q || ds0_ni),
              "until the first clock after power-on nobody else uses the bus")
  `MMCS_GIVEN(Holds, !good_q || ds0_ni || $past(seen) || ours_i,
              "the address stands until the strobe has been seen, since DTACK* comes later")
  `MMCS_PROVE(Ours, "4.3.1", seen && !$past(seen), $past(good) && !ds0_ni,
              "a strobe is seen only if it fell under our address and has stood since")
  `MMCS_PROVE(Gone, "4.3.1", ds0_ni, !seen,
              "a strobe that is high, for however short, is forgotten at once")
  `MMCS_PROVE(Kept, "4.3.1", $past(seen) && !ds0_ni && !$past(ds0_ni), seen,
              "once seen it is seen until it rises")
  `MMCS_PROVE(Caught, "4.3.1", stands && edges_q != 2'd0, seen,
              "a strobe of ours is seen at the first edge of the clock at which AS* is low too")

endmodule

`default_nettype wire
