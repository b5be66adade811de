/* SPDX-License-Identifier: Apache-2.0 */
/* Start-up, traps and bus errors of the RV32 core of rtl/soc, §5. Memory map: docs/hardware/soc.md.
 *
 * The core takes its vectors from address 0 (cause 0 and all exceptions first, interrupt n at 4 n)
 * and starts at 0x80. */

#if defined(IMAGE_bench) || defined(IMAGE_timing)
#define port_servo_interrupt fatal
#define port_doorbell_interrupt fatal
#endif

        .option arch, +zicsr
        .option norvc
        .set    MIE, 8                  /* mstatus: interrupts on */
        .set    SOURCES, 0x808          /* mie: external 11, software 3 */

        .section .vectors, "ax"
        .globl  start
        j       exception
        .rept   2
        j       fatal
        .endr
        j       doorbell                /* 3: software, the host's ring */
        .rept   7
        j       fatal
        .endr
        j       servo                   /* 11: external, the adaptor */
        .rept   20
        j       fatal
        .endr

        .org    0x80
start:  csrw    mie, zero
        csrwi   mcountinhibit, 5        /* nobody reads the counters: they stand */
        la      sp, stack_top
        la      t0, bss_start
        la      t1, bss_end
1:      bgeu    t0, t1, 2f
        sw      zero, 0(t0)
        addi    t0, t0, 4
        j       1b
2:      li      t0, SOURCES
        csrw    mie, t0
        call    ENTRY
3:      wfi
        j       3b

        .text
        .balign 4
/* What C does not save, around a C function. Interrupts do not nest, but a bus error within one
 * does: it takes mepc and the stack of mstatus, which are kept here, too. */
        .macro  interrupt function
        addi    sp, sp, -80
        sw      ra, 0(sp)
        sw      t0, 4(sp)
        csrr    t0, mepc
        sw      t0, 64(sp)
        csrr    t0, mstatus
        sw      t0, 68(sp)
        sw      t1, 8(sp)
        sw      t2, 12(sp)
        sw      a0, 16(sp)
        sw      a1, 20(sp)
        sw      a2, 24(sp)
        sw      a3, 28(sp)
        sw      a4, 32(sp)
        sw      a5, 36(sp)
        sw      a6, 40(sp)
        sw      a7, 44(sp)
        sw      t3, 48(sp)
        sw      t4, 52(sp)
        sw      t5, 56(sp)
        sw      t6, 60(sp)
        call    \function
        lw      t0, 68(sp)
        csrw    mstatus, t0
        lw      t0, 64(sp)
        csrw    mepc, t0
        lw      ra, 0(sp)
        lw      t0, 4(sp)
        lw      t1, 8(sp)
        lw      t2, 12(sp)
        lw      a0, 16(sp)
        lw      a1, 20(sp)
        lw      a2, 24(sp)
        lw      a3, 28(sp)
        lw      a4, 32(sp)
        lw      a5, 36(sp)
        lw      a6, 40(sp)
        lw      a7, 44(sp)
        lw      t3, 48(sp)
        lw      t4, 52(sp)
        lw      t5, 56(sp)
        lw      t6, 60(sp)
        addi    sp, sp, 80
        mret
        .endm

servo:  interrupt port_servo_interrupt
doorbell:
        interrupt port_doorbell_interrupt

/* An access that may fail is one of two instructions; an access fault of theirs, and of no other,
 * goes on behind it with the result 1. */
exception:
        csrr    t0, mepc
        la      t1, load
        beq     t0, t1, 1f
        la      t1, store
        bne     t0, t1, fatal
1:      csrr    t0, mcause
        andi    t0, t0, ~2              /* 5: load access fault, 7: store access fault */
        addi    t0, t0, -5
        bnez    t0, fatal
        la      t0, failed
        csrw    mepc, t0
        mret

        .globl  port_read8, port_write8
        .set    REGISTERS, 0x00E00000 - 2       /* a word each: of window offset 2 n + 1 at 4 n */
port_read8:                             /* read8 of struct mc_bus */
        li      t1, REGISTERS
        slli    a1, a1, 1
        add     a1, a1, t1
load:   lbu     t0, 0(a1)
        sb      t0, 0(a2)
        li      a0, 0
        ret

port_write8:                            /* write8 */
        li      t1, REGISTERS
        slli    a1, a1, 1
        add     a1, a1, t1
store:  sb      a2, 0(a1)               /* ends with the answer: nothing is buffered */
        li      a0, 0
        ret
failed: li      a0, 2                   /* MC_BUS_ERROR */
        ret

/* Wrong for good: the reason goes to the host, the heartbeats end, and the hardware raises PANIC. */
fatal:  csrci   mstatus, MIE
        csrw    mie, zero
        csrr    a0, mcause
        csrr    a1, mepc
        la      sp, stack_top
        call    FATAL
1:      wfi
        j       1b

        .globl  port_mask, port_unmask, port_idle
port_mask:                              /* unsigned port_mask(void); 0: nothing was masked */
        csrrci  a0, mstatus, MIE
        andi    a0, a0, MIE
        xori    a0, a0, MIE
        ret

port_unmask:                            /* void port_unmask(unsigned previous) */
        bnez    a0, 1f
        csrsi   mstatus, MIE
1:      ret

/* WFI ends on a request that is masked, one from before included. */
port_idle:
        wfi
        csrsi   mstatus, MIE
        nop
        csrci   mstatus, MIE
        ret

