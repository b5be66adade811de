// SPDX-License-Identifier: Apache-2.0
// A/D, D/A and one-shot under replayed pins, side by side on one clock.
`default_nettype none

module bench_analog #(
    parameter int ConvClks = 200,
    parameter int PulseClks = 20
) (
    input wire clk_i,
    input wire rst_ni,
    // replay
    input wire go_i,
    input wire [31:0] id_i,
    input wire [31:0] length_i,
    input wire [3:0] pick_i,  // bit 0 lock-step
    output wire done_o
);
  localparam int InBits = 42;
  localparam int OutBits = 27;
  localparam int EdgeBits = 1;
  localparam logic [InBits-1:0] Idle = {2'b10, 12'h000, 4'hF, 1'b1, 16'h0000, 7'b0010110};

  logic [InBits-1:0] replay_stim, lock_stim, stim;
  logic [OutBits-1:0] dut_resp, fast_resp;
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
      .resp_i(dut_resp),
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

  // A/D
  logic ce, ad_cs_n, rc_n, a0, mode12, span10, hold;
  logic [15:0] vin;
  // D/A
  logic da_cs_n;
  logic [3:0] da_a_n;
  logic [11:0] da_d, code;
  // one-shot
  logic trig, clr_n;
  logic [15:0] ad_horizon, shot_horizon;

  assign {clr_n, trig, da_d, da_a_n, da_cs_n, vin, hold, span10, mode12, a0, rc_n, ad_cs_n, ce} =
      stim;
  assign horizon = ad_horizon < shot_horizon ? ad_horizon : shot_horizon;
  assign dut_edge = 1'b0;
  assign fast_edge = 1'b0;

  ad667 u_da (
      .clk_i,
      .rst_ni,
      .cs_ni(da_cs_n),
      .a_ni(da_a_n),
      .d_i(da_d),
      .code_o(code)
  );

  logic [11:0] dut_db;
  logic dut_oe, dut_sts, dut_q;

  ad574 #(
      .ConvClks(ConvClks)
  ) u_dut_ad (
      .clk_i(clk_i),
      .rst_ni,
      .ce_i(ce),
      .cs_ni(ad_cs_n),
      .rc_ni(rc_n),
      .a0_i(a0),
      .mode12_i(mode12),
      .span10_i(span10),
      .vin_i(vin),
      .hold_i(hold),
      .sts_o(dut_sts),
      .db_o(dut_db),
      .db_oe_o(dut_oe),
      .clk_free_i(1'b0),
      .due_o(),
      .extra_i(16'd0),
      .horizon_o()
  );

  oneshot #(
      .PulseClks(PulseClks)
  ) u_dut_shot (
      .clk_i(clk_i),
      .rst_ni,
      .trig_i(trig),
      .clr_ni(clr_n),
      .q_o(dut_q),
      .clk_free_i(1'b0),
      .due_o(),
      .extra_i(16'd0),
      .horizon_o()
  );

  assign dut_resp = {dut_q, code, dut_sts, dut_oe, dut_db};

  logic [11:0] fast_db;
  logic fast_oe, fast_sts, fast_q;

  ad574 #(
      .Skip(1'b1),
      .ConvClks(ConvClks)
  ) u_fast_ad (
      .clk_i(fast_clk),
      .rst_ni,
      .ce_i(ce),
      .cs_ni(ad_cs_n),
      .rc_ni(rc_n),
      .a0_i(a0),
      .mode12_i(mode12),
      .span10_i(span10),
      .vin_i(vin),
      .hold_i(hold),
      .sts_o(fast_sts),
      .db_o(fast_db),
      .db_oe_o(fast_oe),
      .clk_free_i(1'b0),
      .due_o(),
      .extra_i(extra),
      .horizon_o(ad_horizon)
  );

  oneshot #(
      .Skip(1'b1),
      .PulseClks(PulseClks)
  ) u_fast_shot (
      .clk_i(fast_clk),
      .rst_ni,
      .trig_i(trig),
      .clr_ni(clr_n),
      .q_o(fast_q),
      .clk_free_i(1'b0),
      .due_o(),
      .extra_i(extra),
      .horizon_o(shot_horizon)
  );

  assign fast_resp = {fast_q, code, fast_sts, fast_oe, fast_db};
endmodule

`default_nettype wire
