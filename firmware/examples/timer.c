/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A program whose clock is a timer of the system: SIGALRM every 5 ms, one axis' setpoint each time,
 * and its position 0.8 s long.
 *
 *	cc $(mmcs exec --cflags --modern) timer.c -o timer
 *	mmcs exec --lockstep --scenario lab500 -- ./timer
 */
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/mcdef.h>
#include <sys/mmcs.h>
#include <sys/time.h>
#include <unistd.h>

static void check(int result, const char *what) {
  if (result >= 0) return;
  perror(what);
  exit(1);
}

static void tick(int number) {
  (void)number;
}

int main(void) {
  struct itimerval every = {{0, 5000}, {0, 5000}};
  struct mc_param param = {.which = 0};
  struct mc_state state;
  sigset_t alarm_only, before;
  int fd;
  check(fd = open("/dev/mc0", O_RDWR), "/dev/mc0");
  check(ioctl(fd, MGETPARAM, &param), "MGETPARAM");
  param.mode = MD_POS;
  param.a0 = 7309; /* from sim/robots/lab500.toml */
  param.a1 = -7027;
  param.b0 = 64;
  check(ioctl(fd, MSETPARAM, &param), "MSETPARAM");
  check(ioctl(fd, MENABLE), "MENABLE");
  (void)signal(SIGALRM, tick);
  sigemptyset(&alarm_only);
  sigaddset(&alarm_only, SIGALRM);
  sigprocmask(SIG_BLOCK, &alarm_only, &before); /* it comes in sigsuspend() alone */
  check(setitimer(ITIMER_REAL, &every, NULL), "setitimer");
  for (int n = 0; n < 160; n++) {
    struct mmcs_setpoint one = {0, n < 80 ? 5 * n : 5 * (160 - n)};
    sigsuspend(&before);
    check(ioctl(fd, MSETPOINT, &one), "MSETPOINT");
    check((int)read(fd, &state, sizeof state), "read");
    printf("%d %d\n", one.value, state.encnow);
  }
  check(ioctl(fd, MSTOP), "MSTOP");
  return 0;
}
