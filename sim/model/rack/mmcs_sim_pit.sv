// SPDX-License-Identifier: Apache-2.0
// The timer chip of the adaptor as a model of its own, cascaded as adaptor_core wires it. §4.3.4

`default_nettype none

module mmcs_sim_pit #(
    parameter int ClkHz     = 8_000_000,
    parameter int SysClkMHz = 8,
    parameter bit Skip      = 1'b1
) (
    input  wire logic        clk_i,
    input  wire logic        rst_ni,
    input  wire logic        cs_ni,
    input  wire logic        rd_ni,
    input  wire logic        wr_ni,
    input  wire logic [ 1:0] a_i,
    input  wire logic [ 7:0] d_i,
    output logic      [ 7:0] d_o,
    output logic      [ 2:0] out_o,
    input  wire logic [15:0] extra_i,
    output logic      [15:0] horizon_o
);

  logic sys_rise, sys_fall;
  logic out0_rise, out0_fall, out1_rise, out1_fall;
  logic [15:0] horizon;

  sysclk #(
    .ClkHz(ClkHz),
    .SysClkMHz(SysClkMHz)
  ) u_sysclk (
    .clk_i,
    .rst_ni,
    .rise_o(sys_rise),
    .fall_o(sys_fall)
  );

  /* verilator lint_off PINCONNECTEMPTY */
  i8254 #(
    .Skip(Skip)
  ) u_pit (
    .clk_i,
    .rst_ni,
    .cs_ni,
    .rd_ni,
    .wr_ni,
    .a_i,
    .d_i,
    .d_o,
    .d_oe_o(),
    .clk0_rise_i(sys_rise),
    .clk0_fall_i(sys_fall),
    .clk1_rise_i(out0_rise),
    .clk1_fall_i(out0_fall),
    .clk2_rise_i(out1_rise),
    .clk2_fall_i(out1_fall),
    .gate_i(3'b111),
    .out_o,
    .out0_rise_o(out0_rise),
    .out0_fall_o(out0_fall),
    .out1_rise_o(out1_rise),
    .out1_fall_o(out1_fall),
    .out2_rise_o(),
    .out2_fall_o(),
    .clk_free_i(clk_i),
    .awake_o(),
    .extra_i,
    .horizon_o(horizon)
  );
  /* verilator lint_on PINCONNECTEMPTY */

  // A divided system clock moves at its own pace: no skipping.
  assign horizon_o = ClkHz == SysClkMHz * 1_000_000 ? horizon : 16'd1;

endmodule

`default_nettype wire
