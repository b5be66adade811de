// SPDX-License-Identifier: Apache-2.0
// An AXI4-Lite front at the adaptor's host port: one access at a time. §4.2.1
//
// Outside the window the answer is DECERR, for other than a word or its lowest byte SLVERR.
`default_nettype none
`include "mmcs_assert.svh"

module adaptor_axil #(
  parameter int AddrWidth = 16
) (
  input  wire logic                 clk_i,
  input  wire logic                 rst_ni,
  // Write
  input  wire logic [AddrWidth-1:0] s_axil_awaddr,
  input  wire logic [          2:0] s_axil_awprot,
  input  wire logic                 s_axil_awvalid,
  output logic                      s_axil_awready,
  input  wire logic [         31:0] s_axil_wdata,
  input  wire logic [          3:0] s_axil_wstrb,
  input  wire logic                 s_axil_wvalid,
  output logic                      s_axil_wready,
  output logic      [          1:0] s_axil_bresp,
  output logic                      s_axil_bvalid,
  input  wire logic                 s_axil_bready,
  // Read
  input  wire logic [AddrWidth-1:0] s_axil_araddr,
  input  wire logic [          2:0] s_axil_arprot,
  input  wire logic                 s_axil_arvalid,
  output logic                      s_axil_arready,
  output logic      [         31:0] s_axil_rdata,
  output logic      [          1:0] s_axil_rresp,
  output logic                      s_axil_rvalid,
  input  wire logic                 s_axil_rready,
  // Host port
  output logic                      hp_req_o,
  output logic                      hp_write_o,
  output logic      [         10:1] hp_a_o,
  output logic      [          7:0] hp_wdata_o,
  input  wire logic                 hp_ack_i,
  input  wire logic [          7:0] hp_rdata_i,
  input  wire logic [          7:0] vector_i
);

  localparam logic [1:0] Okay = 2'b00, SlvErr = 2'b10, DecErr = 2'b11;

  logic ready, done, outside, width, free;
  logic start_write, start_read;
  logic write_d, write_q;          // the access under way
  logic read_next_d, read_next_q;  // after a write a waiting read goes first, and the reverse
  logic bvalid_d, bvalid_q, rvalid_d, rvalid_q;
  logic [1:0] resp_d, resp_q;
  logic [7:0] rdata;

  assign free = ready & ~bvalid_q & ~rvalid_q;
  assign start_write = free & s_axil_awvalid & s_axil_wvalid & ~(s_axil_arvalid & read_next_q);
  assign start_read = free & s_axil_arvalid & ~start_write;

  reg_window #(
    .DataWidth(32),
    .AddrWidth(AddrWidth)
  ) u_window (
    .clk_i, .rst_ni,
    .start_i(start_write | start_read),
    .ready_o(ready),
    .write_i(start_write),
    .a_i(start_write ? s_axil_awaddr : s_axil_araddr),
    .sel_i(start_write ? s_axil_wstrb : 4'b1111),
    .wdata_i(s_axil_wdata[7:0]),
    .done_o(done),
    .outside_o(outside),
    .width_o(width),
    .rdata_o(rdata),
    .hp_req_o, .hp_write_o, .hp_a_o, .hp_wdata_o, .hp_ack_i, .hp_rdata_i,
    .vector_i
  );

  always_comb begin
    write_d     = write_q;
    read_next_d = read_next_q;
    if (start_write || start_read) begin
      write_d     = start_write;
      read_next_d = start_write;
    end
    bvalid_d = bvalid_q & ~s_axil_bready;
    rvalid_d = rvalid_q & ~s_axil_rready;
    resp_d   = resp_q;
    if (done) begin
      bvalid_d = write_q;
      rvalid_d = ~write_q;
      resp_d   = outside ? DecErr : width ? SlvErr : Okay;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      write_q     <= 1'b0;
      read_next_q <= 1'b0;
      bvalid_q    <= 1'b0;
      rvalid_q    <= 1'b0;
      resp_q      <= Okay;
    end else begin
      write_q     <= write_d;
      read_next_q <= read_next_d;
      bvalid_q    <= bvalid_d;
      rvalid_q    <= rvalid_d;
      resp_q      <= resp_d;
    end
  end

  assign s_axil_awready = start_write;
  assign s_axil_wready = start_write;
  assign s_axil_arready = start_read;
  assign s_axil_bvalid = bvalid_q;
  assign s_axil_bresp = resp_q;
  assign s_axil_rvalid = rvalid_q;
  assign s_axil_rresp = resp_q;
  assign s_axil_rdata = {24'h0, rdata};

  logic unused;
  assign unused = ^{s_axil_awprot, s_axil_arprot, s_axil_wdata[31:8]};

  `MMCS_ASSERT(OneResponse, !(bvalid_q && rvalid_q), "one access at a time has one response")

endmodule

`default_nettype wire
