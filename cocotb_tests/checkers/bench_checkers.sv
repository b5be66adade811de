// SPDX-License-Identifier: Apache-2.0
// All bus checkers side by side, none of which ends the simulation; a test looks at one of them.
`default_nettype none

module bench_checkers (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic [15:1] vme_a_i,
  input  wire logic [ 5:0] vme_am_i,
  input  wire logic        vme_as_ni,
  input  wire logic [ 1:0] vme_ds_ni,
  input  wire logic        vme_write_ni,
  input  wire logic        vme_lword_ni,
  input  wire logic [15:0] vme_d_i,
  input  wire logic        vme_iack_ni,
  input  wire logic        vme_iackin_ni,
  input  wire logic        vme_iackout_no,
  input  wire logic        vme_sysreset_ni,
  input  wire logic [ 7:1] vme_irq_no,
  input  wire logic        vme_d_oe_o,
  input  wire logic [ 7:0] vme_d_o,
  input  wire logic        vme_dtack_no,
  input  wire logic        link_ok_i,
  input  wire logic [15:0] pc_a_i,
  input  wire logic [ 7:0] pc_d_i,
  input  wire logic [ 7:0] pc_rdata_i,
  input  wire logic        pc_ior_ni,
  input  wire logic        pc_iow_ni,
  input  wire logic        pc_aen_i,
  input  wire logic [ 3:0] drivers_i,
  input  wire logic        driven_i,
  output logic             conflict_o,
  output logic      [11:0] pcbus_checker_o,
  output logic      [ 7:0] pcbus_timing_o,
  output logic      [ 6:0] vme_claim_checker_o,
  output logic      [ 6:0] vme_edge_checker_o,
  output logic      [ 7:0] vme_master_checker_o,
  output logic      [ 7:0] vme_slave_checker_o,
  output logic      [18:0] vme_timing_o
);

  pcbus_checker #(.MaxClks(14), .Stop(1'b0)) u_pcbus_checker (.*, .broken_o(pcbus_checker_o));
  pcbus_timing #(.LongestNs(1875), .Stop(1'b0)) u_pcbus_timing (.*, .broken_o(pcbus_timing_o));
  vme_claim_checker #(.Stop(1'b0)) u_vme_claim_checker (.*, .broken_o(vme_claim_checker_o));
  vme_edge_checker #(.Stop(1'b0)) u_vme_edge_checker (.*, .broken_o(vme_edge_checker_o));
  vme_master_checker #(.Stop(1'b0)) u_vme_master_checker (.*, .broken_o(vme_master_checker_o));
  vme_slave_checker #(.Stop(1'b0)) u_vme_slave_checker (.*, .broken_o(vme_slave_checker_o));
  vme_timing #(.Stop(1'b0)) u_vme_timing (.*, .broken_o(vme_timing_o));

endmodule

`default_nettype wire
