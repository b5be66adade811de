// SPDX-License-Identifier: Apache-2.0
// The 8255A under replayed pins, with the control word write-only (8255A) and readable.
`default_nettype none

module bench_i8255 (
    input wire clk_i,
    input wire rst_ni,
    // replay
    input wire go_i,
    input wire [31:0] id_i,
    input wire [31:0] length_i,
    input wire [1:0] pick_i,  // bit 0: the part whose control word can be read
    output wire done_o
);
  logic reset, cs_n, rd_n, wr_n;
  logic [1:0] a;
  logic [7:0] d, pa, pb, pc;
  logic [1:0][56:0] resp;

  bench_replay #(
      .InBits(38),
      .OutBits(57),
      .Idle(38'hE)
  ) u_replay (
      .clk_i,
      .go_i,
      .id_i,
      .length_i,
      .stim_o({pc, pb, pa, d, a, wr_n, rd_n, cs_n, reset}),
      .resp_i(resp[pick_i[0]]),
      .done_o
  );

  for (genvar v = 0; v < 2; v++) begin : g_part
    i8255 #(
        .ControlReadable(v == 1)
    ) u_part (
        .clk_i,
        .rst_ni,
        .reset_i(reset),
        .cs_ni(cs_n),
        .rd_ni(rd_n),
        .wr_ni(wr_n),
        .a_i(a),
        .d_i(d),
        .d_o(resp[v][7:0]),
        .d_oe_o(resp[v][8]),
        .pa_i(pa),
        .pa_o(resp[v][16:9]),
        .pa_oe_o(resp[v][24:17]),
        .pb_i(pb),
        .pb_o(resp[v][32:25]),
        .pb_oe_o(resp[v][40:33]),
        .pc_i(pc),
        .pc_o(resp[v][48:41]),
        .pc_oe_o(resp[v][56:49])
    );
  end
endmodule

`default_nettype wire
