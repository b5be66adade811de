// SPDX-License-Identifier: Apache-2.0
// The registers of the MMCS as constants. §4.3, §5.3
// Generated from rtl/regs/mmcs.rdl by rtl/regs/generate.py; do not edit.
`default_nettype none

/* verilator lint_off UNUSEDPARAM */  // each user needs a few of them
package mmcs_regs_pkg;

  // Adaptor registers: offsets in the VME window.
  localparam logic [10:0] PIT0 = 11'h401;
  localparam logic [10:0] PIT1 = 11'h403;
  localparam logic [10:0] PIT2 = 11'h405;
  localparam logic [10:0] PIT_CONTROL = 11'h407;
  localparam logic [10:0] PCCSR = 11'h409;
  localparam logic [10:0] VECTOR = 11'h441;
  localparam logic [7:0] PCCSR_RESET = 8'h00;
  localparam logic [7:0] VECTOR_RESET = 8'h0F;

  // Card registers: A4-A0 on the PC bus.
  localparam logic [4:0] CARD_PPI_A = 5'h00;
  localparam logic [4:0] CARD_PPI_B = 5'h01;
  localparam logic [4:0] CARD_PPI_C = 5'h02;
  localparam logic [4:0] CARD_PPI_CONTROL = 5'h03;
  localparam logic [4:0] CARD_ENC1_MSB = 5'h04;
  localparam logic [4:0] CARD_ENC1_LSB = 5'h05;
  localparam logic [4:0] CARD_ENC2_MSB = 5'h06;
  localparam logic [4:0] CARD_ENC2_LSB = 5'h07;
  localparam logic [4:0] CARD_DAC1_LO = 5'h08;
  localparam logic [4:0] CARD_DAC1_HI = 5'h09;
  localparam logic [4:0] CARD_DAC2_LO = 5'h0A;
  localparam logic [4:0] CARD_DAC2_HI = 5'h0B;
  localparam logic [4:0] CARD_ADC1_LO = 5'h0C;
  localparam logic [4:0] CARD_ADC2_LO = 5'h0D;
  localparam logic [4:0] CARD_ADC_HI = 5'h0E;
  localparam logic [4:0] CARD_LATCH = 5'h10;
  localparam logic [4:0] CARD_LATCH_ALL = 5'h12;

  // Lowest bit of each field.
  localparam int PIT_CONTROL_BCD = 0;
  localparam int PIT_CONTROL_MODE = 1;
  localparam int PIT_CONTROL_RW = 4;
  localparam int PIT_CONTROL_SC = 6;
  localparam int PCCSR_BASE = 0;
  localparam int PCCSR_SCLOCK_LATCHED = 5;
  localparam int PCCSR_SCLOCK_EN = 5;
  localparam int PCCSR_PANIC_LATCHED = 6;
  localparam int PCCSR_PANIC_EN = 6;
  localparam int PCCSR_LATCH_EN = 7;
  localparam int CARD_PPI_A_ENC_MODE = 0;
  localparam int CARD_PPI_A_LED1 = 3;
  localparam int CARD_PPI_A_LED2 = 4;
  localparam int CARD_PPI_A_SYN_A = 5;
  localparam int CARD_PPI_A_SYN_B = 6;
  localparam int CARD_PPI_A_SYN_I = 7;
  localparam int CARD_PPI_B_ENC_JOINT = 0;
  localparam int CARD_PPI_B_DAC_JOINT = 1;
  localparam int CARD_PPI_B_SCLOCK_EN = 2;
  localparam int CARD_PPI_B_DAC_DOUBLE = 3;
  localparam int CARD_PPI_B_INDEX_EN = 4;
  localparam int CARD_PPI_C_HEARTBEAT1 = 0;
  localparam int CARD_PPI_C_INDEX1 = 1;
  localparam int CARD_PPI_C_HEARTBEAT2 = 2;
  localparam int CARD_PPI_C_INDEX2 = 3;
  localparam int CARD_PPI_C_ADC_READY = 4;
  localparam int CARD_DAC1_HI_CODE = 0;
  localparam int CARD_DAC2_HI_CODE = 0;
  localparam int CARD_ADC_HI_CODE1 = 0;
  localparam int CARD_ADC_HI_CODE2 = 4;
  localparam int PIT_READBACK_TIMERS = 1;
  localparam int PIT_READBACK_STATUS_N = 4;
  localparam int PIT_READBACK_COUNT_N = 5;
  localparam int PIT_READBACK_SC = 6;
  localparam int PIT_STATUS_BCD = 0;
  localparam int PIT_STATUS_MODE = 1;
  localparam int PIT_STATUS_RW = 4;
  localparam int PIT_STATUS_NULL_COUNT = 6;
  localparam int PIT_STATUS_OUT = 7;
  localparam int PPI_MODE_CL_IN = 0;
  localparam int PPI_MODE_B_IN = 1;
  localparam int PPI_MODE_B_MODE = 2;
  localparam int PPI_MODE_CH_IN = 3;
  localparam int PPI_MODE_A_IN = 4;
  localparam int PPI_MODE_A_MODE = 5;
  localparam int PPI_MODE_SET = 7;
  localparam int PPI_BIT_VALUE = 0;
  localparam int PPI_BIT_BIT = 1;

  // PCCSR BASE that reaches the cards: PC A9-A5 of address 0x300.
  localparam logic [4:0] CARD_SELECT = 5'h18;

endpackage
/* verilator lint_on UNUSEDPARAM */

`default_nettype wire
