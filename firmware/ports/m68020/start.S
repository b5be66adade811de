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
        .macro  interrupt function
        movem.l %d0-%d1/%a0-%a1, -(%sp)
        jsr     \function
        movem.l (%sp)+, %d0-%d1/%a0-%a1
        rte
        .endm
servo:  interrupt port_servo_interrupt
spurious:
        interrupt port_spurious_interrupt
doorbell:
        interrupt port_doorbell_interrupt

| An access that may fail is one of four instructions, between labels of which %d1 holds the stack
| pointer; a bus error that finds the program there goes on behind it. Whatever frame the processor
| has pushed is dropped, so that its format does not matter; of every format the program counter is
| the second field, which may be that of the instruction behind, a NOP that waits for the end of the
| cycle.
bus_error:
        move.l  %d0, -(%sp)
        move.l  6(%sp), %d0
        sub.l   #single, %d0
        cmp.l   #single_end - single, %d0
        jls     1f
        sub.l   #read_list - single, %d0
        cmp.l   #read_list_end - read_list, %d0
        jls     2f
        sub.l   #write_list - read_list, %d0
        cmp.l   #write_list_end - write_list, %d0
        jls     3f
        move.l  (%sp)+, %d0
        jra     fatal
1:      move.l  %d1, %sp
        moveq   #2, %d0                 | MC_BUS_ERROR
        rts
2:      move.l  %d1, %sp
        moveq   #2, %d2
        st      %d0
        jra     read_list_end
3:      move.l  %d1, %sp
        moveq   #2, %d2
        jra     write_list_end

        .set    WINDOW, 0xFFFF6000
        .globl  port_read8, port_write8, port_read_list, port_write_list
port_read8:                             | read8 of struct mc_bus
        move.l  8(%sp), %d0
        add.l   #WINDOW, %d0
        move.l  %d0, %a0
        move.l  12(%sp), %a1
        move.l  %sp, %d1
single: move.b  (%a0), (%a1)
        nop
        moveq   #0, %d0
        rts
port_write8:                            | write8
        move.l  8(%sp), %d0
        add.l   #WINDOW, %d0
        move.l  %d0, %a0
        move.l  %sp, %d1
        move.b  15(%sp), (%a0)
        nop                             | writes are buffered
single_end:
        moveq   #0, %d0
        rts

port_read_list:                         | read_list
        move.l  8(%sp), %a1             | offsets
        movem.l %d2-%d3/%a2-%a3, -(%sp)
        move.l  28(%sp), %a2            | values
        move.l  32(%sp), %d3            | n
        move.l  #WINDOW, %a0
        moveq   #0, %d2                 | the result
        move.l  %sp, %d1
1:      move.w  (%a1)+, %d0
read_list:
        move.b  (%a0, %d0.w), %d0
        nop
read_list_end:
        move.b  %d0, (%a2)+
        subq.l  #1, %d3
        jne     1b
2:      move.l  %d2, %d0
        movem.l (%sp)+, %d2-%d3/%a2-%a3
        rts

port_write_list:                        | write_list
        move.l  8(%sp), %a1
        movem.l %d2-%d3/%a2-%a3, -(%sp)
        move.l  28(%sp), %a2
        move.l  32(%sp), %d3
        move.l  #WINDOW, %a0
        moveq   #0, %d2
        move.l  %sp, %d1
1:      move.w  (%a1)+, %d0
        lea     (%a0, %d0.w), %a3
        move.b  (%a2)+, %d0
write_list:
        move.b  %d0, (%a3)
        nop
write_list_end:
        subq.l  #1, %d3
        jne     1b
        jra     2b

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
