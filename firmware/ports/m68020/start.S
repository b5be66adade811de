/* SPDX-License-Identifier: Apache-2.0 */
/* Start-up, vectors, interrupts and bus errors of the 68020, §4.3; A16 is at 0xFFFF0000. */

#ifdef IMAGE_bench
#define port_servo_interrupt fatal
#define port_spurious_interrupt fatal
#define port_doorbell_interrupt fatal
#endif

        .section .vectors, "ax"
        .long   stack_top               | 0: initial stack
        .long   start                   | 1: reset
        .long   bus_error               | 2
        .set    n, 3
        .rept   21                      | 3-23: address error, illegal, divide by zero, traps...
        .long   fatal
        .endr
        .long   spurious                | 24: the acknowledge cycle ended in a bus error
        .long   fatal                   | 25: level 1
        .long   doorbell                | 26: level 2, autovector
        .rept   37                      | 27-63
        .long   fatal
        .endr
        .long   servo                   | 64 = 0x40: the adaptor, level 5
        .rept   191
        .long   fatal
        .endr

        .text
        .globl  start
start:  move.w  #0x2700, %sr
        moveq   #1, %d0
        movec   %d0, %cacr              | instruction cache on
        lea     bss_start, %a0
        lea     bss_end, %a1
1:      cmp.l   %a1, %a0
        jcc     2f
        clr.l   (%a0)+
        jra     1b
2:      jsr     ENTRY
3:      stop    #0x2700
        jra     3b

| The level is masked by the processor; C saves everything but these.
servo:  movem.l %d0-%d1/%a0-%a1, -(%sp)
        jsr     port_servo_interrupt
        movem.l (%sp)+, %d0-%d1/%a0-%a1
        rte

spurious:
        movem.l %d0-%d1/%a0-%a1, -(%sp)
        jsr     port_spurious_interrupt
        movem.l (%sp)+, %d0-%d1/%a0-%a1
        rte

doorbell:
        movem.l %d0-%d1/%a0-%a1, -(%sp)
        jsr     port_doorbell_interrupt
        movem.l (%sp)+, %d0-%d1/%a0-%a1
        rte

| An access that may fail leaves its stack pointer in `recover`, and the error of that access ends
| it with the result 1: whatever frame the processor has pushed is dropped, so that its format does
| not matter. Interrupts in between save and restore `recover` by the same means.
bus_error:
        tst.l   recover
        jeq     fatal
        move.l  recover, %sp
        moveq   #1, %d0
        jra     leave

        .globl  port_read8, port_write8
port_read8:                             | int port_read8(uint32_t address, uint8_t *value)
        move.l  recover, -(%sp)
        move.l  8(%sp), %a0
        move.l  12(%sp), %a1
        move.l  %sp, recover
        move.b  (%a0), %d1
        nop                             | the bus cycle is over
        move.b  %d1, (%a1)
        moveq   #0, %d0
leave:  move.l  (%sp)+, recover
        rts

port_write8:                            | int port_write8(uint32_t address, uint8_t value)
        move.l  recover, -(%sp)
        move.l  8(%sp), %a0
        move.l  12(%sp), %d1
        move.l  %sp, recover
        move.b  %d1, (%a0)
        nop                             | writes are buffered: wait for the end of this one
        moveq   #0, %d0
        jra     leave

| Wrong for good: the reason goes to the host, the heartbeats end, and the hardware raises PANIC.
fatal:  move.w  #0x2700, %sr
        move.l  2(%sp), %d1             | every frame: status, program counter, format and vector
        moveq   #0, %d0
        move.w  6(%sp), %d0
        and.w   #0x0FFF, %d0
        lsr.w   #2, %d0
        lea     stack_top, %sp
        move.l  %d1, -(%sp)
        move.l  %d0, -(%sp)
        jsr     FATAL
1:      stop    #0x2700
        jra     1b

        .globl  port_mask, port_unmask, port_idle
port_mask:                              | unsigned port_mask(void)
        moveq   #0, %d0
        move.w  %sr, %d0
        move.w  #0x2500, %sr
        rts

port_unmask:                            | void port_unmask(unsigned previous); 0: all levels
        move.l  4(%sp), %d0
        or.w    #0x2000, %d0
        move.w  %d0, %sr
        rts

| A request that came before is pending on level 2 still, and ends STOP at once.
port_idle:
        stop    #0x2000
        move.w  #0x2500, %sr
        rts

        .bss
        .even
recover: .long  0
