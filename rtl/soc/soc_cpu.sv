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
  input  wire logic        irq_software_i,
  output logic             sleep_o         // in WFI, nothing is under way
);

  /* verilator lint_off PINCONNECTEMPTY */  // no debugger, no integrity codes, no alerts
  ibex_top #(
    .RV32M(ibex_pkg::RV32MSingleCycle),
    .RegFile(ibex_pkg::RegFileFPGA),
    .BranchTargetALU(1'b1)
  ) u_ibex (
    .clk_i,
    .rst_ni,
    .test_en_i(1'b0),
    .ram_cfg_i('0),
    .hart_id_i('0),
    .boot_addr_i('0),
    .instr_req_o,
    .instr_gnt_i(instr_req_o),
    .instr_rvalid_i,
    .instr_addr_o,
    .instr_rdata_i,
    .instr_rdata_intg_i('0),
    .instr_err_i,
    .data_req_o,
    .data_gnt_i,
    .data_rvalid_i,
    .data_we_o,
    .data_be_o,
    .data_addr_o,
    .data_wdata_o,
    .data_wdata_intg_o(),
    .data_rdata_i,
    .data_rdata_intg_i('0),
    .data_err_i,
    .irq_software_i,
    .irq_timer_i(1'b0),
    .irq_external_i,
    .irq_fast_i('0),
    .irq_nm_i(1'b0),
    .scramble_key_valid_i(1'b0),
    .scramble_key_i('0),
    .scramble_nonce_i('0),
    .scramble_req_o(),
    .debug_req_i(1'b0),
    .crash_dump_o(),
    .double_fault_seen_o(),
    .fetch_enable_i(ibex_pkg::IbexMuBiOn),
    .alert_minor_o(),
    .alert_major_internal_o(),
    .alert_major_bus_o(),
    .core_sleep_o(sleep_o),
    .scan_rst_ni(1'b1)
  );
  /* verilator lint_on PINCONNECTEMPTY */

endmodule

`default_nettype wire
