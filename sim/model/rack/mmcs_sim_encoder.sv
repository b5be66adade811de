// SPDX-License-Identifier: Apache-2.0
// The encoder counter of a card as a model of its own, its bus at rest. The registers of one on a
// card are lent to it for the edges of A and B, which concern nothing else there. §5.3.2

`default_nettype none

module mmcs_sim_encoder #(
    parameter int ClkHz = 8_000_000,  // of no meaning here; every model of the rack is given it
    parameter bit Skip  = 1'b1
) (
    input  wire logic        clk_i,
    input  wire logic        rst_ni,
    input  wire logic [ 2:0] m_i,
    input  wire logic        a_i,
    input  wire logic        b_i,
    input  wire logic [15:0] extra_i,
    output logic      [15:0] count_o
);
  /* verilator lint_off PINCONNECTEMPTY */
  thct2000 #(
      .Skip(Skip)
  ) u_encoder (
      .clk_i,
      .rst_ni,
      .reset_i(1'b0),
      .clk_en_i(1'b1),
      .m_i,
      .a_i,
      .b_i,
      .latch_i(1'b0),
      .asleep_i(1'b0),
      .cs_ni(1'b1),
      .rd_ni(1'b1),
      .wr_ni(1'b1),
      .rs_i(1'b0),
      .d_i(8'h00),
      .d_o(),
      .d_oe_o(),
      .count_o,
      .illegal_o(),
      .extra_i,
      .horizon_o()
  );
  /* verilator lint_on PINCONNECTEMPTY */
endmodule

`default_nettype wire
