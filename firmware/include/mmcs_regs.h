/* SPDX-License-Identifier: Apache-2.0 */
/* The registers of the MMCS, §4.3 and §5.3. */
/* Generated from rtl/regs/mmcs.rdl by rtl/regs/generate.py; do not edit. */
#ifndef MMCS_REGS_H
#define MMCS_REGS_H

#include <stdint.h>

/* The window. */
#define MMCS_WINDOW_BASE 0x6000u /* A16 address of the window as shipped (jumpers A15-A11) */
#define MMCS_WINDOW_SIZE 0x800u /* its length in bytes */
#define MMCS_CARDS_MAX 0x10u /* cards on one PC bus */
#define MMCS_PCCSR_BASE_CARDS 0x18u /* PCCSR BASE that reaches the cards: PC address 0x300 */
#define MMCS_PPI_MODE_BOARD 0x89u /* PPI mode word of the board: A and B out, C in */

/* Window offset of register `reg` (MMCS_CARD_...) of card 0-15. */
#define MMCS_CARD_OFFSET(card, reg) \
  ((uint16_t)((((unsigned)(card)) << 6) | (((unsigned)(reg)) << 1) | 1u))

/* Adaptor registers: window offsets. */
#define MMCS_PIT0 0x401u /* Timer 0: divides the system clock */
#define MMCS_PIT1 0x403u /* Timer 1: clocked by timer 0, its output is SCLOCK */
#define MMCS_PIT2 0x405u /* Timer 2: counts SCLOCK */
#define MMCS_PIT_CONTROL 0x407u /* Timer control word */
#define MMCS_PCCSR 0x409u /* PC control and status */
#define MMCS_VECTOR 0x441u /* Interrupt vector */

/* Card registers: offsets on the PC bus, for MMCS_CARD_OFFSET. */
#define MMCS_CARD_PPI_A 0x00u /* PPI port A */
#define MMCS_CARD_PPI_B 0x01u /* PPI port B */
#define MMCS_CARD_PPI_C 0x02u /* PPI port C */
#define MMCS_CARD_PPI_CONTROL 0x03u /* PPI control word */
#define MMCS_CARD_ENC1_MSB 0x04u /* Encoder counter, joint 1, high byte */
#define MMCS_CARD_ENC1_LSB 0x05u /* Encoder counter, joint 1, low byte */
#define MMCS_CARD_ENC2_MSB 0x06u /* Encoder counter, joint 2, high byte */
#define MMCS_CARD_ENC2_LSB 0x07u /* Encoder counter, joint 2, low byte */
#define MMCS_CARD_DAC1_LO 0x08u /* D/A, joint 1, low byte */
#define MMCS_CARD_DAC1_HI 0x09u /* D/A, joint 1, high nibble */
#define MMCS_CARD_DAC2_LO 0x0Au /* D/A, joint 2, low byte */
#define MMCS_CARD_DAC2_HI 0x0Bu /* D/A, joint 2, high nibble */
#define MMCS_CARD_ADC1_LO 0x0Cu /* A/D, joint 1, low byte */
#define MMCS_CARD_ADC2_LO 0x0Du /* A/D, joint 2, low byte */
#define MMCS_CARD_ADC_HI 0x0Eu /* A/D, high nibbles */
#define MMCS_CARD_LATCH 0x10u /* Software latch, this card */
#define MMCS_CARD_LATCH_ALL 0x12u /* Software latch, all cards */

/* Bits: _bm mask, _bp lowest bit, _gc value in place. */
#define MMCS_PIT_CONTROL_BCD_bm 0x01u /* 1: four decades; 0: 16 bits */
#define MMCS_PIT_CONTROL_BCD_bp 0u
#define MMCS_PIT_CONTROL_MODE_bm 0x0Eu /* Mode 0-5 */
#define MMCS_PIT_CONTROL_MODE_bp 1u
#define MMCS_PIT_CONTROL_RW_bm 0x30u /* Byte format */
#define MMCS_PIT_CONTROL_RW_bp 4u
#define MMCS_PIT_CONTROL_RW_LATCH_gc 0x00u /* Latch the count; mode unchanged */
#define MMCS_PIT_CONTROL_RW_LSB_gc 0x10u /* Low byte only */
#define MMCS_PIT_CONTROL_RW_MSB_gc 0x20u /* High byte only */
#define MMCS_PIT_CONTROL_RW_BOTH_gc 0x30u /* Low byte, then high byte */
#define MMCS_PIT_CONTROL_SC_bm 0xC0u /* Timer; 3 is the read-back command (PIT_READBACK) */
#define MMCS_PIT_CONTROL_SC_bp 6u

