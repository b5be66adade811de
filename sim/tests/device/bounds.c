/* SPDX-License-Identifier: Apache-2.0 */
/* A server that lies about its answers reaches nothing beyond what was asked for: prints the errno
 * of each call, and whether the bytes around its buffer are what they were. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "mcdef.h"

int main(void) {
  static char room[8192];
  int fd, touched = 0, calls;
  fd = open("/dev/mc0", O_RDWR);
  memset(room, 0x5A, sizeof(room));
  for (calls = 0; calls < 3; calls++) {
    long result = calls == 1 ? ioctl(fd, MGETNUMCARDS, room + 4096) : read(fd, room + 4096, 28);
    printf("%ld %d\n", result, result < 0 ? errno : 0);
  }
  for (unsigned i = 0; i < sizeof(room); i++)
    if (room[i] != 0x5A && (i < 4096 || i >= 4096 + 28)) touched = 1;
  printf("touched %d\n", touched);
  return 0;
}
