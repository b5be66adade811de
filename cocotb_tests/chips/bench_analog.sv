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
    input wire [1:0] pick_i,  // nothing to pick
    output wire done_o
);
  localparam int InBits = 41;
  localparam int OutBits = 27;
  localparam logic [InBits-1:0] Idle = {2'b10, 12'h000, 4'hF, 1'b1, 16'h0000, 6'b010110};

  logic [InBits-1:0] stim;
  logic [OutBits-1:0] dut_resp;

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
      .resp_i(dut_resp),
      .done_o
  );

  // A/D
  logic ce, ad_cs_n, rc_n, a0, mode12, span10;
  logic [15:0] vin;
  // D/A
  logic da_cs_n;
  logic [3:0] da_a_n;
  logic [11:0] da_d, code;
  // one-shot
  logic trig, clr_n;

  assign {clr_n, trig, da_d, da_a_n, da_cs_n, vin, span10, mode12, a0, rc_n, ad_cs_n, ce} =
      stim;

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
      .sts_o(dut_sts),
      .db_o(dut_db),
      .db_oe_o(dut_oe)
  );

  oneshot #(
      .PulseClks(PulseClks)
  ) u_dut_shot (
      .clk_i(clk_i),
      .rst_ni,
      .trig_i(trig),
      .clr_ni(clr_n),
      .q_o(dut_q)
  );

  assign dut_resp = {dut_q, code, dut_sts, dut_oe, dut_db};
endmodule

`default_nettype wire
