/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Two threads: one steps the setpoint at each SIGALRM of a timer of the system, every 0.1 s, the
 * other watches every servo sample and tells how long each step took to come within five counts.
 *
 *	cc $(mmcs exec --cflags --modern) threads.c -o threads -lpthread
 *	mmcs exec --lockstep --scenario lab500 -- ./threads
 */
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/mcdef.h>
#include <sys/mmcs.h>
#include <sys/time.h>
#include <unistd.h>

static int fd;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static int goal, steps, ended; /* under the lock */

static void check(int result, const char *what) {
  if (result >= 0) return;
  perror(what);
  exit(1);
}

static void *watch(void *unused) {
  int seen = 0, settled = 0, over = 0;
  unsigned began = 0, now;
  (void)unused;
  while (!over) {
    struct mc_state state;
    check(ioctl(fd, MWAIT, &now), "MWAIT");
    check((int)read(fd, &state, sizeof state), "read");
    pthread_mutex_lock(&lock);
    if (steps != seen) {
      seen = steps;
      began = now;
      settled = 0;
    }
    if (!settled && seen > 0 && abs(goal - state.encnow) <= 5) {
      printf("step %d to %d: %u samples\n", seen, goal, now - began);
      settled = 1;
    }
    over = ended;
    pthread_mutex_unlock(&lock);
  }
  return NULL;
}

static void tick(int number) {
  (void)number;
}

int main(void) {
  struct itimerval every = {{0, 100000}, {0, 100000}};
  struct mc_param param = {.which = 0};
  sigset_t alarm_only, before;
  int interval = 1000;
  pthread_t thread;
  check(fd = open("/dev/mc0", O_RDWR), "/dev/mc0");
  check(ioctl(fd, MSETINTERVAL, &interval), "MSETINTERVAL");
  check(ioctl(fd, MGETPARAM, &param), "MGETPARAM");
  param.mode = MD_POS | COULCOMP;
  param.a0 = 7309; /* from sim/robots/lab500.toml */
  param.a1 = -7027;
  param.b0 = 64;
  param.ic_pos = param.ic_neg = 84;
  check(ioctl(fd, MSETPARAM, &param), "MSETPARAM");
  check(ioctl(fd, MENABLE), "MENABLE");
  (void)signal(SIGALRM, tick);
  sigemptyset(&alarm_only);
  sigaddset(&alarm_only, SIGALRM);
  sigprocmask(SIG_BLOCK, &alarm_only, &before); /* it comes in sigsuspend() alone */
  if (pthread_create(&thread, NULL, watch, NULL) != 0) return 1;
  check(setitimer(ITIMER_REAL, &every, NULL), "setitimer");
  for (int n = 1; n <= 8; n++) {
    sigsuspend(&before);
    pthread_mutex_lock(&lock);
    goal = n % 2 ? 100 : 0;
    steps = n;
    check((int)write(fd, &goal, sizeof goal), "write");
    pthread_mutex_unlock(&lock);
  }
  sigsuspend(&before);
  pthread_mutex_lock(&lock);
  ended = 1;
  pthread_mutex_unlock(&lock);
  pthread_join(thread, NULL);
  check(ioctl(fd, MSTOP), "MSTOP");
  return 0;
}
