/* SPDX-License-Identifier: Apache-2.0 */
/* A program takes the lease of the machine: a line for each call that went otherwise than told, and
 * "done". */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <sys/mcdef.h>
#include <sys/mmcs.h>
#include <unistd.h>

static int lease(int fd, int take) {
  return ioctl(fd, MLEASE, &take) == 0 ? 0 : errno;
}

static void expect(const char *what, int got, int want) {
  if (got != want) printf("%s: errno %d, not %d\n", what, got, want);
}

int main(void) {
  int mine = open("/dev/mc0", O_RDWR), other = open("/dev/mc0", O_RDWR);
  int monitor = open("/dev/mc0", O_RDONLY), joints = 1;
  expect("a monitor takes it", lease(monitor, 1), EBADF);
  expect("take", lease(mine, 1), 0);
  expect("take twice", lease(mine, 1), 0);
  expect("another takes it", lease(other, 1), EBUSY);
  expect("another gives it up", lease(other, 0), 0);
  expect("a number", lease(mine, 2), EINVAL);
  expect("a bad pointer", ioctl(mine, MLEASE, (int *)1) == 0 ? 0 : errno, EFAULT);
  expect("mine", ioctl(mine, MSETNUMJOINTS, &joints) == 0 ? 0 : errno, 0);
  expect("another's", ioctl(other, MSETNUMJOINTS, &joints) == 0 ? 0 : errno, EBUSY);
  expect("another stops", ioctl(other, MSTOP) == 0 ? 0 : errno, 0);
  close(mine);
  expect("after the end of the holder", ioctl(other, MSETNUMJOINTS, &joints) == 0 ? 0 : errno, 0);
  expect("take again", lease(other, 1), 0);
  expect("drop", lease(other, 0), 0);
  printf("done\n");
  return 0;
}
