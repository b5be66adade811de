// SPDX-License-Identifier: Apache-2.0
// DS0* as one clock may see it: low without a break since it fell in a cycle of ours. §4.3.1
//
// A strobe may be high for 30 ns between two cycles, and with address pipelining the strobe of
// another board's transfer still stands when our address is already on the bus. Neither is to be
// seen by sampling every 125 ns, so the flip-flops here are cleared by the bus itself; docs/evidence/edges.md
// lists them. The order of two such events within one clock is kept by two flip-flops, of which the
// second is cleared only after the first.
`default_nettype none

module vme_strobe (
  input  wire logic clk_i,
  input  wire logic rst_ni,
  // Asynchronous
  input  wire logic as_ni,
  input  wire logic ds0_ni,
  input  wire logic ours_i,   // the cycle that the address lines show is of our kind
  // First stage: synchronise it once more
  output logic      seen_o
);

  // Two watches take turns: one that has seen something is set again while the other one looks.
  logic watch_q;              // which one looks
  logic [1:0] ours_only;      // 0: the strobe was low in another's cycle
  logic [1:0] not_since;      // 0: it has been high after that
  logic stray_q;              // the strobe that is low now fell in another's cycle
  logic stray, seen_q, low_n;

  assign low_n = rst_ni & ~ds0_ni;   // low clears: reset, or DS0* high
  assign stray = stray_q | (~ours_only[watch_q] & not_since[watch_q]);

  for (genvar n = 0; n < 2; n++) begin : g_watch
    logic looks, ours_n, since_n;
    logic ours_q, since_q;
    assign looks = watch_q == 1'(n);
    assign ours_n = rst_ni & ~(looks & ~stray_q & ~seen_q & ~ds0_ni & ~ours_i);
    assign since_n = rst_ni & ~(looks & ds0_ni & ~ours_q);
    assign ours_only[n] = ours_q;
    assign not_since[n] = since_q;

    always_ff @(posedge clk_i or negedge ours_n) begin
      if (!ours_n) ours_q <= 1'b0;
      else ours_q <= 1'b1;
    end

    always_ff @(posedge clk_i or negedge since_n) begin
      if (!since_n) since_q <= 1'b0;
      else since_q <= 1'b1;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) watch_q <= 1'b0;
    else watch_q <= watch_q ^ ~ours_only[watch_q];
  end

  always_ff @(posedge clk_i or negedge low_n) begin
    if (!low_n) begin
      stray_q <= 1'b0;
      seen_q  <= 1'b0;
    end else begin
      if (stray || !ours_i) stray_q <= 1'b1;
      if (!as_ni && ours_i && !stray) seen_q <= 1'b1;
    end
  end

  assign seen_o = seen_q;

endmodule

`default_nettype wire
