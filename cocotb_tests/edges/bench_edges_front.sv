// SPDX-License-Identifier: Apache-2.0
// The VME front alone, at any clock: the slave, its host port answered after some clocks, and the
// interrupter.
`timescale 1ps/1ps
`default_nettype none

module bench_edges_front (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic [15:0] window_i,    // of metastability, ps
  input  wire logic [ 4:0] delay_i,     // clocks of the host port
  input  wire logic        request_i,
  input  wire logic [15:1] a_i,
  input  wire logic [ 5:0] am_i,
  input  wire logic        as_ni,
  input  wire logic [ 1:0] ds_ni,
  input  wire logic        write_ni,
  input  wire logic        lword_ni,
  input  wire logic [ 7:0] d_i,
  input  wire logic        iack_ni,
  input  wire logic        iackin_ni,
  output logic             hp_req_o,
  output logic             hp_write_o,
  output logic      [10:1] hp_a_o,
  output logic      [ 7:0] hp_wdata_o,
  output logic             hp_ack_o,
  output logic      [ 1:0] d_oe_o,      // slave, interrupter
  output logic      [ 1:0] dtack_o,
  output logic             iackout_no
);

  logic [4:0] left_q;
  logic req_q;

  assign hp_ack_o = hp_req_o && left_q == '0;
  always_comb metastable_pkg::window = int'(window_i);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      left_q <= '0;
      req_q  <= 1'b0;
    end else begin
      left_q <= hp_req_o ? left_q - 5'd1 : delay_i;
      req_q  <= request_i;
    end
  end

  vme_slave u_slave (
    .clk_i, .rst_ni,
    .sys_reset_i(1'b0),
    .vme_a_i(a_i), .vme_am_i(am_i), .vme_as_ni(as_ni), .vme_ds_ni(ds_ni), .vme_write_ni(write_ni),
    .vme_lword_ni(lword_ni), .vme_iack_ni(iack_ni), .vme_d_i(d_i),
    .d_oe_o(d_oe_o[0]),
    .dtack_o(dtack_o[0]),
    .hp_req_o, .hp_write_o, .hp_a_o, .hp_wdata_o,
    .hp_ack_i(hp_ack_o)
  );

  /* verilator lint_off PINCONNECTEMPTY */
  vme_interrupter u_interrupter (
    .clk_i, .rst_ni,
    .sys_reset_i(1'b0),
    .irq_req_i(req_q),
    .vme_a_i(a_i[3:1]), .vme_as_ni(as_ni), .vme_ds_ni(ds_ni), .vme_iack_ni(iack_ni),
    .vme_iackin_ni(iackin_ni), .vme_iackout_no(iackout_no), .vme_irq_no(),
    .d_oe_o(d_oe_o[1]),
    .dtack_o(dtack_o[1])
  );
  /* verilator lint_on PINCONNECTEMPTY */

endmodule

`default_nettype wire
