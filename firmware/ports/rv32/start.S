/* SPDX-License-Identifier: Apache-2.0 */
/* Start-up of an RV32IM processor, §5, for the image of the arithmetic. That of the driver is linked and
 * not run: bridges/litex has the start-up of a processor with interrupts.
 *
 * The processor starts at 0x80. */
#include "../riscv.S"

        .section .vectors, "ax"
        .globl  start
        .org    0x80
start:  la      sp, stack_top
        clear_bss
        call    ENTRY
1:      wfi
        j       1b
