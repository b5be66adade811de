/* SPDX-License-Identifier: Apache-2.0 */
/* Lock-step: what waits.c, sync.c and clocks.c share (lockstep.c).
 *
 * Of all threads of all attached programs one runs at a time. Whoever would wait says so on its
 * line and is answered when it may go on; the server lets machine time pass when nobody runs.
 */
#ifndef MMCS_LOCKSTEP_H
#define MMCS_LOCKSTEP_H

#include <dlfcn.h>
#include <signal.h>
#include <stdint.h>
#include <time.h>

#include "device.h"

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

/* With `what`: after a signal whose handler was installed with SA_RESTART it goes on. */
#define LOCK_RESTARTS 0x100u

/* 1: this thread is attached. */
int lock_on(void);
uint64_t lock_now(void);
/* Waits; files may be null. `mask` is what the call sets meanwhile, or null. Signals that come are
 * handled before it returns CAUSE_SIGNAL, unless `keep`: those stay pending. */
int lock_wait(unsigned what, uint64_t until, const void *key, const int *files, unsigned count,
              const sigset_t *mask, int keep);
/* A call that asks for what is new. A loop of them waits for something: every hundredth since the
 * thread has waited takes 100 us, as a hundred do on a computer. */
void lock_polls(void);
void lock_wake(const void *key, unsigned count);
/* A request without data in or out; what does not wait. */
int lock_tell(uint32_t op, uint64_t a, uint64_t b);
int lock_ask(uint32_t op, uint64_t a, uint64_t b, const void *data, uint32_t length, void *out,
             uint32_t *out_length);
/* The new thread's first act, and a thread's last. */
void lock_begin_thread(unsigned number);

struct timespec lock_span(uint64_t ns);
/* Its ns; of what is too long, the most. */
uint64_t lock_ns(const struct timespec *span);
/* ns of machine time: a span from now, and a time of a clock (relative ones count from now). */
uint64_t lock_after(uint64_t ns);
uint64_t lock_until(clockid_t clock, const struct timespec *at);

#endif
