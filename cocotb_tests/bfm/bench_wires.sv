// SPDX-License-Identifier: Apache-2.0
// Buses without a design: both ends are the models under test.
`default_nettype none

module bench_wires (
  input  wire logic        clk_i,
  // VMEbus of 32 lines, its chain of three places
  input  wire logic [31:1] a,
  input  wire logic [ 5:0] am,
  input  wire logic        as_n,
  input  wire logic [ 1:0] ds_n,
  input  wire logic        write_n,
  input  wire logic        lword_n,
  input  wire logic [31:0] d,
  input  wire logic [31:0] q,
  input  wire logic        q_oe,
  input  wire logic        dtack_n,
  input  wire logic        berr_n,
  input  wire logic        iack_n,
  input  wire logic        iackin_n,
  input  wire logic        chain1_n,
  input  wire logic        iackout_n,
  input  wire logic [ 7:1] irq_n,
  // PC bus, as a card has it
  input  wire logic [15:0] pc_a_i,
  input  wire logic        pc_aen_i,
  input  wire logic        pc_ior_ni,
  input  wire logic        pc_iow_ni,
  input  wire logic [ 7:0] pc_d_i,
  input  wire logic [ 7:0] pc_d_o,
  input  wire logic        pc_d_oe_o,
  input  wire logic        pc_iochrdy_o,
  input  wire logic [ 4:0] pc_irq_o,
  // Encoders and channels of three axes
  input  wire logic [ 2:0] enc_a,
  input  wire logic [ 2:0] enc_b,
  input  wire logic [ 2:0] enc_i,
  input  wire logic [47:0] volts
);

endmodule

`default_nettype wire
