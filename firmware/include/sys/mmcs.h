/* SPDX-License-Identifier: Apache-2.0 */
/* Requests of /dev/mc0 that the report does not have. */
#ifndef MMCS_H
#define MMCS_H

/* int, by pointer: 1 takes the lease, 0 gives it up, and so does close(). Only the holder of the
 * lease may change the machine; a stop is allowed to all. EBUSY: another program has the lease;
 * EBADF: not open for writing. */
#define MLEASE 0x80044D40

/* int, by pointer: waits for the next servo sample and gives its number since power-on. */
#define MWAIT 0x40044D41

/* char[MWHY_SIZE]: why this thread's last call on an open device was refused, as one sentence;
 * empty if there is nothing to add to the errno. After any other call: the cause of a shutdown that
 * no register shows, as "the simulator knows: the ribbon cable is pulled". */
#define MWHY_SIZE 128
#define MWHY 0x40804D42

/* struct mmcs_status: the state of the machine; also for a read-only open. */
struct mmcs_status {
  unsigned long long time_ns; /* of the machine, since power-on */
  unsigned sample;            /* number of the last servo sample since power-on, as of MWAIT */
  int enabled;                /* 1: the servo drives the joints */
  int stopped;                /* 1: a stop is latched, nothing moves until an MENABLE */
  int stopped_by;             /* process that requested it; 0: the host's stop path, or no stop */
  int cause;                  /* MCAUSE_...: what shut the machine down, until an MENABLE */
  int number;                 /* the axis or card (DIP switch) of the cause, or -1 */
};
#define MSTATUS 0x40204D43

#define MCAUSE_NONE 0
#define MCAUSE_HEARTBEAT 1 /* axis `number` has no heartbeat */
#define MCAUSE_CARD 2      /* card `number` does not answer */
#define MCAUSE_SILENT 3    /* no card answers: cable or power */
#define MCAUSE_PASSED 4    /* a PANIC whose cause no register shows: button, or it has passed */
#define MCAUSE_AXIS 5      /* an error of axis `number` without SOFTERR: errcode says which */
#define MCAUSE_BUS 6       /* bus error in a servo pass, or the adaptor does not answer */
#define MCAUSE_RESET 7     /* SYSRESET*, or a program wrote PCCSR */
#define MCAUSE_LATE 8      /* no interrupts, or passes outlast SCLOCK */

/* int, by pointer: ends the calibration of this axis only; succeeds also if there is none. */
#define MCALIBEND 0x80044D44

/* struct mmcs_setpoint: the setpoint of one axis; other axes keep theirs. Errors as of write(). */
struct mmcs_setpoint {
  int axis;
  int value;
};
#define MSETPOINT 0x80084D45

#endif
