// SPDX-License-Identifier: Apache-2.0
// A strobe DS0* of a cycle of ours, as one clock may see it. §4.3.1
//
// Several cycles may pass within one clock, and with address pipelining the strobe of another
// board's transfer still stands when our address is already on the bus. So the strobes themselves
// clock what tells cycles apart, as they did in TTL: the fall of AS* takes whether the address is
// ours, which has stood for 10 ns by then; its rise ends the cycle and makes a strobe stale that
// stands. DS0* may fall 10 ns before AS*, but never within 20 ns of the rise of AS*.
//
// A cycle is ours while two flip-flops differ, of which each edge of AS* moves one, so that the
// comparison has no glitch, however long the wires.
`default_nettype none

module vme_strobe (
  input  wire logic clk_i,
  input  wire logic rst_ni,
  // Asynchronous
  input  wire logic as_ni,
  input  wire logic ds0_ni,
  input  wire logic match_i,     // the cycle that the address lines show is of our kind
  output logic      selected_o,  // the cycle is ours, from the fall of AS* to its rise
  // Synchronised; low with DS0* high, at once: it has one reader
  output logic      ds0_valid_o
);

  // No clock but the pins moves these: each has its value before the first edge, too.
  logic begun_d;
  /* verilator lint_off PROCASSINIT */
  logic begun_q = 1'b0;      // at the fall of AS*: other than ended_q if the cycle is ours
  logic ended_q = 1'b0;      // at the rise of AS*: the same
  logic ds0_fell_q = 1'b0;   // since the reset: a strobe that stands through it is old
  logic ds0_stale_q = 1'b0;  // this strobe stood as AS* rose
  /* verilator lint_on PROCASSINIT */

  assign begun_d = ended_q ^ match_i;

  always_ff @(negedge as_ni or negedge rst_ni) begin
    if (!rst_ni) begun_q <= 1'b0;
    else begun_q <= begun_d;
  end

  always_ff @(posedge as_ni or negedge rst_ni) begin
    if (!rst_ni) ended_q <= 1'b0;
    else ended_q <= begun_q;
  end

  always_ff @(negedge ds0_ni or negedge rst_ni) begin
    if (!rst_ni) ds0_fell_q <= 1'b0;
    else ds0_fell_q <= 1'b1;
  end

  logic ds0;
  assign ds0 = ~ds0_ni;

  always_ff @(posedge as_ni or negedge ds0) begin
    if (!ds0) ds0_stale_q <= 1'b0;
    else ds0_stale_q <= 1'b1;
  end

  assign selected_o = begun_q ^ ended_q;

  // The second flip-flop is high only if DS0* has been low without a break since the first took it.
  mmcs_sync u_ds0_valid (
    .clk_i,
    .rst_ni(ds0),
    .d_i(selected_o & ds0_fell_q & ~ds0_stale_q & ~ds0_ni),
    .q_o(ds0_valid_o)
  );

endmodule

`default_nettype wire
