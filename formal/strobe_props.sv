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

  `MMCS_RESET(1'b1)

  logic seen, cycle;
  vme_strobe dut (
    .clk_i(board_clk_i), .rst_ni, .as_ni, .ds0_ni, .match_i(ours_i),
    .selected_o(cycle), .ds0_valid_o(seen)
  );

  // The cycle under AS* is ours by its address as AS* fell; the strobe is another's if it stood as
  // AS* rose; clocks that a strobe of ours has stood.
  logic rst_q = 1'b0, as_q = 1'b1, ds0_q = 1'b1, clk_q = 1'b1, ours_q = 1'b0, mine_q = 1'b0, mine;
  logic old_q = 1'b1, old, good, good_q = 1'b0, rises;
  logic [1:0] edges_q = '0;
  assign rises = board_clk_i && !clk_q;
  assign mine  = !as_ni && (as_q ? ours_q : mine_q);
  assign old   = !ds0_ni && (old_q || (as_ni && !as_q));
  assign good  = !ds0_ni && !old && mine;

  always @(posedge clk_i) begin
    clk_q <= board_clk_i;
    rst_q <= rst_ni;
    if (rst_ni) begin
      {as_q, ds0_q, ours_q, mine_q, old_q, good_q} <= {as_ni, ds0_ni, ours_i, mine, old, good};
      if (!good) edges_q <= '0;
      else if (rises && good_q && edges_q != '1) edges_q <= edges_q + 1'b1;
    end
  end

  `MMCS_GIVEN(PowerOn, rst_q || (ds0_ni && as_ni), "nobody uses the bus in reset")
  `MMCS_GIVEN(SetUp, as_ni || !as_q || ours_i == ours_q,
              "address, modifier, LWORD* and IACK* stand 10 ns before AS* falls")
  `MMCS_GIVEN(Apart, !(as_ni && !as_q && !ds0_ni && ds0_q),
              "no data strobe falls as AS* rises, high for 30 ns: DS* falls 10 ns before it does")
  `MMCS_GIVEN(AsStands, !(as_ni && !as_q && good_q && !ds0_ni) || $past(seen),
              "AS* stands until DTACK*, which comes after the strobe has been seen")
  `MMCS_PROVE(Ours, "4.3.1", seen && !$past(seen), $past(good),
              "a strobe is seen only if it fell in a cycle of ours and stands")
  `MMCS_PROVE(Gone, "4.3.1", ds0_ni, !seen,
              "a strobe that is high, for however short, is forgotten at once")
  `MMCS_PROVE(Kept, "4.3.1", $past(seen) && good && good_q, seen,
              "once seen it is seen until it rises")
  `MMCS_PROVE(Caught, "4.3.1", good && edges_q >= 2'd2, seen,
              "a strobe of ours is seen at the second edge of the clock")
  `MMCS_PROVE(Cycle, "4.3.6", cycle, mine, "a cycle is ours by the address under which AS* fell")

endmodule

`default_nettype wire
