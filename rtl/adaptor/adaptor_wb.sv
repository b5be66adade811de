// SPDX-License-Identifier: Apache-2.0
// A Wishbone B4 front at the adaptor's host port, classic or pipelined. §4.2.1
//
// DataWidth 32: a word or its lowest byte; 8: bytes as on VME. Anything else, and what lies outside
// the window, ends in ERR. A cycle that the master gives up is finished at the host port unanswered.
`default_nettype none
`include "mmcs_assert.svh"

module adaptor_wb #(
  parameter bit Pipelined = 1'b0,
  parameter int DataWidth = 32,
  parameter int AddrWidth = 16
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_ni,
  // Wishbone
  input  wire logic                   wb_cyc_i,
  input  wire logic                   wb_stb_i,
  input  wire logic                   wb_we_i,
  input  wire logic [AddrWidth-1:0]   wb_adr_i,   // in bytes
  input  wire logic [DataWidth/8-1:0] wb_sel_i,
  input  wire logic [DataWidth-1:0]   wb_dat_i,
  output logic      [DataWidth-1:0]   wb_dat_o,
  output logic                        wb_ack_o,
  output logic                        wb_err_o,
  output logic                        wb_stall_o,
  // Host port
  output logic                        hp_req_o,
  output logic                        hp_write_o,
  output logic      [           10:1] hp_a_o,
  output logic      [            7:0] hp_wdata_o,
  input  wire logic                   hp_ack_i,
  input  wire logic [            7:0] hp_rdata_i,
  input  wire logic [            7:0] vector_i
);

  logic start, ready, done, outside, width;
  logic wanted_d, wanted_q;  // the master has not given up the access under way
  logic [7:0] rdata;

  // Classic: STB stays until the answer, whose own clock starts nothing.
  assign start = wb_cyc_i & wb_stb_i & ready;

  reg_window #(
    .DataWidth(DataWidth),
    .AddrWidth(AddrWidth)
  ) u_window (
    .clk_i, .rst_ni,
    .start_i(start),
    .ready_o(ready),
    .write_i(wb_we_i),
    .a_i(wb_adr_i),
    .sel_i(wb_sel_i),
    .wdata_i(wb_dat_i[7:0]),
    .done_o(done),
    .outside_o(outside),
    .width_o(width),
    .rdata_o(rdata),
    .hp_req_o, .hp_write_o, .hp_a_o, .hp_wdata_o, .hp_ack_i, .hp_rdata_i,
    .vector_i
  );

  // Classic: the strobe, too, must stand all the time; pipelined it goes when it is accepted.
  assign wanted_d = start | (wanted_q & wb_cyc_i & (Pipelined | wb_stb_i));

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) wanted_q <= 1'b0;
    else wanted_q <= wanted_d;
  end

  logic answer;
  assign answer = done & wanted_q & wb_cyc_i & (Pipelined | wb_stb_i);
  assign wb_ack_o = answer & ~outside & ~width;
  assign wb_err_o = answer & (outside | width);
  assign wb_stall_o = Pipelined ? ~ready : wb_cyc_i & wb_stb_i & ~answer;
  assign wb_dat_o = DataWidth'(rdata);

  if (DataWidth > 8) begin : g_rest
    logic unused;
    assign unused = ^wb_dat_i[DataWidth-1:8];
  end

  `MMCS_ASSERT(OneAnswer, !(wb_ack_o && wb_err_o), "an access is acknowledged or refused")

endmodule

`default_nettype wire
