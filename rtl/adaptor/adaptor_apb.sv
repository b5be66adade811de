// SPDX-License-Identifier: Apache-2.0
// An APB front (AMBA 3 and 4) at the adaptor's host port. §4.2.1
//
// DataWidth 32: a word or its lowest byte; 8: bytes as on VME. Anything else, and what lies outside
// the window, ends in PSLVERR.
`default_nettype none
`include "mmcs_assert.svh"

module adaptor_apb #(
  parameter int DataWidth = 32,
  parameter int AddrWidth = 16
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_ni,
  // APB
  input  wire logic                   apb_psel,
  input  wire logic                   apb_penable,
  input  wire logic                   apb_pwrite,
  input  wire logic [AddrWidth-1:0]   apb_paddr,
  input  wire logic [            2:0] apb_pprot,
  input  wire logic [DataWidth/8-1:0] apb_pstrb,
  input  wire logic [DataWidth-1:0]   apb_pwdata,
  output logic      [DataWidth-1:0]   apb_prdata,
  output logic                        apb_pready,
  output logic                        apb_pslverr,
  // Host port
  output logic                        hp_req_o,
  output logic                        hp_write_o,
  output logic      [           10:1] hp_a_o,
  output logic      [            7:0] hp_wdata_o,
  input  wire logic                   hp_ack_i,
  input  wire logic [            7:0] hp_rdata_i,
  input  wire logic [            7:0] vector_i
);

  logic ready, done, outside, width;
  logic [7:0] rdata;

  reg_window #(
    .DataWidth(DataWidth),
    .AddrWidth(AddrWidth)
  ) u_window (
    .clk_i, .rst_ni,
    .start_i(apb_psel & apb_penable),
    .ready_o(ready),
    .write_i(apb_pwrite),
    .a_i(apb_paddr),
    .sel_i(apb_pwrite ? apb_pstrb : '1),
    .wdata_i(apb_pwdata[7:0]),
    .done_o(done),
    .outside_o(outside),
    .width_o(width),
    .rdata_o(rdata),
    .hp_req_o, .hp_write_o, .hp_a_o, .hp_wdata_o, .hp_ack_i, .hp_rdata_i,
    .vector_i
  );

  assign apb_pready = done;
  assign apb_pslverr = done & (outside | width);
  assign apb_prdata = DataWidth'(rdata);

  logic unused;
  assign unused = ^{apb_pprot, ready};
  if (DataWidth > 8) begin : g_rest
    logic unused_data;
    assign unused_data = ^apb_pwdata[DataWidth-1:8];
  end

  `MMCS_ASSERT(ErrorWithReady, !apb_pslverr || apb_pready, "an error is told with the answer")

endmodule

`default_nettype wire
