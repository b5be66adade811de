// SPDX-License-Identifier: Apache-2.0
// Attaches the bus checkers to the machine: Verilator only, Icarus knows no bind.
//
// MMCS_NO_BUS_TIMES leaves the nanoseconds out, where pins move on clock edges only.
`default_nettype none

/* verilator lint_off PINCONNECTEMPTY */
bind mmcs vme_slave_checker u_vme_checker (
  .clk_i, .rst_ni, .vme_ds_ni, .vme_iack_ni, .vme_write_ni, .vme_iackout_no, .vme_sysreset_ni,
  .vme_d_oe_o, .vme_dtack_no,
  .vme_d_o(vme_d_o[7:0]),
  .broken_o()
);

bind mmcs vme_claim_checker #(
  .BaseA15A11(BaseA15A11),
  .IrqLevel(IrqLevel),
  .AckLevel(AckLevel)
) u_vme_claim_checker (
  .clk_i, .rst_ni, .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_lword_ni, .vme_iack_ni,
  .vme_iackin_ni, .vme_sysreset_ni, .vme_iackout_no, .vme_irq_no, .vme_d_oe_o, .vme_dtack_no,
  .broken_o()
);

bind mmcs vme_edge_checker #(
  .BaseA15A11(BaseA15A11),
  .IrqLevel(IrqLevel),
  .AckLevel(AckLevel)
) u_vme_edge_checker (
  .rst_ni, .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_lword_ni, .vme_iack_ni,
  .vme_iackin_ni, .vme_sysreset_ni, .vme_iackout_no, .vme_d_oe_o, .vme_dtack_no,
  .broken_o()
);

bind mmcs vme_master_checker #(
  .BaseA15A11(BaseA15A11),
  .BusTimerClks(16 * (ClkHz / 1_000_000)),
  .Stop(1'b0)
) u_vme_master_checker (
  .clk_i, .rst_ni, .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni,
  .vme_iack_ni, .vme_iackin_ni, .vme_d_i, .vme_dtack_no,
  .broken_o()
);

// The link itself is the core's own business: without cable or power a command may be cut short.
bind mmcs pcbus_checker #(
  .SideClks(ClkHz / 8_000_000),
  .CmdClks((CmdNs * (ClkHz / 1_000_000) + 999) / 1000),
  .MaxClks((CmdNs * (ClkHz / 1_000_000) + 999) / 1000 + 3 +
           IochrdyLimitClks * (ClkHz / 1_000_000 / SysClkMHz)),
  .NumCards(NumCards)
) u_pcbus_checker (
  .clk_i, .rst_ni,
  .link_ok_i(cable_ok_i && pc_power_i && u_adaptor.u_core.link_ok),
  .pc_a_i(pcx_a_o),
  .pc_d_i(pcx_d_o),
  .pc_ior_ni(pcx_ior_no),
  .pc_iow_ni(pcx_iow_no),
  .pc_aen_i(pcx_aen_o),
  .drivers_i({pcx_d_oe_i, u_cards.card_d_oe}),
  .conflict_o(),
  .broken_o()
);

`ifndef MMCS_NO_BUS_TIMES
bind mmcs vme_timing u_vme_timing (
  .rst_ni, .vme_a_i, .vme_am_i, .vme_as_ni, .vme_ds_ni, .vme_write_ni, .vme_lword_ni,
  .vme_iack_ni, .vme_iackout_no, .vme_sysreset_ni, .vme_d_i, .vme_irq_no, .vme_d_oe_o,
  .vme_d_o(vme_d_o[7:0]),
  .vme_dtack_no,
  .broken_o()
);

bind mmcs pcbus_timing #(
  .CmdNs(CmdNs),
  .LongestNs(CmdNs + 375 + IochrdyLimitClks * 1000 / SysClkMHz)
) u_pcbus_timing (
  .rst_ni,
  .link_ok_i(cable_ok_i && pc_power_i && u_adaptor.u_core.link_ok),
  .pc_a_i(pcx_a_o),
  .pc_d_i(pcx_d_o),
  .pc_rdata_i(pc_rdata),
  .pc_ior_ni(pcx_ior_no),
  .pc_iow_ni(pcx_iow_no),
  .driven_i(|{pcx_d_oe_i, u_cards.card_d_oe}),
  .broken_o()
);
`endif
/* verilator lint_on PINCONNECTEMPTY */

`default_nettype wire
