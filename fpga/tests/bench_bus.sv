// SPDX-License-Identifier: Apache-2.0
// The adaptor on a VMEbus, two cards on its PC bus, each behind its transceivers and with its own
// clock. `fights_o` counts places where two drivers meet.
// With BENCH_NETLIST both tops are what was synthesised: flat, their parameters chosen already.
`default_nettype none

`ifdef BENCH_NETLIST
  `define CARD isa_mark1
  `define PINS_D u_adaptor.\u_pins.d_q
  `define PINS_DRIVE u_adaptor.\u_pins.drive
`else
  `define CARD isa_mark1 #(.HeartbeatUs(400))
  `define PINS_D u_adaptor.u_pins.d_q
  `define PINS_DRIVE u_adaptor.u_pins.drive
`endif

module bench_bus (
  input  wire logic        clk_i,
  input  wire logic        rst_ni,
  input  wire logic [ 1:0] card_clk_i,
  input  wire logic [15:1] vme_a_i,
  input  wire logic [ 5:0] vme_am_i,
  input  wire logic        vme_as_ni,
  input  wire logic [ 1:0] vme_ds_ni,
  input  wire logic        vme_write_ni,
  input  wire logic        vme_lword_ni,
  input  wire logic [15:0] vme_d_i,
  output logic      [15:0] vme_d_o,
  output logic             vme_d_oe_o,
  output logic             vme_dtack_no,
  input  wire logic        vme_iack_ni,
  input  wire logic        vme_iackin_ni,
  output logic             vme_iackout_no,
  output logic      [ 7:1] vme_irq_no,
  input  wire logic        vme_sysreset_ni,
  input  wire logic        estop_closed_i,
  input  wire logic        cable_ok_i,
  input  wire logic        pc_power_i,
  output logic             brake_release_o,
  output logic             panic_o,
  input  wire logic [ 1:0] enc_a_i,
  input  wire logic [ 1:0] enc_b_i,
  // PC bus
  output logic      [15:0] pc_a_o,
  output logic      [ 7:0] pc_d_o,
  output logic             pc_ale_o,
  output logic             pc_clk_o,
  output logic             pc_ior_no,
  output logic             pc_iow_no,
  output logic      [ 2:0] dir_o,      // adaptor, card 0, card 1
  output logic      [ 2:0] oe_no,
  output logic      [ 4:0] fights_o,   // bus, each FPGA's side, VME
  output logic      [ 2:0] driven_o    // on the PC bus
);

  // --- adaptor ----------------------------------------------------------------------------

  wire [7:0] adaptor_d;
  logic [7:0] vme_d_tx;
  logic vme_d_oe_n, dtack_oe_n, aen, reset_drv;
  logic [7:1] irq_oe_n;
  logic [3:1] drq;
  logic [7:3] pc_irq;
  logic [1:0][7:3] irq_oe;

  /* verilator lint_off PINCONNECTEMPTY */
  vme_adaptor u_adaptor (
    .clk(clk_i), .rst_n(rst_ni),
    .vme_a(vme_a_i), .vme_am(vme_am_i), .vme_as_n(vme_as_ni), .vme_ds0_n(vme_ds_ni[0]),
    .vme_ds1_n(vme_ds_ni[1]), .vme_write_n(vme_write_ni), .vme_lword_n(vme_lword_ni),
    .vme_iack_n(vme_iack_ni), .vme_iackin_n(vme_iackin_ni), .vme_sysreset_n(vme_sysreset_ni),
    .vme_d_rx(vme_d_i[7:0]), .vme_d_tx, .vme_d_oe_n, .vme_dtack_oe_n(dtack_oe_n),
    .vme_irq_oe_n(irq_oe_n), .vme_iackout_n(vme_iackout_no),
    .pc_a(pc_a_o), .pc_ale(pc_ale_o), .pc_aen(aen), .pc_d(adaptor_d), .pc_d_dir(dir_o[0]),
    .pc_d_oe_n(oe_no[0]), .pc_ior_n(pc_ior_no), .pc_iow_n(pc_iow_no), .pc_clk(pc_clk_o),
    .pc_reset_drv(reset_drv), .pc_drq(drq), .pc_iochrdy(1'b1), .pc_irq,
    .estop_n(~estop_closed_i), .cable_n(~cable_ok_i), .pc_power(pc_power_i),
    .brake_release(brake_release_o), .alive(), .led_panic(panic_o), .led_sclock(), .led_irq()
  );
  /* verilator lint_on PINCONNECTEMPTY */

  // D15-D08 have no driver; open-collector lines are pulled up.
  assign vme_d_o = {8'hFF, vme_d_oe_n ? 8'hFF : vme_d_tx};
  assign vme_d_oe_o = ~vme_d_oe_n;
  assign vme_dtack_no = dtack_oe_n;
  assign vme_irq_no = irq_oe_n;

  // --- cards ------------------------------------------------------------------------------

  logic [1:0][7:0] card_out;   // what the FPGA drives; to take it from the pins would be a loop

  for (genvar n = 0; n < 2; n++) begin : g_card
    wire [7:0] card_d;
    /* verilator lint_off PINCONNECTEMPTY */
    `CARD u_card (
      .clk(card_clk_i[n]), .rst_n(rst_ni),
      .isa_a(pc_a_o), .isa_aen(aen), .isa_ior_n(pc_ior_no), .isa_iow_n(pc_iow_no),
      .isa_reset_drv(reset_drv), .isa_d(card_d), .isa_d_dir(dir_o[n+1]), .isa_d_oe_n(oe_no[n+1]),
      .isa_drq(drq), .isa_irq_oe_n(irq_oe[n]),
      .dip(4'(n)), .enable_n(2'b00), .enc_a(enc_a_i), .enc_b(enc_b_i), .enc_i(2'b00),
      .spi_sclk(), .adc_cs_n(), .adc_din(), .adc_dout(1'b0), .dac_sync_n(), .dac_din(),
      .dac_clr_n(), .dac_ldac_n(), .led()
    );
    /* verilator lint_on PINCONNECTEMPTY */
    assign card_d = (~oe_no[n+1] & ~dir_o[n+1]) ? pc_d_o : 8'hzz;
    assign card_out[n] = u_card.rdata;
    assign fights_o[n+2] = u_card.drive & ~oe_no[n+1] & ~dir_o[n+1];
  end

  // --- PC bus -----------------------------------------------------------------------------

  assign driven_o = dir_o & ~oe_no;
  assign pc_d_o = driven_o[0] ? `PINS_D : driven_o[1] ? card_out[0]
                : driven_o[2] ? card_out[1] : 8'hFF;
  assign adaptor_d = (~oe_no[0] & ~dir_o[0]) ? pc_d_o : 8'hzz;
  assign pc_irq = ~(irq_oe[0] & irq_oe[1]);   // pulled down

  assign fights_o[0] = (driven_o & (driven_o - 1'b1)) != '0;
  assign fights_o[1] = `PINS_DRIVE & ~oe_no[0] & ~dir_o[0];
  // A master drives the data lines from 35 ns before the strobes of a write to their end.
  assign fights_o[4] = ~vme_d_oe_n & (~vme_write_ni | (&vme_ds_ni));

  logic unused;
  assign unused = ^vme_d_i[15:8];

endmodule

`default_nettype wire
