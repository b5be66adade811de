// SPDX-License-Identifier: Apache-2.0
// The encoder chip under replayed pins: plain, and with the input filter.
`default_nettype none

module bench_thct2000 (
    input wire clk_i,
    input wire rst_ni,
    // replay
    input wire go_i,
    input wire [31:0] id_i,
    input wire [31:0] length_i,
    input wire [1:0] pick_i,  // bit 0: the part with Filter = 2
    output wire done_o
);
  localparam int InBits = 21;
  localparam int OutBits = 26;
  localparam logic [InBits-1:0] Idle = 21'h000702;

  logic [InBits-1:0] stim;
  logic [OutBits-1:0] dut_resp, filter_resp;

  bench_replay #(
      .InBits(InBits),
      .OutBits(OutBits),
      .Idle(Idle)
  ) u_replay (
      .clk_i,
      .go_i,
      .id_i,
      .length_i,
      .stim_o(stim),
      .resp_i(pick_i[0] ? filter_resp : dut_resp),
      .done_o
  );

  logic reset, clk_en, a, b, latch, other, cs_n, rd_n, wr_n, rs;
  logic [2:0] m;
  logic [7:0] d;

  assign {other, d, rs, wr_n, rd_n, cs_n, latch, b, a, m, clk_en, reset} = stim;

  logic [7:0] dut_d;
  logic [15:0] dut_count;
  logic dut_oe, dut_illegal;

  thct2000 u_dut (
      .clk_i(clk_i),
      .rst_ni,
      .reset_i(reset),
      .clk_en_i(clk_en),
      .m_i(m),
      .a_i(a),
      .b_i(b),
      .latch_i(latch),
      .other_i(other),
      .cs_ni(cs_n),
      .rd_ni(rd_n),
      .wr_ni(wr_n),
      .rs_i(rs),
      .d_i(d),
      .d_o(dut_d),
      .d_oe_o(dut_oe),
      .count_o(dut_count),
      .illegal_o(dut_illegal)
  );

  assign dut_resp = {dut_illegal, dut_count, dut_oe, dut_d};

  logic [7:0] filter_d;
  logic [15:0] filter_count;
  logic filter_oe, filter_illegal;

  thct2000 #(
      .Filter(2)
  ) u_filter (
      .clk_i(clk_i),
      .rst_ni,
      .reset_i(reset),
      .clk_en_i(clk_en),
      .m_i(m),
      .a_i(a),
      .b_i(b),
      .latch_i(latch),
      .other_i(other),
      .cs_ni(cs_n),
      .rd_ni(rd_n),
      .wr_ni(wr_n),
      .rs_i(rs),
      .d_i(d),
      .d_o(filter_d),
      .d_oe_o(filter_oe),
      .count_o(filter_count),
      .illegal_o(filter_illegal)
  );

  assign filter_resp = {filter_illegal, filter_count, filter_oe, filter_d};
endmodule

`default_nettype wire
