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
        .set    at, 0
        .irp    register, ra, t0, t1, t2, a0, a1, a2, a3, a4, a5, a6, a7, t3, t4, t5, t6
        \op     \register, at(sp)
        .set    at, at + 4
        .endr
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
