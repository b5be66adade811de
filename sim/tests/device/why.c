/* SPDX-License-Identifier: Apache-2.0 */
/* Why a call was refused: nothing before one is, then the sentence; and how the machine stands. */
#include <fcntl.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <sys/mcdef.h>
#include <sys/mmcs.h>

int main(void) {
  char before[MWHY_SIZE], after[MWHY_SIZE];
  struct mmcs_status s;
  int cards, joints = 99, fd = open("/dev/mc0", O_RDWR);
  if (fd < 0 || ioctl(fd, MGETNUMCARDS, &cards) < 0 || ioctl(fd, MWHY, before) < 0) return 1;
  if (ioctl(fd, MSETNUMJOINTS, &joints) == 0 || ioctl(fd, MWHY, after) < 0) return 2;
  if (sizeof s != 32 || ioctl(fd, MSTATUS, &s) < 0) return 3;
  printf("[%s] %s\n", before, after);
  printf("enabled %d stopped %d cause %d axis %d\n", s.enabled, s.stopped, s.cause == MCAUSE_NONE,
         s.number);
  return 0;
}
