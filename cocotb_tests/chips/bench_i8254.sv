// SPDX-License-Identifier: Apache-2.0
// The 8254 under replayed pins: the NMOS part and the CHMOS part.
`default_nettype none

module bench_i8254 (
    input wire clk_i,
    input wire rst_ni,
    // replay
    input wire go_i,
    input wire [31:0] id_i,
    input wire [31:0] length_i,
    input wire [1:0] pick_i,  // bit 0 CHMOS part, 1 CLK1 = OUT0 and CLK2 = OUT1
    output wire done_o
);
  localparam int InBits = 22;
  localparam int OutBits = 18;
  localparam logic [InBits-1:0] Idle = 22'h381C00;

  logic [InBits-1:0] stim;
  logic [OutBits-1:0] dut_resp, chmos_resp;

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
      .resp_i(pick_i[0] ? chmos_resp : dut_resp),
      .done_o
  );

  logic [7:0] d;
  logic [1:0] a;
  logic cs_n, rd_n, wr_n;
  logic [2:0] rise, fall, gate;

  assign {gate, fall, rise, wr_n, rd_n, cs_n, a, d} = stim;

  logic [7:0] dut_d;
  logic [2:0] dut_out;
  logic dut_rise0, dut_fall0, dut_rise1, dut_fall1, dut_rise2, dut_fall2, dut_oe;

  i8254 #(
      .NmosRewrite(1'b1)
  ) u_dut (
      .clk_i(clk_i),
      .rst_ni,
      .cs_ni(cs_n),
      .rd_ni(rd_n),
      .wr_ni(wr_n),
      .a_i(a),
      .d_i(d),
      .d_o(dut_d),
      .d_oe_o(dut_oe),
      .clk0_rise_i(rise[0]),
      .clk0_fall_i(fall[0]),
      .clk1_rise_i(pick_i[1] ? dut_rise0 : rise[1]),
      .clk1_fall_i(pick_i[1] ? dut_fall0 : fall[1]),
      .clk2_rise_i(pick_i[1] ? dut_rise1 : rise[2]),
      .clk2_fall_i(pick_i[1] ? dut_fall1 : fall[2]),
      .gate_i(gate),
      .out_o(dut_out),
      .out0_rise_o(dut_rise0),
      .out0_fall_o(dut_fall0),
      .out1_rise_o(dut_rise1),
      .out1_fall_o(dut_fall1),
      .out2_rise_o(dut_rise2),
      .out2_fall_o(dut_fall2)
  );

  assign dut_resp = {
    dut_fall2, dut_fall1, dut_fall0, dut_rise2, dut_rise1, dut_rise0, dut_out, dut_oe, dut_d
  };

  logic [7:0] chmos_d;
  logic [2:0] chmos_out;
  logic chmos_rise0, chmos_fall0, chmos_rise1, chmos_fall1, chmos_rise2, chmos_fall2, chmos_oe;

  i8254 #(
      .NmosRewrite(1'b0),
      .SplitCr(1'b0)
  ) u_chmos (
      .clk_i(clk_i),
      .rst_ni,
      .cs_ni(cs_n),
      .rd_ni(rd_n),
      .wr_ni(wr_n),
      .a_i(a),
      .d_i(d),
      .d_o(chmos_d),
      .d_oe_o(chmos_oe),
      .clk0_rise_i(rise[0]),
      .clk0_fall_i(fall[0]),
      .clk1_rise_i(pick_i[1] ? chmos_rise0 : rise[1]),
      .clk1_fall_i(pick_i[1] ? chmos_fall0 : fall[1]),
      .clk2_rise_i(pick_i[1] ? chmos_rise1 : rise[2]),
      .clk2_fall_i(pick_i[1] ? chmos_fall1 : fall[2]),
      .gate_i(gate),
      .out_o(chmos_out),
      .out0_rise_o(chmos_rise0),
      .out0_fall_o(chmos_fall0),
      .out1_rise_o(chmos_rise1),
      .out1_fall_o(chmos_fall1),
      .out2_rise_o(chmos_rise2),
      .out2_fall_o(chmos_fall2)
  );

  assign chmos_resp = {
    chmos_fall2, chmos_fall1, chmos_fall0, chmos_rise2, chmos_rise1, chmos_rise0, chmos_out,
    chmos_oe, chmos_d
  };
endmodule

`default_nettype wire
