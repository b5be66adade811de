/* SPDX-License-Identifier: Apache-2.0 */
/* Two threads of one process use one descriptor at once, §2.3: one sets parameters and reads them
 * back, the other reads states. Prints "N rounds", or what went wrong and exits with 1. */
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "mcdef.h"

#define ROUNDS 200

static int fd;

static void *parameters(void *arg) {
  struct mc_param set, got;
  for (int round = 1; round <= ROUNDS; round++) {
    memset(&set, 0, sizeof(set));
    set.which = 1;
    if (ioctl(fd, MGETPARAM, &set) < 0) return "get";
    set.a0 = round;
    if (ioctl(fd, MSETPARAM, &set) < 0) return "set";
    memset(&got, 0, sizeof(got));
    got.which = 1;
    if (ioctl(fd, MGETPARAM, &got) < 0) return "get again";
    if (memcmp(&set, &got, sizeof(set)) != 0) return "another answer than was set";
  }
  return arg;
}

static void *states(void *arg) {
  struct mc_state state[2];
  unsigned interval;
  for (int round = 0; round < 2 * ROUNDS; round++) {
    memset(state, 0x55, sizeof(state));
    if (read(fd, state, sizeof(state)) != sizeof(state)) return "read";
    if (state[1].adcvai == 0x55555555 || state[0].errcode != 0) return "not a state";
    if (ioctl(fd, MGETINTERVAL, &interval) < 0 || interval != 2000) return "interval";
  }
  return arg;
}

int main(void) {
  pthread_t thread[2];
  void *wrong[2] = {NULL, NULL};
  fd = open("/dev/mc0", O_RDWR);
  if (fd < 0) return perror("/dev/mc0"), 1;
  (void)pthread_create(&thread[0], NULL, parameters, NULL);
  (void)pthread_create(&thread[1], NULL, states, NULL);
  for (int i = 0; i < 2; i++) {
    (void)pthread_join(thread[i], &wrong[i]);
    if (wrong[i] != NULL) return printf("thread %d: %s\n", i, (char *)wrong[i]), 1;
  }
  printf("%d rounds\n", ROUNDS);
  return 0;
}
