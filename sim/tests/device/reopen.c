/* SPDX-License-Identifier: Apache-2.0 */
/* A close has happened when it returns, §2.3: who opens again at once finds the defaults. Prints
 * how often. */
#include <fcntl.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "mcdef.h"

int main(void) {
  int fresh = 0, round;
  for (round = 0; round < 200; round++) {
    int fd = open("/dev/mc0", O_RDWR), verbosity = M_ERRORPRINT, found = -1;
    if (ioctl(fd, MSETVERBOSITY, &verbosity) < 0) return perror("set"), 1;
    close(fd);
    fd = open("/dev/mc0", O_RDWR);
    if (ioctl(fd, MGETVERBOSITY, &found) < 0) return perror("get"), 1;
    fresh += found == 0;
    close(fd);
  }
  printf("%d\n", fresh);
  return 0;
}
