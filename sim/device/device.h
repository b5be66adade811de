/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the preload library know of each other. */
#ifndef MMCS_DEVICE_H
#define MMCS_DEVICE_H

#include <dlfcn.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/types.h>
#include <time.h>

#include "wire.h"

#define SECOND 1000000000u
#define EPOCH 599616000u /* of the clocks: machine time 0 is 1 January 1989, 0:00 UTC */

/* The C library's own, found once. */
#define REAL(name)                       \
  ({                                     \
    static void *real_;                  \
    lock_find(&real_, #name);            \
    (__typeof__(&name))(uintptr_t)real_; \
  })
void lock_find(void **real, const char *name);

/* A call of the C library: what follows is it for threads in lock-step, all others have the C
 * library's own. */
#define CALL(result, name, parameters, arguments)                           \
  static result name##_in_lockstep parameters;                              \
  result name parameters {                                                  \
    return lock_on() ? name##_in_lockstep arguments : REAL(name) arguments; \
  }                                                                         \
  static result name##_in_lockstep parameters

/* Another name of a function: of its form for large files, which is the same where a long has 64
 * bits, or of what the fortified headers call. */
#define SAME(name, as) __asm__(".globl " #name "\n.set " #name ", " #as)
_Static_assert(sizeof(long) == 8, "a long has 64 bits");

/* --- wire.c: the client's end --- */

/* Opens a device: a descriptor that stands for it, or a negative errno. */
int wire_open(const char *path, int flags);
/* The file's inode if fd is one of ours, else 0. errno is kept. */
ino_t wire_file(int fd);
/* One call. out_length: in: room, out: bytes received, never more. Returns the result; -EIO when
 * the server is gone or answers nonsense; -EINTR when it answers nothing and a signal was handled.
 */
int wire_call(uint32_t op, ino_t file, uint64_t a, uint64_t b, const void *data, uint32_t length,
              void *out, uint32_t *out_length);
/* A connection to the server, or a negative errno. */
int wire_connect(int cloexec);
/* A request, in one piece: 0, or -1. */
int wire_ask(int fd, uint32_t op, ino_t file, uint64_t a, uint64_t b, const void *data,
             uint32_t length);
extern pid_t wire_pid; /* this process */
/* How many calls this process has made: each may have taken machine time. And without those that
 * change nothing but setpoints. */
extern unsigned long wire_calls, wire_others;

/* --- preload.c: the calls of a program on an open device --- */

/* The size and direction that mcdef.h puts into a request number, as 4.2BSD did. */
#define REQUEST_SIZE(r) (((r) >> 16) & 0x1FFFu)
#define REQUEST_IN(r) (((r) & 0x80000000u) != 0)
#define REQUEST_OUT(r) (((r) & 0x40000000u) != 0)

ssize_t device_read(ino_t file, void *buffer, size_t length);
ssize_t device_write(ino_t file, const void *buffer, size_t length);
/* 1 if the path names a device that may be opened here. */
int device_is_path(const char *path);
/* files.c: a stream that reads and writes a descriptor by the calls here. */
FILE *device_stream(int fd, const char *mode);
/* The result of a call, or -1 and errno from a negative one. */
int device_fail(int result);

/* --- vme_map.c: accesses that fault, of the mapped window of /dev/vme16 --- */

/* To or from the program's memory, which may not be there: 0, or -EFAULT. Onto itself, before the
 * server does what cannot be undone: whether it can be written. */
int device_copy(void *to, const void *from, size_t length);
void *vme_map(void *address, uint64_t length, int prot, int fd, int64_t offset, ino_t file);
/* 1 if the range belonged to a window and was unmapped. */
int vme_unmap(void *address, uint64_t length);

/* --- lockstep.c: waiting in lock-step ---
 *
 * Of all threads of all attached programs one runs at a time. Whoever would wait says so on its
 * line and is answered when it may go on; the server lets machine time pass when nobody runs. */

/* With `what`: after a signal whose handler was installed with SA_RESTART it goes on. */
#define LOCK_RESTARTS 0x100u

/* 1: this thread is attached. */
int lock_on(void);
uint64_t lock_now(void);
/* Waits; files may be null. `mask` is what the call sets meanwhile, or null. Signals that come are
 * handled before it returns CAUSE_SIGNAL, unless `keep`: those stay pending. */
int lock_wait(unsigned what, uint64_t until, const void *key, const int *files, unsigned count,
              const sigset_t *mask, int keep);
/* A call that asks for what is new, or waits for no time. A loop of them waits for something: every
 * hundredth since the thread has waited takes 100 us, as a hundred do on a computer. */
void lock_polls(void);
/* A request without data, which does not wait. */
int lock_tell(uint32_t op, uint64_t a, uint64_t b);
/* The new thread's first act, with a number; of a program, 0. And its last. */
void lock_begin_thread(unsigned number);
void lock_end_thread(void);

/* MWAIT. Elsewhere it is a request as any, which the server answers late. */
int lock_sample(void *number);
/* A read(), with request 0, or a request whose argument only comes out: its bytes if they are known
 * from before, else 0. And what the server has answered to one. */
int lock_known(ino_t file, uint32_t request, void *data, uint32_t asked);
void lock_learn(ino_t file, uint32_t request, const void *data, uint32_t asked, int length);
/* 1: the server will find these bytes, and write() succeeds. */
int lock_write_later(ino_t file, const void *data, uint32_t length);
/* Before a call to the server: it must not overtake such a write(). */
void lock_write_first(void);
/* After it, when it may have taken machine time. */
void lock_after_call(void);
/* What a call that takes long lets through, if not all that the program does. */
const sigset_t *lock_late(const sigset_t *before);

struct timespec lock_span(uint64_t ns);
/* Its ns; of what is too long, the most. */
uint64_t lock_ns(const struct timespec *span);
/* ns of machine time: a span from now, and a time of a clock (relative ones count from now). */
uint64_t lock_after(uint64_t ns);
uint64_t lock_until(clockid_t clock, const struct timespec *at);
/* clocks.c: does what timers do that have run out; when the next one will. */
uint64_t lock_timers(uint64_t now);
void lock_forget_timers(void);
/* A closed descriptor: what has its number next is no timer's. */
void lock_forget_file(int file);

/* --- waits.c --- */

/* Before a descriptor is read or written: waits until that does not block, for so many bytes; 0 and
 * EINTR: a signal ended the wait. */
size_t lock_await(int fd, short events);
/* Pipes as standard input and output: the C library would read and write them past us. */
void lock_take_pipes(void);

#endif
