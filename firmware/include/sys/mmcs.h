/* SPDX-License-Identifier: Apache-2.0 */
/* What programs may ask of the devices here that the report does not have. */
#ifndef MMCS_H
#define MMCS_H

/* int, by pointer: 1 takes the lease, 0 gives it up, as the end of the open does. Who has it
 * changes things, nobody else does but by a stop. EBUSY: another has it; EBADF: not open for
 * writing. */
#define MLEASE 0x80044D40

/* int, by pointer: waits for the next servo sample and gives its number since power-on. */
#define MWAIT 0x40044D41

/* char[MWHY_SIZE]: why this thread's last call on an open device was refused, as one sentence;
 * empty if its errno says all there is. */
#define MWHY_SIZE 128
#define MWHY 0x40804D42

/* struct mmcs_status: how the machine stands. A read-only open may ask, too. */
struct mmcs_status {
  unsigned long long time_ns; /* of the machine, since power-on */
  unsigned sample;            /* number of the last servo sample since power-on, as of MWAIT */
  int enabled;                /* 1: the servo drives the joints */
  int stopped;                /* 1: a stop is latched, nothing moves until an MENABLE */
  int stopped_by;             /* process that asked for it; 0: the host's stop path, or no stop */
  int cause;                  /* MCAUSE_...: what shut the machine down, until an MENABLE */
  int number;                 /* the axis or card (DIP switch) of the cause, or -1 */
};
#define MSTATUS 0x40204D43

#define MCAUSE_NONE 0
#define MCAUSE_HEARTBEAT 1 /* axis `number` has no heartbeat */
#define MCAUSE_CARD 2      /* card `number` does not answer */
#define MCAUSE_SILENT 3    /* no card answers: cable or power */
#define MCAUSE_PASSED 4    /* a PANIC, and all is well now: button, or a cause that has passed */
#define MCAUSE_AXIS 5      /* an error of axis `number` without SOFTERR: errcode says which */
#define MCAUSE_BUS 6       /* bus error in a servo pass, or the adaptor does not answer */
#define MCAUSE_RESET 7     /* SYSRESET* */
#define MCAUSE_LATE 8      /* no interrupts, or passes outlast SCLOCK */
#define MCAUSE_GUARD 9     /* struct mc_guard; of axis `number`, or -1 */

/* int, by pointer: gives up what MCALIB began of this axis; others go on. Nothing to give up: 0. */
#define MCALIBEND 0x80044D44

/* struct mmcs_setpoint: the setpoint of one axis; the others keep theirs, whoever writes them.
 * Errors as of write(). */
struct mmcs_setpoint {
  int axis;
  int value;
};
#define MSETPOINT 0x80084D45

#endif
