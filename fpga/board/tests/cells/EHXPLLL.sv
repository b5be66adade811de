// SPDX-License-Identifier: Apache-2.0
// The PLL of an ECP5, as no tool models it: it passes its clock on.
/* verilator lint_off UNUSEDSIGNAL */
/* verilator lint_off UNUSEDPARAM */
`default_nettype none

module EHXPLLL #(
  parameter int CLKI_DIV = 1, CLKFB_DIV = 1, CLKOP_DIV = 1, CLKOP_CPHASE = 0,
  parameter int CLKOS_DIV = 1, CLKOS_CPHASE = 0,
  parameter CLKOS_ENABLE = "", FEEDBK_PATH = ""
) (
  input  wire logic CLKI, CLKFB, RST, STDBY, PHASESEL0, PHASESEL1, PHASEDIR, PHASESTEP,
  input  wire logic PHASELOADREG, PLLWAKESYNC, ENCLKOP, ENCLKOS,
  output logic      CLKOP, CLKOS, LOCK
);
  assign CLKOP = CLKI;
  assign CLKOS = CLKI;
  assign LOCK = 1'b1;
endmodule

`default_nettype wire
