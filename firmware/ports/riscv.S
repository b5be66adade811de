/* SPDX-License-Identifier: Apache-2.0 */
/* What start-ups of RISC-V processors share: to be included. */
        .option norvc
        .option arch, +zicsr

        .macro  clear_bss
        la      t0, bss_start
        la      t1, bss_end
1:      bgeu    t0, t1, 2f
        sw      zero, 0(t0)
        addi    t0, t0, 4
        j       1b
2:
        .endm

/* What C does not save goes to a frame of so many bytes on the stack; from 64 on it is the caller's.
 * op: sw or lw. */
        .macro  each_register op
        \op     ra, 0(sp)
        \op     t0, 4(sp)
        \op     t1, 8(sp)
        \op     t2, 12(sp)
        \op     a0, 16(sp)
        \op     a1, 20(sp)
        \op     a2, 24(sp)
        \op     a3, 28(sp)
        \op     a4, 32(sp)
        \op     a5, 36(sp)
        \op     a6, 40(sp)
        \op     a7, 44(sp)
        \op     t3, 48(sp)
        \op     t4, 52(sp)
        \op     t5, 56(sp)
        \op     t6, 60(sp)
        .endm

        .macro  enter_interrupt frame
        addi    sp, sp, -\frame
        each_register sw
        .endm

        .macro  leave_interrupt frame
        each_register lw
        addi    sp, sp, \frame
        mret
        .endm
