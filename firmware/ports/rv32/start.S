/* SPDX-License-Identifier: Apache-2.0 */
/* Start-up of a bare RV32 processor at address 0, §5. */
        .section .vectors, "ax"
        .globl  start
start:  la      sp, stack_top
        la      t0, bss_start
        la      t1, bss_end
1:      bgeu    t0, t1, 2f
        sw      zero, 0(t0)
        addi    t0, t0, 4
        j       1b
2:      call    ENTRY
3:      j       3b
