// SPDX-License-Identifier: Apache-2.0
// The adaptor in a backplane, between other interrupters of the IACK* chain, each with a clock of
// its own. The sweep drives every line; it carries IACKOUT* to the next board itself.
`default_nettype none

module bench_edges_vme (
  input  wire logic        clk_i,
  input  wire logic [ 2:0] clk_other_i,
  input  wire logic        rst_ni,
  input  wire logic [15:1] a_i,
  input  wire logic [ 5:0] am_i,
  input  wire logic        as_ni,
  input  wire logic [ 1:0] ds_ni,
  input  wire logic        write_ni,
  input  wire logic        lword_ni,
  input  wire logic [ 7:0] d_i,
  input  wire logic        iack_ni,
  input  wire logic        sysreset_ni,
  input  wire logic        estop_closed_i,
  input  wire logic        cable_ok_i,
  input  wire logic        pc_power_i,
  input  wire logic [ 7:0] pc_d_i,
  input  wire logic        pc_wait_i,
  input  wire logic [ 7:3] pc_irq_i,
  // Boards in the order of the chain: level 5 before us, we, levels 3 and 5 behind us
  input  wire logic [ 3:0] iackin_ni,
  input  wire logic [ 2:0] req_i,       // of the others
  output logic      [ 3:0] iackout_no,
  output logic      [ 3:0] dtack_o,
  output logic      [ 3:0] d_oe_o,
  output logic      [ 7:0] d_o,
  output logic             irq_o,
  output logic             panic_o,
  output logic             brake_o,
  output logic             sclock_o,
  output logic      [15:0] pc_a_o,
  output logic      [ 7:0] pc_d_o,
  output logic             pc_ior_no,
  output logic             pc_iow_no,
  output logic             pc_reset_drv_o
);

  logic dtack_n;
  assign dtack_o[1] = ~dtack_n;

  /* verilator lint_off PINCONNECTEMPTY */
  adaptor_vme u_adaptor (
    .clk_i, .rst_ni,
    .vme_a_i(a_i), .vme_am_i(am_i), .vme_as_ni(as_ni), .vme_ds_ni(ds_ni), .vme_write_ni(write_ni),
    .vme_lword_ni(lword_ni), .vme_d_i(d_i), .vme_d_o(d_o), .vme_d_oe_o(d_oe_o[1]),
    .vme_dtack_no(dtack_n), .vme_iack_ni(iack_ni), .vme_iackin_ni(iackin_ni[1]),
    .vme_iackout_no(iackout_no[1]), .vme_irq_no(), .vme_sysreset_ni(sysreset_ni),
    .estop_closed_i, .cable_ok_i, .pc_power_i, .panic_o, .brake_release_o(brake_o),
    .alive_o(), .sclock_o,
    .led_irq_o(irq_o), .pc_a_o, .pc_aen_o(), .pc_d_o, .pc_d_oe_o(), .pc_ior_no, .pc_iow_no,
    .pc_clk_en_o(),
    .pc_reset_drv_o, .pc_drq_o(), .pc_power_o(), .pc_d_i, .pc_wait_i, .pc_irq_i
  );

  for (genvar n = 0; n < 3; n++) begin : g_other
    localparam int Place = n == 0 ? 0 : n + 1;
    vme_interrupter #(
      .IrqLevel(n == 1 ? 3 : 5),
      .AckLevel(n == 1 ? 3 : 5)
    ) u_board (
      .clk_i(clk_other_i[n]), .rst_ni,
      .sys_reset_i(~sysreset_ni),
      .irq_req_i(req_i[n]),
      .vme_a_i(a_i[3:1]), .vme_as_ni(as_ni), .vme_ds_ni(ds_ni), .vme_iack_ni(iack_ni),
      .vme_iackin_ni(iackin_ni[Place]), .vme_iackout_no(iackout_no[Place]), .vme_irq_no(),
      .d_oe_o(d_oe_o[Place]),
      .dtack_o(dtack_o[Place])
    );
  end
  /* verilator lint_on PINCONNECTEMPTY */

endmodule

`default_nettype wire
