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
  logic [56:0] dut_resp, readable_resp;

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
      .resp_i(pick_i[0] ? readable_resp : dut_resp),
      .done_o
  );

  logic [7:0] dut_d, dut_pa, dut_pa_oe, dut_pb, dut_pb_oe, dut_pc, dut_pc_oe;
  logic dut_oe;

  i8255 u_dut (
      .clk_i,
      .rst_ni,
      .reset_i(reset),
      .cs_ni(cs_n),
      .rd_ni(rd_n),
      .wr_ni(wr_n),
      .a_i(a),
      .d_i(d),
      .d_o(dut_d),
      .d_oe_o(dut_oe),
      .pa_i(pa),
      .pa_o(dut_pa),
      .pa_oe_o(dut_pa_oe),
      .pb_i(pb),
      .pb_o(dut_pb),
      .pb_oe_o(dut_pb_oe),
      .pc_i(pc),
      .pc_o(dut_pc),
      .pc_oe_o(dut_pc_oe)
  );

  assign dut_resp = {
    dut_pc_oe, dut_pc, dut_pb_oe, dut_pb, dut_pa_oe, dut_pa, dut_oe, dut_d
  };

  logic [7:0] readable_d, readable_pa, readable_pa_oe, readable_pb, readable_pb_oe;
  logic [7:0] readable_pc, readable_pc_oe;
  logic readable_oe;

  i8255 #(
      .ControlReadable(1'b1)
  ) u_readable (
      .clk_i,
      .rst_ni,
      .reset_i(reset),
      .cs_ni(cs_n),
      .rd_ni(rd_n),
      .wr_ni(wr_n),
      .a_i(a),
      .d_i(d),
      .d_o(readable_d),
      .d_oe_o(readable_oe),
      .pa_i(pa),
      .pa_o(readable_pa),
      .pa_oe_o(readable_pa_oe),
      .pb_i(pb),
      .pb_o(readable_pb),
      .pb_oe_o(readable_pb_oe),
      .pc_i(pc),
      .pc_o(readable_pc),
      .pc_oe_o(readable_pc_oe)
  );

  assign readable_resp = {
    readable_pc_oe, readable_pc, readable_pb_oe, readable_pb, readable_pa_oe, readable_pa,
    readable_oe, readable_d
  };
endmodule

`default_nettype wire
