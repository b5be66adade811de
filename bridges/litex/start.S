/* SPDX-License-Identifier: Apache-2.0 */
/* Start-up and traps of the VexRiscv in LiteX: code and constants in ROM, data in SRAM. */
#include "riscv.S"

        .section .start, "ax"
        .globl  start
start:  la      sp, stack_top
        la      t0, trap
        csrw    mtvec, t0
        la      t0, data_start
        la      t1, data_end
        la      t2, data_rom
1:      bgeu    t0, t1, 2f
        lw      t3, 0(t2)
        sw      t3, 0(t0)
        addi    t0, t0, 4
        addi    t2, t2, 4
        j       1b
2:      clear_bss
        call    main
3:      j       3b

        .text
        .balign 4
trap:   enter_interrupt 64
        call    interrupt
        leave_interrupt 64
