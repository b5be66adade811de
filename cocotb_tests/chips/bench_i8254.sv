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
  logic [1:0][OutBits-1:0] resp;

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
      .resp_i(resp[pick_i[0]]),
      .done_o
  );

  logic [7:0] d;
  logic [1:0] a;
  logic cs_n, rd_n, wr_n;
  logic [2:0] rise, fall, gate;

  assign {gate, fall, rise, wr_n, rd_n, cs_n, a, d} = stim;

  for (genvar v = 0; v < 2; v++) begin : g_part
    logic rise0, fall0, rise1, fall1, rise2, fall2;

    i8254 #(
        .NmosRewrite(v == 0),
        .SplitCr(v == 0)
    ) u_part (
        .clk_i(clk_i),
        .rst_ni,
        .cs_ni(cs_n),
        .rd_ni(rd_n),
        .wr_ni(wr_n),
        .a_i(a),
        .d_i(d),
        .d_o(resp[v][7:0]),
        .d_oe_o(resp[v][8]),
        .clk0_rise_i(rise[0]),
        .clk0_fall_i(fall[0]),
        .clk1_rise_i(pick_i[1] ? rise0 : rise[1]),
        .clk1_fall_i(pick_i[1] ? fall0 : fall[1]),
        .clk2_rise_i(pick_i[1] ? rise1 : rise[2]),
        .clk2_fall_i(pick_i[1] ? fall1 : fall[2]),
        .gate_i(gate),
        .out_o(resp[v][11:9]),
        .out0_rise_o(rise0),
        .out0_fall_o(fall0),
        .out1_rise_o(rise1),
        .out1_fall_o(fall1),
        .out2_rise_o(rise2),
        .out2_fall_o(fall2)
    );

    assign resp[v][17:12] = {fall2, fall1, fall0, rise2, rise1, rise0};
  end
endmodule

`default_nettype wire