#define MMCS_PCCSR_BASE_bm 0x1Fu /* PC address bits A09-A05; 0x18 selects the cards */
#define MMCS_PCCSR_BASE_bp 0u
#define MMCS_PCCSR_SCLOCK_LATCHED_bm 0x20u /* SCLOCK has risen, enabled or not */
#define MMCS_PCCSR_SCLOCK_LATCHED_bp 5u
#define MMCS_PCCSR_SCLOCK_EN_bm 0x20u /* Lets SCLOCK interrupt */
#define MMCS_PCCSR_SCLOCK_EN_bp 5u
#define MMCS_PCCSR_PANIC_LATCHED_bm 0x40u /* PANIC has risen, enabled or not */
#define MMCS_PCCSR_PANIC_LATCHED_bp 6u
#define MMCS_PCCSR_PANIC_EN_bm 0x40u /* Lets PANIC interrupt */
#define MMCS_PCCSR_PANIC_EN_bp 6u
#define MMCS_PCCSR_LATCH_EN_bm 0x80u /* 0 holds both latches clear */
#define MMCS_PCCSR_LATCH_EN_bp 7u

#define MMCS_CARD_PPI_A_ENC_MODE_bm 0x07u /* Mode of both encoder counters; 5 counts all four edges */
#define MMCS_CARD_PPI_A_ENC_MODE_bp 0u
#define MMCS_CARD_PPI_A_LED1_bm 0x08u /* Red light gp1 */
#define MMCS_CARD_PPI_A_LED1_bp 3u
#define MMCS_CARD_PPI_A_LED2_bm 0x10u /* Red light gp2 */
#define MMCS_CARD_PPI_A_LED2_bp 4u
#define MMCS_CARD_PPI_A_SYN_A_bm 0x20u /* Synthetic encoder signal A */
#define MMCS_CARD_PPI_A_SYN_A_bp 5u
#define MMCS_CARD_PPI_A_SYN_B_bm 0x40u /* Synthetic encoder signal B */
#define MMCS_CARD_PPI_A_SYN_B_bp 6u
#define MMCS_CARD_PPI_A_SYN_I_bm 0x80u /* Synthetic encoder index */
#define MMCS_CARD_PPI_A_SYN_I_bp 7u

#define MMCS_CARD_PPI_B_ENC_JOINT_bm 0x01u /* 1: encoder signals of the joints; 0: the synthetic ones */
#define MMCS_CARD_PPI_B_ENC_JOINT_bp 0u
#define MMCS_CARD_PPI_B_DAC_JOINT_bm 0x02u /* 1: D/A to the joints; 0: looped back to the A/D through the relay */
#define MMCS_CARD_PPI_B_DAC_JOINT_bp 1u
#define MMCS_CARD_PPI_B_SCLOCK_EN_bm 0x04u /* 1: the rising edge of SCLOCK latches this card */
#define MMCS_CARD_PPI_B_SCLOCK_EN_bp 2u
#define MMCS_CARD_PPI_B_DAC_DOUBLE_bm 0x08u /* 1: D/A outputs change at the latch; 0: at the write of the high nibble */
#define MMCS_CARD_PPI_B_DAC_DOUBLE_bp 3u
#define MMCS_CARD_PPI_B_INDEX_EN_bm 0x10u /* 1: index pulses latch; 0: clears the index latches */
#define MMCS_CARD_PPI_B_INDEX_EN_bp 4u

