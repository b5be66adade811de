// SPDX-License-Identifier: Apache-2.0
// The pins of a board that are the card's: the last ports of a top. docs/hardware/fpga.md
//
// ftdi_txd comes from the PC, adc_din goes to the converter; enable_n are switches to ground, and
// estop_n is low while the loop to ground is closed.

`ifndef BOARD_PINS_SVH
`define BOARD_PINS_SVH

`define BOARD_PINS \
  input  wire logic       ftdi_txd, \
  output logic            ftdi_rxd, \
  output logic            spi_sclk, \
  output logic            adc_cs_n, \
  output logic            adc_din, \
  input  wire logic       adc_dout, \
  output logic            dac_sync_n, \
  output logic            dac_din, \
  output logic            dac_clr_n, \
  output logic            dac_ldac_n, \
  input  wire logic [1:0] enc_a, \
  input  wire logic [1:0] enc_b, \
  input  wire logic [1:0] enc_i, \
  input  wire logic [1:0] enable_n, \
  input  wire logic       estop_n, \
  output logic            brake_release, \
  output logic            alive

`endif
