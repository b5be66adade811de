/* SPDX-License-Identifier: Apache-2.0 */
/* Keeps the program counter of this process at regular intervals of its CPU time. Linux; x86-64 and
 * 64-bit ARM. See shares.py. */
#define _GNU_SOURCE
#include <signal.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/time.h>
#include <ucontext.h>

static uint64_t *place;
static volatile int count;
static int most;

static void keep(int signal_number, siginfo_t *info, void *context) {
  (void)signal_number;
  (void)info;
  const ucontext_t *uc = context;
  if (count >= most) return;
#if defined(__x86_64__)
  place[count++] = (uint64_t)uc->uc_mcontext.gregs[REG_RIP];
#elif defined(__aarch64__)
  place[count++] = uc->uc_mcontext.pc;
#else
  (void)uc;
#endif
}

static int every(long us) {
  const struct itimerval timer = {{0, us}, {0, us}};
  return setitimer(ITIMER_PROF, &timer, NULL);
}

/* Room for n samples, so many a second. 0, or -1. */
int sampler_start(uint64_t *samples, int n, int hz) {
  struct sigaction action = {.sa_sigaction = keep, .sa_flags = SA_SIGINFO | SA_RESTART};
  place = samples;
  most = n;
  count = 0;
#if !defined(__x86_64__) && !defined(__aarch64__)
  return -1;
#endif
  if (sigaction(SIGPROF, &action, NULL)) return -1;
  return every(1000000 / hz);
}

int sampler_count(void) {
  return count;
}

/* The number of samples. */
int sampler_stop(void) {
  every(0);
  signal(SIGPROF, SIG_IGN);
  return count;
}
