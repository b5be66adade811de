// SPDX-License-Identifier: Apache-2.0
// The encoder chip under replayed pins: plain, with the input filter, and skipping.
`default_nettype none

module bench_thct2000 (
    input wire clk_i,
    input wire rst_ni,
    // replay
    input wire go_i,
    input wire [31:0] id_i,
    input wire [31:0] length_i,
    input wire [3:0] pick_i,  // bit 0 lock-step, 1 the part with Filter = 2
    output wire done_o
);
  localparam int InBits = 20;
  localparam int OutBits = 26;
  localparam int EdgeBits = 1;
  localparam logic [InBits-1:0] Idle = 20'h00702;

  logic [InBits-1:0] replay_stim, lock_stim, stim;
  logic [OutBits-1:0] dut_resp, fast_resp, filter_resp;
  logic [EdgeBits-1:0] dut_edge, fast_edge;
  logic [15:0] extra, horizon;
  logic replay_done, lock_done, fast_clk;

  assign stim = pick_i[0] ? lock_stim : replay_stim;
  assign done_o = pick_i[0] ? lock_done : replay_done;

  bench_replay #(
      .InBits(InBits),
      .OutBits(OutBits),
      .Idle(Idle)
  ) u_replay (
      .clk_i,
      .go_i(go_i && !pick_i[0]),
      .id_i,
      .length_i,
      .stim_o(replay_stim),
      .resp_i(pick_i[1] ? filter_resp : dut_resp),
      .done_o(replay_done)
  );

  bench_lockstep #(
      .InBits(InBits),
      .OutBits(OutBits),
      .EdgeBits(EdgeBits),
      .Idle(Idle)
  ) u_lockstep (
      .clk_i,
      .go_i(go_i && pick_i[0]),
      .id_i,
      .length_i,
      .stim_o(lock_stim),
      .extra_o(extra),
      .fast_clk_o(fast_clk),
      .horizon_i(horizon),
      .slow_i(dut_resp),
      .fast_i(fast_resp),
      .slow_edge_i(dut_edge),
      .fast_edge_i(fast_edge),
      .done_o(lock_done)
  );

  logic reset, clk_en, a, b, latch, cs_n, rd_n, wr_n, rs;
  logic [2:0] m;
  logic [7:0] d;

  assign {d, rs, wr_n, rd_n, cs_n, latch, b, a, m, clk_en, reset} = stim;
  assign dut_edge = 1'b0;
  assign fast_edge = 1'b0;

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
      .asleep_i(1'b0),
      .cs_ni(cs_n),
      .rd_ni(rd_n),
      .wr_ni(wr_n),
      .rs_i(rs),
      .d_i(d),
      .d_o(dut_d),
      .d_oe_o(dut_oe),
      .count_o(dut_count),
      .illegal_o(dut_illegal),
      .extra_i(16'd0),
      .horizon_o()
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
      .asleep_i(1'b0),
      .cs_ni(cs_n),
      .rd_ni(rd_n),
      .wr_ni(wr_n),
      .rs_i(rs),
      .d_i(d),
      .d_o(filter_d),
      .d_oe_o(filter_oe),
      .count_o(filter_count),
      .illegal_o(filter_illegal),
      .extra_i(16'd0),
      .horizon_o()
  );

  assign filter_resp = {filter_illegal, filter_count, filter_oe, filter_d};

  logic [7:0] fast_d;
  logic [15:0] fast_count;
  logic fast_oe, fast_illegal;

  thct2000 #(
      .Skip(1'b1)
  ) u_fast (
      .clk_i(fast_clk),
      .rst_ni,
      .reset_i(reset),
      .clk_en_i(clk_en),
      .m_i(m),
      .a_i(a),
      .b_i(b),
      .latch_i(latch),
      .asleep_i(1'b0),
      .cs_ni(cs_n),
      .rd_ni(rd_n),
      .wr_ni(wr_n),
      .rs_i(rs),
      .d_i(d),
      .d_o(fast_d),
      .d_oe_o(fast_oe),
      .count_o(fast_count),
      .illegal_o(fast_illegal),
      .extra_i(extra),
      .horizon_o(horizon)
  );

  assign fast_resp = {fast_illegal, fast_count, fast_oe, fast_d};
endmodule

`default_nettype wire
