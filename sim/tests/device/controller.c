/* SPDX-License-Identifier: Apache-2.0 */
/* One of three processes, §2.3: "controller" enables and moves until it is killed, "monitor" only
 * reads. Prints a line when it is under way; exits with 1 on an error that it does not expect. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "mcdef.h"

static int control(int fd, long round) {
  int setpoint[2] = {(int)(round % 400), -(int)(round % 300)};
  return (int)write(fd, setpoint, sizeof(setpoint));
}

int main(int ac, char **av) {
  struct mc_state state[2];
  struct mc_param param;
  int controls = ac > 1 && strcmp(av[1], "controller") == 0;
  int fd = open("/dev/mc0", controls ? O_RDWR : O_RDONLY);
  long round;
  if (fd < 0) return perror("open"), 1;
  if (controls) {
    for (param.which = 0; param.which < 2; param.which++) {
      if (ioctl(fd, MGETPARAM, &param) < 0) return perror("get"), 1;
      param.mode = MD_POS;
      if (ioctl(fd, MSETPARAM, &param) < 0) return perror("set"), 1;
    }
    if (ioctl(fd, MENABLE) < 0 && errno != EBUSY) return perror("enable"), 1;
  }
  for (round = 0;; round++) {
    if (read(fd, state, sizeof(state)) != sizeof(state)) return perror("read"), 1;
    if (controls && control(fd, round) < 0) return perror("write"), 1;
    if (round == 0) puts("going"), fflush(stdout);
  }
}
