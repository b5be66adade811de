// SPDX-License-Identifier: Apache-2.0
// Hands one request at a time from one clock to another and its answer back.
//
// Each side flips a flip-flop that the other side sees two of its own clocks later, so that the
// clocks may be the same, multiples, or strangers. The giver holds what belongs to the request from
// start_i until done_o, the taker what belongs to the answer from finish_i until the next request.
`default_nettype none
`include "mmcs_assert.svh"

module soc_cross (
  // The side that asks
  input  wire logic clk_i,
  input  wire logic rst_ni,
  input  wire logic start_i,      // one clock; only while busy_o is 0
  output logic      busy_o,       // from the clock after start_i to that of done_o
  output logic      done_o,       // one clock: the answer stands
  // The side that serves
  input  wire logic far_clk_i,
  input  wire logic far_rst_ni,
  output logic      far_req_o,    // a request waits, until the clock after finish
  input  wire logic far_finish_i  // one clock
);

  // Each side's own flip-flop; equal: nothing is under way
  logic ask_d, ask_q, answer_d, answer_q;
  logic answered, asked;   // as the other side sees them
  logic busy_d, busy_q;

  sync u_answer (.clk_i, .rst_ni, .en_i(1'b1), .d_i(answer_q), .q_o(answered));
  sync u_ask (
    .clk_i(far_clk_i), .rst_ni(far_rst_ni), .en_i(1'b1), .d_i(ask_q), .q_o(asked)
  );

  assign ask_d = ask_q ^ start_i;
  assign busy_d = start_i | (busy_q & ~done_o);
  assign answer_d = far_finish_i ? asked : answer_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      ask_q  <= 1'b0;
      busy_q <= 1'b0;
    end else begin
      ask_q  <= ask_d;
      busy_q <= busy_d;
    end
  end

  assign busy_o = busy_q;
  assign done_o = busy_q && (answered == ask_q);

  always_ff @(posedge far_clk_i or negedge far_rst_ni) begin
    if (!far_rst_ni) answer_q <= 1'b0;
    else answer_q <= answer_d;
  end

  assign far_req_o = (asked != answer_q);

  `MMCS_ASSERT(OneAtATime, !(start_i && busy_q), "a request starts only when the last is answered")

endmodule

`default_nettype wire
