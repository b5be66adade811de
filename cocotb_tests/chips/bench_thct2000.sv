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

  logic reset, clk_en, a, b, latch, other, cs_n, rd_n, wr_n, rs;
  logic [2:0] m;
  logic [7:0] d;

  assign {other, d, rs, wr_n, rd_n, cs_n, latch, b, a, m, clk_en, reset} = stim;

  for (genvar v = 0; v < 2; v++) begin : g_part
    thct2000 #(
        .Filter(2 * v)
    ) u_part (
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
        .d_o(resp[v][7:0]),
        .d_oe_o(resp[v][8]),
        .count_o(resp[v][24:9]),
        .illegal_o(resp[v][25])
    );
  end
endmodule

`default_nettype wire
