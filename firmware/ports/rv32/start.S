/* SPDX-License-Identifier: Apache-2.0 */
/* Start-up, traps and bus errors of a RISC-V processor with the standard interrupts, §5.
 *
 * The processor takes its vectors from address 0 (cause 0 and all exceptions first, interrupt n at 4 n)
 * and starts at 0x80. */

#ifdef IMAGE_bench
#define port_servo_interrupt fatal
#define port_doorbell_interrupt fatal
#endif

#include "../riscv.S"

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
        la      sp, stack_top
        clear_bss
        li      t0, SOURCES
        csrw    mie, t0
        call    ENTRY
1:      wfi
        j       1b

        .text
        .balign 4
/* Around a C function. Interrupts do not nest, but a bus error within one does: it takes mepc and
 * the stack of mstatus, which are kept here, too. */
        .macro  interrupt function
        enter_interrupt 80
        csrr    t0, mepc
        sw      t0, 64(sp)
        csrr    t0, mstatus
        sw      t0, 68(sp)
        call    \function
        lw      t0, 68(sp)
        csrw    mstatus, t0
        lw      t0, 64(sp)
        csrw    mepc, t0
        leave_interrupt 80
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

