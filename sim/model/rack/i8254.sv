// SPDX-License-Identifier: Apache-2.0
// The socket of the timer chip in a rack of models: the chip is a model of its own (mmcs_sim_pit.sv),
// and the C++ side carries its pins there and back. §4.3.4
//
// What comes back are registers or, for d_o, read only at the end of a strobe.

`default_nettype none

module i8254 #(
    parameter bit          Skip        = 1'b0,
    parameter bit          Gate        = 1'b0,
    parameter bit          NmosRewrite = 1'b1,
    parameter logic [31:0] PowerUpSeed = 32'd0
) (
    input  wire logic        clk_i,
    input  wire logic        rst_ni,
    input  wire logic        cs_ni,
    input  wire logic        rd_ni,
    input  wire logic        wr_ni,
    input  wire logic [ 1:0] a_i,
    input  wire logic [ 7:0] d_i,
    output logic      [ 7:0] d_o,
    output logic             d_oe_o,
    input  wire logic        clk0_rise_i,
    input  wire logic        clk0_fall_i,
    input  wire logic        clk1_rise_i,
    input  wire logic        clk1_fall_i,
    input  wire logic        clk2_rise_i,
    input  wire logic        clk2_fall_i,
    input  wire logic [ 2:0] gate_i,
    output logic      [ 2:0] out_o,
    output logic             out0_rise_o,
    output logic             out0_fall_o,
    output logic             out1_rise_o,
    output logic             out1_fall_o,
    output logic             out2_rise_o,
    output logic             out2_fall_o,
    input  wire logic        clk_free_i,
    output logic             awake_o,
    input  wire logic [15:0] extra_i,
    output logic      [15:0] horizon_o
);
  // To the chip: {command, RD#, WR#, address, data}; 0 while it is not spoken to.
  logic [12:0] to_chip  /*verilator public_flat_rd*/;
  logic [ 7:0] from_d  /*verilator public_flat_rw*/;
  logic [ 2:0] from_out  /*verilator public_flat_rw*/;

  always_comb begin
    to_chip = '0;
    if (!cs_ni) to_chip = {1'b1, rd_ni, wr_ni, a_i, d_i};
  end

  assign d_o = from_d;
  assign d_oe_o = !cs_ni && !rd_ni;
  assign out_o = from_out;
  assign {out0_rise_o, out0_fall_o, out1_rise_o, out1_fall_o, out2_rise_o, out2_fall_o} = '0;
  assign awake_o = 1'b0;
  assign horizon_o = 16'hFFFF;
endmodule

`default_nettype wire
