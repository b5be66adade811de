/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A sine of 200 counts at 2 Hz on axis 0, and what the axis made of it: C of today, no threads, no
 * timers. MWAIT is its clock: a line for each servo sample.
 *
 *	cc $(mmcs exec --cflags --modern) sine.c -o sine -lm
 *	mmcs exec --lockstep --scenario lab500 -- ./sine > sine.csv    the same to the bit each time
 *	mmcs exec --realtime --scenario lab500 -- ./sine               in real time
 */
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/mcdef.h>
#include <sys/mmcs.h>
#include <unistd.h>

#define INTERVAL_US 1000
#define SAMPLES 1000

static int fd;

static void check(int result, const char *what) {
  if (result >= 0) return;
  perror(what);
  exit(1);
}

/* Waits for the next servo sample: its number. */
static int sample(void) {
  int number;
  check(ioctl(fd, MWAIT, &number), "MWAIT");
  return number;
}

int main(void) {
  const double turn = 6.283185307179586, hz = 2.0;
  struct mc_param param = {.which = 0};
  int joints = 1, interval = INTERVAL_US, zero[1] = {0};

  check(fd = open("/dev/mc0", O_RDWR), "/dev/mc0");
  check(ioctl(fd, MSETNUMJOINTS, &joints), "MSETNUMJOINTS");
  check(ioctl(fd, MSETINTERVAL, &interval), "MSETINTERVAL");
  check(ioctl(fd, MGETPARAM, &param), "MGETPARAM"); /* Table 2.1, mode off */
  param.mode = MD_POS | COULCOMP;
  param.a0 = 7309; /* from sim/robots/lab500.toml */
  param.a1 = -7027;
  param.b0 = 64;
  param.ic_pos = param.ic_neg = 84;
  check(ioctl(fd, MSETPARAM, &param), "MSETPARAM");
  check((int)write(fd, zero, sizeof zero), "write");
  check(ioctl(fd, MENABLE), "MENABLE");

  printf("sample,setpoint,encoder,current\n");
  for (int begin = sample(), now = begin; now - begin < SAMPLES; now = sample()) {
    struct mc_state state;
    int setpoint = (int)lround(200 * sin(turn * hz * (now - begin) * INTERVAL_US * 1e-6));
    check((int)write(fd, &setpoint, sizeof setpoint), "write");
    check((int)read(fd, &state, sizeof state), "read");
    printf("%d,%d,%d,%d\n", now - begin, setpoint, state.encnow, state.inow);
  }
  check(ioctl(fd, MSTOP), "MSTOP");
  return 0;
}
