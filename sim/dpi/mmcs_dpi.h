/* SPDX-License-Identifier: Apache-2.0 */
/* What sim/dpi/mmcs_tb.sv imports through DPI-C (IEEE 1800-2017, section 35): the computer on the
 * VMEbus and the joints, behind one call a clock. The shared library libmmcs_dpi.so has it.
 *
 * Vectors are svBitVecVal (uint32_t): bit 0 first, 32 bits a word, axis or card 0 in the low bits,
 * as the ports of rtl/mmcs.sv. They have room for 16 cards; what lies beyond the machine's is 0. */
#ifndef MMCS_DPI_H
#define MMCS_DPI_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define MMCS_DPI_CARDS 16
#define MMCS_DPI_AXIS_WORDS 16 /* 16 bits for each of 32 axes */
#define MMCS_DPI_LED_WORDS 6   /* 11 bits for each of 16 cards */

/* Bits of `vme` into mmcs_dpi_clock(): D15..D00 are 15..0. */
#define MMCS_DPI_DRIVEN 16  /* the slave drives D07..D00 */
#define MMCS_DPI_DTACK 17   /* DTACK* as a level */
#define MMCS_DPI_IACKOUT 18 /* IACKOUT* as a level */
#define MMCS_DPI_IRQ 19     /* IRQ1*..IRQ7* as levels in 19..25 */
/* Bits of `lines` into it: levels. */
#define MMCS_DPI_PANIC 0
#define MMCS_DPI_BRAKE_RELEASE 1
#define MMCS_DPI_SCLOCK 2
#define MMCS_DPI_ALIVE 3
/* Bits of `bus` out of it: D15..D00 are 15..0, then all as levels of the pins. */
#define MMCS_DPI_A 16        /* A15..A1 in 16..30 */
#define MMCS_DPI_AM 31       /* AM5..AM0 in 31..36 */
#define MMCS_DPI_AS 37       /* AS* */
#define MMCS_DPI_DS 38       /* DS0*, DS1* */
#define MMCS_DPI_WRITE 40    /* WRITE* */
#define MMCS_DPI_LWORD 41    /* LWORD* */
#define MMCS_DPI_IACK 42     /* IACK* */
#define MMCS_DPI_IACKIN 43   /* IACKIN* */
#define MMCS_DPI_SYSRESET 44 /* SYSRESET* */
/* Bits of `safety` out of it: levels. */
#define MMCS_DPI_ESTOP_CLOSED 0
#define MMCS_DPI_CABLE_OK 1
#define MMCS_DPI_PC_POWER 2

/* Once, before the first clock: reads the set-up file (`mmcs compile`) of the scenario to carry out
 * and creates log.csv and bus.csv in the folder. Returns 0, or 1 with one sentence on the error
 * output: the testbench ends then. cards, clk_hz: what the machine is made with; a set-up for
 * another one is refused at the first clock. One machine a process. */
int mmcs_dpi_open(const char *setup, const char *folder, int cards, int clk_hz);

/* At every rising clk_i from the first on, with rst_ni low for the first 8: what stood on the
 * outputs of the machine just before the edge goes in, what stands on its inputs from this edge on
 * comes out. The testbench therefore reads before and drives by non-blocking assignment.
 *
 * In: vme and lines, the bits above; drive, drive_v_o, 16 bits an axis; leds, card_leds_o, 11 bits
 * a card.
 *
 * Out: bus and safety, the bits above; encoder, enc_a_i in 31..0, enc_b_i in 63..32 and enc_i_i in
 * 95..64; switches, axis_enable_i in 31..0 and dip_i in 95..32; adc, adc_v_i, 16 bits an axis.
 *
 * Returns 0 while the run goes on; when it has ended 1 and its exit status: 1 is a good end. */
int mmcs_dpi_clock(uint32_t vme, uint32_t lines, const uint32_t *drive, const uint32_t *leds,
                   uint64_t *bus, uint32_t *safety, uint32_t *encoder, uint32_t *switches,
                   uint32_t *adc);

#ifdef __cplusplus
}
#endif
#endif
