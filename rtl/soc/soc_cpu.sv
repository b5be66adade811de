// SPDX-License-Identifier: Apache-2.0
// The processor of the SoC: Ibex (RV32IM, machine mode, no caches) with everything tied off that
// is not used here. The core comes from the package pythondata-cpu-ibex, not from this folder.
//
// Both memory ports follow Ibex's protocol: a request is held until its grant, the answer comes in
// a later clock. Interrupts are the standard ones of the privileged architecture.
`default_nettype none

module soc_cpu (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  output logic             instr_req_o,
  output logic      [31:0] instr_addr_o,
  input  wire logic        instr_rvalid_i,
  input  wire logic [31:0] instr_rdata_i,
  input  wire logic        instr_err_i,
  output logic             data_req_o,
  input  wire logic        data_gnt_i,
  input  wire logic        data_rvalid_i,
  output logic             data_we_o,
  output logic      [ 3:0] data_be_o,
  output logic      [31:0] data_addr_o,
  output logic      [31:0] data_wdata_o,
  input  wire logic [31:0] data_rdata_i,
  input  wire logic        data_err_i,
  input  wire logic        irq_external_i,
  input  wire logic        irq_software_i
);

  logic [4:0] rf_raddr_a, rf_raddr_b, rf_waddr;
  logic rf_we;
  logic [31:0] rf_wdata, rf_rdata_a, rf_rdata_b;

  /* verilator lint_off PINCONNECTEMPTY */  // no debugger, no cache, no integrity codes, no alerts
  ibex_core #(
    .RV32M(ibex_pkg::RV32MSingleCycle),
    .BranchTargetALU(1'b1)
  ) u_ibex_core (  // the name that Ibex knows itself by
    .clk_i,
    .rst_ni,
    .hart_id_i('0),
    .boot_addr_i('0),
    .instr_req_o,
    .instr_gnt_i(instr_req_o),
    .instr_rvalid_i,
    .instr_addr_o,
    .instr_rdata_i,
    .instr_err_i,
    .data_req_o,
    .data_gnt_i,
    .data_rvalid_i,
    .data_we_o,
    .data_be_o,
    .data_addr_o,
    .data_wdata_o,
    .data_rdata_i,
    .data_err_i,
    .dummy_instr_id_o(),
    .dummy_instr_wb_o(),
    .rf_raddr_a_o(rf_raddr_a),
    .rf_raddr_b_o(rf_raddr_b),
    .rf_waddr_wb_o(rf_waddr),
    .rf_we_wb_o(rf_we),
    .rf_wdata_wb_ecc_o(rf_wdata),
    .rf_rdata_a_ecc_i(rf_rdata_a),
    .rf_rdata_b_ecc_i(rf_rdata_b),
    .ic_tag_req_o(),
    .ic_tag_write_o(),
    .ic_tag_addr_o(),
    .ic_tag_wdata_o(),
    .ic_tag_rdata_i('{default: '0}),
    .ic_data_req_o(),
    .ic_data_write_o(),
    .ic_data_addr_o(),
    .ic_data_wdata_o(),
    .ic_data_rdata_i('{default: '0}),
    .ic_scr_key_valid_i(1'b0),
    .ic_scr_key_req_o(),
    .irq_software_i,
    .irq_timer_i(1'b0),
    .irq_external_i,
    .irq_fast_i('0),
    .irq_nm_i(1'b0),
    .irq_pending_o(),
    .debug_req_i(1'b0),
    .crash_dump_o(),
    .double_fault_seen_o(),
    .fetch_enable_i(ibex_pkg::IbexMuBiOn),
    .alert_minor_o(),
    .alert_major_internal_o(),
    .alert_major_bus_o(),
    .core_busy_o()
  );

  ibex_register_file_fpga u_registers (
    .clk_i,
    .rst_ni,
    .test_en_i(1'b0),
    .dummy_instr_id_i(1'b0),
    .dummy_instr_wb_i(1'b0),
    .raddr_a_i(rf_raddr_a),
    .rdata_a_o(rf_rdata_a),
    .raddr_b_i(rf_raddr_b),
    .rdata_b_o(rf_rdata_b),
    .waddr_a_i(rf_waddr),
    .wdata_a_i(rf_wdata),
    .we_a_i(rf_we),
    .err_o()
  );
  /* verilator lint_on PINCONNECTEMPTY */

endmodule

`default_nettype wire
