// SPDX-License-Identifier: Apache-2.0
// The adaptor on a real VMEbus, and master of a real PC bus: a top by pins. §4.2, §4.3
//
// VME. Data come in by receivers that are always on: write data of the next cycle may be there 30 ns
// after the strobes of a read, too early for a transceiver to turn. Data go out by a 74xx645 or ABT
// whose direction is fixed and whose OE# is vme_d_oe_n. D15-D08 have neither pin nor driver. DTACK*
// and IRQ* are open-collector: 74xx125 (64 mA) with the input at ground and OE# at these pins, which
// are high, by a resistor, until the FPGA is configured. BERR* is never driven: it is the bus timer's.
`default_nettype none
`include "mmcs_require.svh"

module vme_adaptor #(
  parameter int ClkHz = 24_000_000,
  parameter int IrqLevel = 5,
  parameter int AckLevel = 5
) (
  input  wire logic        clk,
  input  wire logic        rst_n,          // power is good
  // VMEbus, P1
  input  wire logic [15:1] vme_a,
  input  wire logic [ 5:0] vme_am,
  input  wire logic        vme_as_n,
  input  wire logic        vme_ds0_n,
  input  wire logic        vme_ds1_n,
  input  wire logic        vme_write_n,
  input  wire logic        vme_lword_n,
  input  wire logic        vme_iack_n,
  input  wire logic        vme_iackin_n,
  input  wire logic        vme_sysreset_n,
  input  wire logic [ 7:0] vme_d_rx,       // D07-D00, from the receivers
  output logic      [ 7:0] vme_d_tx,       // D07-D00, to the drivers
  output logic             vme_d_oe_n,
  output logic             vme_dtack_oe_n, // low pulls DTACK*
  output logic      [ 7:1] vme_irq_oe_n,   // low pulls IRQ*
  output logic             vme_iackout_n,
  // PC bus
  output logic      [15:0] pc_a,
  output logic             pc_ale,
  output logic             pc_aen,
  inout  wire       [ 7:0] pc_d,
  output logic             pc_d_dir,
  output logic             pc_d_oe_n,
  output logic             pc_ior_n,
  output logic             pc_iow_n,
  output logic             pc_clk,
  output logic             pc_reset_drv,
  output logic      [ 3:1] pc_drq,
  input  wire logic        pc_iochrdy,
  input  wire logic [ 7:3] pc_irq,
  // Safety; pulled up on the board, so that what is open is PANIC
  input  wire logic        estop_n,        // low while the loop is closed
  input  wire logic        cable_n,        // low while the cable is in
  input  wire logic        pc_power,       // high while the PC side has power
  output logic             brake_release,
  output logic             alive,
  output logic             led_panic,
  output logic             led_sclock,
  output logic             led_irq
);

  localparam int ClkNs = 1_000_000_000 / ClkHz;

  `MMCS_REQUIRE(ReqClkHz, ClkHz >= 24_000_000,
                "vme_adaptor: ClkHz must be 24 MHz or more: ALE falls within the set-up")

  logic rst_n_q, d_oe, dtack_n;
  logic [7:1] irq_n;
  logic [15:0] a;
  logic [7:0] wdata, rdata;
  logic aen, ior_n, iow_n, clk_en, reset_drv, pc_on;
  logic [3:1] drq;

  mmcs_sync u_reset (.clk_i(clk), .rst_ni(rst_n), .d_i(1'b1), .q_o(rst_n_q));

  /* verilator lint_off PINCONNECTEMPTY */  // the pins' own transceiver knows its direction
  adaptor_vme #(
    .ClkHz(ClkHz),
    .IrqLevel(IrqLevel),
    .AckLevel(AckLevel),
    .CmdNs(500 + 3 * ClkNs)   // from a card's command to its data: 500 ns, as without pins
  ) u_adaptor (
    .clk_i(clk), .rst_ni(rst_n_q),
    .vme_a_i(vme_a), .vme_am_i(vme_am), .vme_as_ni(vme_as_n), .vme_ds_ni({vme_ds1_n, vme_ds0_n}),
    .vme_write_ni(vme_write_n), .vme_lword_ni(vme_lword_n), .vme_d_i(vme_d_rx), .vme_d_o(vme_d_tx),
    .vme_d_oe_o(d_oe), .vme_dtack_no(dtack_n), .vme_iack_ni(vme_iack_n),
    .vme_iackin_ni(vme_iackin_n), .vme_iackout_no(vme_iackout_n), .vme_irq_no(irq_n),
    .vme_sysreset_ni(vme_sysreset_n),
    .estop_closed_i(~estop_n), .cable_ok_i(~cable_n), .pc_power_i(pc_power),
    .panic_o(led_panic), .brake_release_o(brake_release), .alive_o(alive), .sclock_o(led_sclock),
    .led_irq_o(led_irq),
    .pc_a_o(a), .pc_aen_o(aen), .pc_d_o(wdata), .pc_d_oe_o(), .pc_ior_no(ior_n), .pc_iow_no(iow_n),
    .pc_clk_en_o(clk_en), .pc_reset_drv_o(reset_drv), .pc_drq_o(drq), .pc_power_o(pc_on),
    .pc_d_i(rdata), .pc_wait_i(~pc_iochrdy), .pc_irq_i(pc_irq)
  );
  /* verilator lint_on PINCONNECTEMPTY */

  assign vme_d_oe_n = ~d_oe;
  assign vme_dtack_oe_n = dtack_n;
  assign vme_irq_oe_n = irq_n;

  pcbus_pins u_pins (
    .clk_i(clk), .rst_ni(rst_n_q),
    .a_i(a), .aen_i(aen), .d_i(wdata), .d_o(rdata), .ior_ni(ior_n), .iow_ni(iow_n),
    .clk_en_i(clk_en), .reset_drv_i(reset_drv), .drq_i(drq),
    .pc_a, .pc_ale, .pc_aen, .pc_d, .pc_d_dir, .pc_d_oe_n, .pc_ior_n, .pc_iow_n, .pc_clk,
    .pc_reset_drv, .pc_drq
  );

  logic unused;
  assign unused = pc_on;

endmodule

`default_nettype wire
