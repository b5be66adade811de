/* SPDX-License-Identifier: Apache-2.0 */
/* The wire between a program under `mmcs exec` and the simulator behind `mmcs serve`.
 *
 * Two kinds of connection to one Unix socket, on which a request or a reply is one packet. A *file*
 * is what open("/dev/mc0") returns: the kernel gives it dup, fork, close and exit for free, and the
 * server sees the last close as a hang-up. It carries only the opening request, its reply, and one
 * byte that keeps it readable for poll(); bytes sent on it past this library fail with EPIPE. A
 * *channel* carries calls, one at a time; a call names its file by the inode of the program's end.
 * Both ends ask the kernel for the user at the other one.
 *
 * All numbers are little-endian, as on the machines that can run this; structures are packed by
 * construction. Python reads this very file, so it holds plain C declarations only.
 */
#ifndef MMCS_WIRE_H
#define MMCS_WIRE_H

#include <stddef.h>
#include <stdint.h>

enum wire_number {
  WIRE_MAX = 65536,       /* most bytes that one call moves either way */
  WIRE_MAGIC = 0x31434D4D /* "MMC1" */
};

enum wire_op {
  WIRE_OPEN = 1,  /* on a new file: a = open flags, data = device path */
  WIRE_IOCTL = 2, /* a = request, data = argument in; reply data = argument out. MWAIT is answered
                     behind the next servo sample; MWHY is of the last call on this channel, b =
                     room for it, 0: MWHY_SIZE */
  WIRE_READ = 3,  /* a = bytes wanted */
  WIRE_WRITE = 4, /* data = bytes */
  WIRE_LOAD = 5,  /* mapped read: a = offset, b = bytes (1, 2); reply data = value */
  WIRE_STORE = 6, /* mapped write: a = offset, b = bytes (1, 2), data = value */
  WIRE_HOLD = 7,  /* this process holds the file now (after fork or exec); result 1: /dev/vme16, 2:
                     and open for writing */
  /* Lock-step only. Every thread has a connection more, its line, which carries the first of these
   * and shows that the other end is gone. Back come a file, its struct wire_page, for what it
   * asks from then on, an eventfd that tells of answers, and one that tells of requests. */
  WIRE_LINE = 12,   /* a = the thread's number in its process, 0: the first; b = thread. Answered
                       when it may run. Again: the thread ends, no answer */
  WIRE_WAIT = 13,   /* data = struct wire_wait, descriptors, and the bytes of a write() that is
                       carried out first; answered when it may run again: result = enum wire_cause.
                       a = bytes of states that may come with it, as read() would give them */
  WIRE_WAKE = 14,   /* a = key, b = how many of this process that wait with it may go on */
  WIRE_SPAWN = 15,  /* a = pid of a child, 0: a thread of this process; b = 1: it came to nothing */
  WIRE_NOW = 17,    /* what comes with every answer: struct wire_now */
  WIRE_POKE = 18,   /* a = pid, b = signal: this thread has sent it one; a as of kill(). With
                       WIRE_THREAD in b: a thread of this process */
  WIRE_CANCEL = 19, /* on a line that waits: a signal from outside has come. Answered as the wait */
};

/* What ends a wait, beside its time and (but for WAIT_DEAF) a signal. */
enum wire_what {
  WAIT_SAMPLE = 1, /* a servo sample */
  WAIT_KEY = 2,    /* WIRE_WAKE with its key */
  WAIT_FILES = 4,  /* others have run: descriptors may be ready */
  WAIT_CHILD = 8,  /* a process has ended */
  WAIT_DEAF = 16,
  WAIT_AGAIN = 64,  /* as before: nobody else need look again */
  WAIT_THREAD = 32, /* the end of the thread that has the key */
  WAIT_ERROR = 128  /* with WAIT_FILES: the program takes the driver's signals */
};
/* Of what WIRE_WAIT answers. OUTSIDE: nobody attached can end it; time stands still meanwhile. */
enum wire_cause {
  CAUSE_DUE = 0,
  CAUSE_WOKEN = 1, /* or its time, where it waits for a sample */
  CAUSE_SIGNAL = 2,
  CAUSE_OUTSIDE = 3,
  CAUSE_LATE = 4 /* no servo sample came for 2.5 s of the machine */
};

#define WIRE_NEVER UINT64_MAX
#define WIRE_THREAD 0x100u

struct wire_wait {
  uint64_t until; /* ns of machine time */
  uint64_t key;
  uint64_t mask, pending; /* signals: blocked while it waits; come already */
  uint32_t what;
  uint32_t files; /* descriptors that follow, 32 bits each */
  uint32_t written, none;
};

struct wire_now {
  uint64_t ns;     /* machine time */
  uint32_t sample; /* since power-on */
  int32_t writes;  /* 1: a write() as the last one, before time goes on, needs no answer */
};

struct wire_request {
  uint32_t magic;
  uint32_t op;
  uint64_t file; /* its inode, not 0 */
  uint64_t a, b;
  uint32_t length; /* bytes of data that follow */
  int32_t pid;
};

struct wire_reply {
  int32_t result; /* >= 0, or a negative errno; for LOAD and STORE a wire_bus number */
  uint32_t length;
};

struct wire_page {          /* zeros, but for the first request: the line */
  uint32_t asked, answered; /* how many requests of the line */
  struct wire_request request;
  char data[512]; /* at most 64 descriptors, 128 bytes of a write() */
  int32_t result;
  uint32_t length; /* bytes of states */
  struct wire_now now;
  char states[1024];
};

enum wire_bus { WIRE_BUS_OK = 0, WIRE_BUS_TIMEOUT = 1, WIRE_BUS_ERROR = 2 };

#endif