#define MMCS_CARD_PPI_C_HEARTBEAT1_bm 0x01u /* Heartbeat of joint 1 alive */
#define MMCS_CARD_PPI_C_HEARTBEAT1_bp 0u
#define MMCS_CARD_PPI_C_INDEX1_bm 0x02u /* Index of joint 1 has been latched */
#define MMCS_CARD_PPI_C_INDEX1_bp 1u
#define MMCS_CARD_PPI_C_HEARTBEAT2_bm 0x04u /* Heartbeat of joint 2 alive */
#define MMCS_CARD_PPI_C_HEARTBEAT2_bp 2u
#define MMCS_CARD_PPI_C_INDEX2_bm 0x08u /* Index of joint 2 has been latched */
#define MMCS_CARD_PPI_C_INDEX2_bp 3u
#define MMCS_CARD_PPI_C_ADC_READY_bm 0x10u /* Neither A/D is converting */
#define MMCS_CARD_PPI_C_ADC_READY_bp 4u

#define MMCS_CARD_DAC1_HI_CODE_bm 0x0Fu
#define MMCS_CARD_DAC1_HI_CODE_bp 0u

#define MMCS_CARD_DAC2_HI_CODE_bm 0x0Fu
#define MMCS_CARD_DAC2_HI_CODE_bp 0u

#define MMCS_CARD_ADC_HI_CODE1_bm 0x0Fu /* Bits 11-8 of joint 1 */
#define MMCS_CARD_ADC_HI_CODE1_bp 0u
#define MMCS_CARD_ADC_HI_CODE2_bm 0xF0u /* Bits 11-8 of joint 2 */
#define MMCS_CARD_ADC_HI_CODE2_bp 4u

#define MMCS_PIT_READBACK_TIMERS_bm 0x0Eu /* Bit 0: timer 0, and so on */
#define MMCS_PIT_READBACK_TIMERS_bp 1u
#define MMCS_PIT_READBACK_STATUS_N_bm 0x10u /* 0 latches the status */
#define MMCS_PIT_READBACK_STATUS_N_bp 4u
#define MMCS_PIT_READBACK_COUNT_N_bm 0x20u /* 0 latches the counts */
#define MMCS_PIT_READBACK_COUNT_N_bp 5u
#define MMCS_PIT_READBACK_SC_bm 0xC0u /* 3 */
#define MMCS_PIT_READBACK_SC_bp 6u

#define MMCS_PIT_STATUS_BCD_bm 0x01u /* As written */
#define MMCS_PIT_STATUS_BCD_bp 0u
#define MMCS_PIT_STATUS_MODE_bm 0x0Eu /* As written */
#define MMCS_PIT_STATUS_MODE_bp 1u
#define MMCS_PIT_STATUS_RW_bm 0x30u /* As written */
#define MMCS_PIT_STATUS_RW_bp 4u
#define MMCS_PIT_STATUS_NULL_COUNT_bm 0x40u /* 1 until the written count has been loaded */
#define MMCS_PIT_STATUS_NULL_COUNT_bp 6u
#define MMCS_PIT_STATUS_OUT_bm 0x80u /* Level of the output */
#define MMCS_PIT_STATUS_OUT_bp 7u

#define MMCS_PPI_MODE_CL_IN_bm 0x01u /* 1: port C 3-0 is input */
#define MMCS_PPI_MODE_CL_IN_bp 0u
#define MMCS_PPI_MODE_B_IN_bm 0x02u /* 1: port B is input */
#define MMCS_PPI_MODE_B_IN_bp 1u
#define MMCS_PPI_MODE_B_MODE_bm 0x04u /* Mode of port B and the low half of C: 0, 1 */
#define MMCS_PPI_MODE_B_MODE_bp 2u
#define MMCS_PPI_MODE_CH_IN_bm 0x08u /* 1: port C 7-4 is input */
#define MMCS_PPI_MODE_CH_IN_bp 3u
#define MMCS_PPI_MODE_A_IN_bm 0x10u /* 1: port A is input */
#define MMCS_PPI_MODE_A_IN_bp 4u
#define MMCS_PPI_MODE_A_MODE_bm 0x60u /* Mode of port A and the high half of C: 0, 1, 2 */
#define MMCS_PPI_MODE_A_MODE_bp 5u
#define MMCS_PPI_MODE_SET_bm 0x80u /* 1 */
#define MMCS_PPI_MODE_SET_bp 7u

#define MMCS_PPI_BIT_VALUE_bm 0x01u /* Its new value */
#define MMCS_PPI_BIT_VALUE_bp 0u
#define MMCS_PPI_BIT_BIT_bm 0x0Eu /* Bit of port C */
#define MMCS_PPI_BIT_BIT_bp 1u

#endif
