// SPDX-License-Identifier: Apache-2.0
// The VMEbus adaptor: the neutral core with a VME front. §4.3
`default_nettype none

module adaptor_vme #(
  parameter int ClkHz = 8_000_000,
  parameter logic [4:0] BaseA15A11 = 5'b01100,
  parameter int IrqLevel = 5,
  parameter int AckLevel = 5,
  parameter int SysClkMHz = 8,
  parameter int SclockDrq = 3,
  parameter int PanicIrq = 7,
  parameter int CmdNs = 500,
  parameter int IochrdyLimitClks = 10,
  parameter bit RandomPowerUp = 1'b0
) (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  // VME
  input  wire logic [15:1] vme_a_i,
  input  wire logic [ 5:0] vme_am_i,
  input  wire logic        vme_as_ni,
  input  wire logic [ 1:0] vme_ds_ni,
  input  wire logic        vme_write_ni,
  input  wire logic        vme_lword_ni,
  input  wire logic [ 7:0] vme_d_i,
  output logic      [ 7:0] vme_d_o,
  output logic             vme_d_oe_o,
  output logic             vme_dtack_no,
  input  wire logic        vme_iack_ni,
  input  wire logic        vme_iackin_ni,
  output logic             vme_iackout_no,
  output logic      [ 7:1] vme_irq_no,
  input  wire logic        vme_sysreset_ni,
  // Safety and lights
  input  wire logic        estop_closed_i,
  input  wire logic        cable_ok_i,
  input  wire logic        pc_power_i,
  output logic             panic_o,
  output logic             brake_release_o,
  output logic             alive_o,
  output logic             sclock_o,
  output logic             led_irq_o,
  // PC bus
  output logic      [15:0] pc_a_o,
  output logic             pc_aen_o,
  output logic      [ 7:0] pc_d_o,
  output logic             pc_d_oe_o,
  output logic             pc_ior_no,
  output logic             pc_iow_no,
  output logic             pc_clk_en_o,
  output logic             pc_reset_drv_o,
  output logic      [ 3:1] pc_drq_o,
  output logic             pc_power_o,
  input  wire logic [ 7:0] pc_d_i,
  input  wire logic        pc_wait_i,
  input  wire logic [ 7:3] pc_irq_i
);

  logic hp_req, hp_write, hp_ack;
  logic [10:1] hp_a;
  logic [7:0] hp_wdata, hp_rdata, vector;
  logic sys_reset, irq_req, slave_d_oe, slave_dtack, int_d_oe, int_dtack;

  vme_slave #(
    .BaseA15A11(BaseA15A11)
  ) u_bus_slave (
    .clk_i, .rst_ni,
    .sys_reset_i(sys_reset),
    .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni, .vme_iack_ni,
    .vme_d_i,
    .d_oe_o(slave_d_oe),
    .dtack_o(slave_dtack),
    .hp_req_o(hp_req),
    .hp_write_o(hp_write),
    .hp_a_o(hp_a),
    .hp_wdata_o(hp_wdata),
    .hp_ack_i(hp_ack)
  );

  vme_interrupter #(
    .IrqLevel(IrqLevel),
    .AckLevel(AckLevel)
  ) u_bus_interrupter (
    .clk_i, .rst_ni,
    .sys_reset_i(sys_reset),
    .irq_req_i(irq_req),
    .vme_a_i(vme_a_i[3:1]),
    .vme_as_ni, .vme_ds_ni, .vme_iack_ni, .vme_iackin_ni, .vme_iackout_no, .vme_irq_no,
    .d_oe_o(int_d_oe),
    .dtack_o(int_dtack)
  );

  adaptor_core #(
    .ClkHz(ClkHz),
    .SysClkMHz(SysClkMHz),
    .SclockDrq(SclockDrq),
    .PanicIrq(PanicIrq),
    .CmdNs(CmdNs),
    .IochrdyLimitClks(IochrdyLimitClks),
    .RandomPowerUp(RandomPowerUp)
  ) u_core (
    .clk_i, .rst_ni,
    .hp_req_i(hp_req),
    .hp_write_i(hp_write),
    .hp_a_i(hp_a),
    .hp_wdata_i(hp_wdata),
    .hp_ack_o(hp_ack),
    .hp_rdata_o(hp_rdata),
    .irq_req_o(irq_req),
    .vector_o(vector),
    .sys_reset_i(~vme_sysreset_ni),
    .sys_reset_o(sys_reset),
    .estop_closed_i, .cable_ok_i, .pc_power_i, .panic_o, .brake_release_o, .alive_o,
    .sclock_o,
    .pc_a_o, .pc_aen_o, .pc_d_o, .pc_d_oe_o, .pc_ior_no, .pc_iow_no, .pc_clk_en_o,
    .pc_reset_drv_o,
    .pc_drq_o, .pc_power_o, .pc_d_i, .pc_wait_i, .pc_irq_i
  );

  assign led_irq_o = irq_req;
  assign vme_dtack_no = ~(slave_dtack | int_dtack);
  assign vme_d_oe_o = slave_d_oe | int_d_oe;
  assign vme_d_o = int_d_oe ? vector : (slave_d_oe ? hp_rdata : 8'hFF);

endmodule

`default_nettype wire
