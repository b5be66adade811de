/* SPDX-License-Identifier: Apache-2.0 */
/* The device by every call that a C program may use for a file, and what <sys/mmcs.h> adds, §2.3: a
 * line for each that went wrong, and "done". */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include "mcdef.h"

#include <sys/mmcs.h>

#define EXPECT(truth) \
  if (!(truth)) printf("line %d: %s (errno %d)\n", __LINE__, #truth, errno)

#define BAD ((void *)16)

/* No reason before a call is refused, then the sentence; and how the machine stands. */
static void reasons(void) {
  char why[MWHY_SIZE];
  struct mmcs_status s;
  int joints = 99, fd = open("/dev/mc0", O_RDWR);
  EXPECT(ioctl(fd, MWHY, why) == 0 && why[0] == 0);
  EXPECT(ioctl(fd, MSETNUMJOINTS, &joints) < 0 && ioctl(fd, MWHY, why) == 0);
  EXPECT(strcmp(why, "MSETNUMJOINTS: 99: negative, or more than found") == 0);
  EXPECT(sizeof s == 32 && ioctl(fd, MSTATUS, &s) == 0 && !s.enabled && !s.stopped);
  EXPECT(s.cause == MCAUSE_NONE && s.number == -1 && close(fd) == 0);
}

/* A close has happened when it returns: a program that opens again at once finds the defaults. */
static void reopened(void) {
  for (int round = 0; round < 200; round++) {
    int fd = open("/dev/mc0", O_RDWR), verbosity = M_ERRORPRINT, found = -1;
    EXPECT(ioctl(fd, MSETVERBOSITY, &verbosity) == 0 && close(fd) == 0);
    fd = open("/dev/mc0", O_RDWR);
    EXPECT(ioctl(fd, MGETVERBOSITY, &found) == 0 && found == 0 && close(fd) == 0);
  }
}

static int lease(int fd, int take) {
  return ioctl(fd, MLEASE, &take) == 0 ? 0 : errno;
}

static void leases(void) {
  int mine = open("/dev/mc0", O_RDWR), other = open("/dev/mc0", O_RDWR);
  int monitor = open("/dev/mc0", O_RDONLY), joints = 1;
  EXPECT(lease(monitor, 1) == EBADF && lease(mine, 2) == EINVAL);
  EXPECT(lease(mine, 1) == 0 && lease(mine, 1) == 0);
  EXPECT(lease(other, 1) == EBUSY && lease(other, 0) == 0);
  EXPECT(ioctl(mine, MLEASE, BAD) < 0 && errno == EFAULT);
  EXPECT(ioctl(mine, MSETNUMJOINTS, &joints) == 0);
  EXPECT(ioctl(other, MSETNUMJOINTS, &joints) < 0 && errno == EBUSY);
  EXPECT(ioctl(other, MSTOP, NULL) == 0); /* whoever has the lease */
  EXPECT(close(mine) == 0 && ioctl(other, MSETNUMJOINTS, &joints) == 0);
  EXPECT(lease(other, 1) == 0 && lease(other, 0) == 0);
  EXPECT(close(other) == 0 && close(monitor) == 0);
}

static void paths(void) {
  struct stat status;
  EXPECT(stat("/dev/mc0", &status) == 0 && S_ISCHR(status.st_mode));
  EXPECT(lstat("/dev/vme16", &status) == 0 && S_ISCHR(status.st_mode));
  EXPECT(fstatat(AT_FDCWD, "/dev/mc0", &status, 0) == 0 && S_ISCHR(status.st_mode));
  EXPECT(stat("/dev/null", &status) == 0 && stat("/dev/mcx", &status) < 0);
  EXPECT(access("/dev/mc0", R_OK | W_OK) == 0);
  EXPECT(access("/dev/mc0", X_OK) < 0 && errno == EACCES);
  EXPECT(faccessat(AT_FDCWD, "/dev/mc0", R_OK, 0) == 0);
}

static void vectors(int fd) {
  int one[2] = {30, 0}, none[64] = {0};
  struct mc_state a, b;
  struct iovec out[2] = {{&one[0], 4}, {&one[1], 4}}, in[2] = {{&a, sizeof(a)}, {&b, sizeof(b)}};
  EXPECT(writev(fd, out, 2) == 8);
  out[1].iov_base = none;
  out[1].iov_len = sizeof(none);
  EXPECT(writev(fd, out, 2) < 0 && errno == EINVAL);
  EXPECT(readv(fd, in, 2) == (ssize_t)sizeof(a) && a.errcode == 0);
  EXPECT(pread(fd, &a, sizeof(a), 100) < 0 && errno == ESPIPE);
}

/* As the kernel answers: nothing is touched, and nothing asked of the driver. */
static void bad_pointers(int fd) {
  int one = 30;
  struct mc_state a;
  struct iovec out[2] = {{&one, 4}, {BAD, 4}}, in[2] = {{&a, sizeof(a)}, {BAD, sizeof(a)}};
  struct iovec constant = {(void *)(uintptr_t)"constant, which no state may overwrite", sizeof(a)};
  EXPECT(writev(fd, out, 2) < 0 && errno == EFAULT);
  EXPECT(readv(fd, in + 1, 1) < 0 && errno == EFAULT);
  EXPECT(readv(fd, &constant, 1) < 0 && errno == EFAULT);
  out[0].iov_len = SIZE_MAX;
  EXPECT(writev(fd, out, 1) < 0 && errno == EINVAL);
  EXPECT(stat("/dev/mc0", BAD) < 0 && errno == EFAULT);
  EXPECT(read(fd, BAD, sizeof(a)) < 0 && errno == EFAULT);
  EXPECT(write(fd, BAD, 4) < 0 && errno == EFAULT);
  EXPECT(ioctl(fd, MGETPARAM, BAD) < 0 && errno == EFAULT);
  EXPECT(ioctl(fd, MSETPARAM, NULL) < 0 && errno == EFAULT);
  EXPECT(ioctl(fd, TCGETS, &a) < 0 && errno == ENOTTY);
  EXPECT(read(fd, &a, sizeof(a) - 1) < 0 && errno == EINVAL);
}

static void read_only(void) {
  int fd = open("/dev/mc0", O_RDONLY), one = 30;
  EXPECT(ioctl(fd, MENABLE, NULL) < 0 && errno == EBADF);
  EXPECT(write(fd, &one, 4) < 0 && errno == EBADF);
  EXPECT(open("/dev/mc7", O_RDWR) < 0 && errno == ENXIO);
  close(fd);
}

static void streams(void) {
  struct mc_state state[2];
  int setpoints[2] = {10, 20}, cards = 0, three[3] = {0};
  FILE *file = fopen("/dev/mc0", "r+");
  EXPECT(file != NULL);
  EXPECT(fwrite(setpoints, sizeof(int), 2, file) == 2 && fflush(file) == 0);
  EXPECT(fread(state, sizeof(state[0]), 2, file) == 2 && state[1].errcode == 0);
  EXPECT(ioctl(fileno(file), MGETNUMCARDS, &cards) == 0 && cards == 1);
  EXPECT(fread(state, sizeof(state[0]), 1, file) == 1); /* both were read ahead */
  EXPECT(fwrite(setpoints, sizeof(int), 2, file) == 2 && fflush(file) == 0);
  EXPECT(fseek(file, 0, SEEK_SET) == 0 && fread(state, sizeof(state[0]), 2, file) == 2);
  EXPECT(fwrite(three, sizeof(int), 3, file) == 3 && fflush(file) == EOF && ferror(file));
  (void)fclose(file);
  file = fopen("/dev/mc0", "r");
  EXPECT(setvbuf(file, NULL, _IONBF, 0) == 0);
  for (int i = 0; i < 2; i++) {
    EXPECT(fread(state, sizeof(state[0]), 2, file) == 2 && !ferror(file));
    EXPECT(fread(state, sizeof(state[0]), 1, file) == 1);
    EXPECT(fread(state, sizeof(state[0]) - 1, 1, file) == 0 && errno == EINVAL && ferror(file));
    clearerr(file);
    EXPECT(getc(file) == EOF && errno == EINVAL);
    clearerr(file);
  }
  (void)fclose(file);
  file = fdopen(open("/dev/mc0", O_RDWR), "w");
  EXPECT(file != NULL && fwrite(setpoints, sizeof(int), 2, file) == 2 && fclose(file) == 0);
  EXPECT(fopen("/dev/mc9", "r") == NULL && errno == ENXIO);
  EXPECT(fopen("/dev/mc0", "q") == NULL && errno == EINVAL);
}

/* A mapping outlives its descriptor. */
static void window(void) {
  int fd = open("/dev/vme16", O_RDWR), first = dup(fd);
  volatile uint8_t *reg = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0x6000);
  EXPECT(reg != MAP_FAILED && close(fd) == 0 && close(first) == 0);
  EXPECT((reg[0x409] & 0x1F) == 0x18);
  EXPECT(munmap((void *)(uintptr_t)reg, 4096) == 0);
  fd = open("/dev/vme16", O_RDONLY);
  EXPECT(mmap(NULL, 4096, PROT_WRITE, MAP_SHARED, fd, 0x6000) == MAP_FAILED && errno == EACCES);
  reg = mmap(NULL, 4096, PROT_READ, MAP_SHARED, fd, 0x6000);
  EXPECT(reg != MAP_FAILED && munmap((void *)(uintptr_t)reg, 4096) == 0 && close(fd) == 0);
  fd = open("/dev/vme16", O_RDWR);
  EXPECT(fd <= first && close(fd) == 0); /* nothing is left open */
}

int main(void) {
  int fd, number = 5;
  (void)signal(SIGPIPE, SIG_IGN);
  reasons();
  reopened();
  leases();
  paths();
  fd = open("/dev/mc0", O_RDWR);
  vectors(fd);
  bad_pointers(fd);
  read_only();
  streams();
  window();
  EXPECT(mmap(NULL, 4096, PROT_READ, MAP_SHARED, fd, 0) == MAP_FAILED && errno == ENODEV);
  (void)clearenv();
  EXPECT(ioctl(fd, MGETNUMCARDS, &number) == 0 && number == 1);
  number = open("/dev/mc0", O_RDONLY);
  EXPECT(number >= 0);
  /* what goes past the library is not lost in silence */
  EXPECT(syscall(SYS_write, fd, &number, 4) < 0 && errno == EPIPE);
  EXPECT(ioctl(fd, MGETNUMCARDS, &number) == 0);
  printf("done\n");
  return 0;
}
