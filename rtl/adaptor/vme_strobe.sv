// SPDX-License-Identifier: Apache-2.0
// A strobe DS0* of a cycle of ours, as one clock may see it. §4.3.1
//
// Several cycles may pass within one clock, and with address pipelining the strobe of another
// board's transfer still stands when our address is already on the bus. So the strobes themselves
// clock what tells cycles apart, as they did in TTL: each rise of AS* numbers the next cycle; its
// fall takes the address, which has stood for 10 ns by then, the fall of DS0* the number. DS0* may
// fall 10 ns before AS*, but never within 20 ns of the rise of AS*.
//
// The numbers differ in one bit from one to the next and each takes a step at a time, so that no
// comparison of two has a glitch, however long the wires.
`default_nettype none

module vme_strobe (
  input  wire logic       clk_i,
  input  wire logic       rst_ni,
  // Asynchronous
  input  wire logic       as_ni,
  input  wire logic       ds0_ni,
  input  wire logic       match_i,         // the cycle that the address lines show is of our kind
  output logic      [1:0] cycle_number_o,  // changes as AS* rises
  output logic            selected_o,      // the cycle is ours, from the fall of AS* to its rise
  // Synchronised; low with DS0* high, at once: it has one reader
  output logic            ds0_valid_o
);

  logic [1:0] cycle_number_d, cycle_number_q;  // of this cycle: 0, 1, 3, 2
  logic [1:0] match_number_d, match_number_q;  // at the fall of AS*: the number if the cycle was
                                               // ours, else its opposite
  logic [1:0] ds0_number_q;                    // at the fall of DS0*: the number
  logic       ds0_stale_q;  // this strobe stood as AS* rose, were it four cycles ago

  assign cycle_number_d = {cycle_number_q[0], ~cycle_number_q[1]};
  assign match_number_d = match_i ? cycle_number_q : ~cycle_number_q;

  always_ff @(posedge as_ni or negedge rst_ni) begin
    if (!rst_ni) cycle_number_q <= 2'b00;
    else cycle_number_q <= cycle_number_d;
  end

  always_ff @(negedge as_ni or negedge rst_ni) begin
    if (!rst_ni) match_number_q <= 2'b11;
    else match_number_q <= match_number_d;
  end

  always_ff @(negedge ds0_ni or negedge rst_ni) begin
    if (!rst_ni) ds0_number_q <= 2'b10;  // a strobe that stands through reset is old
    else ds0_number_q <= cycle_number_q;
  end

  logic ds0;
  assign ds0 = ~ds0_ni;

  always_ff @(posedge as_ni or negedge ds0) begin
    if (!ds0) ds0_stale_q <= 1'b0;
    else ds0_stale_q <= 1'b1;
  end

  assign cycle_number_o = cycle_number_q;
  assign selected_o = (match_number_q == cycle_number_q);

  // The second flip-flop is high only if DS0* has been low without a break since the first took it.
  sync u_ds0_valid (
    .clk_i,
    .rst_ni(ds0), .en_i(1'b1),
    .d_i(selected_o & (ds0_number_q == cycle_number_q) & ~ds0_stale_q & ~ds0_ni),
    .q_o(ds0_valid_o)
  );

endmodule

`default_nettype wire
