/* SPDX-License-Identifier: Apache-2.0 */
/* Lets an unmodified program use /dev/mcN and /dev/vme16 of the simulator, §2.3 and §2.4.
 *
 * Loaded by LD_PRELOAD. A device is a connected socket (wire.h), so the kernel does dup, fcntl,
 * fork, close, exit, poll and select; only the calls below and those in files.c differ. Everything
 * else is passed on.
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include "include/sys/mmcs.h"
#include "device.h"

int device_is_path(const char *path) {
  if (path == NULL || strncmp(path, "/dev/", 5) != 0) return 0;
  return strcmp(path, "/dev/vme16") == 0 ||
         (strncmp(path, "/dev/mc", 7) == 0 && path[7] >= '0' && path[7] <= '9' && path[8] == '\0');
}

int device_fail(int result) {
  if (result >= 0) return result;
  errno = -result;
  return -1;
}

/* What Fig. 2.2 includes, for a compiler that runs with this library. */
static const char *header_or(const char *path) {
  const char *header = getenv("MMCS_HEADER");
  if (path == NULL || header == NULL || strcmp(path, "/usr/sys/sundev/mcdef.h") != 0) return path;
  return header;
}

/* The argument behind `last`, which not every call has: where it has none, nobody looks at it. */
#define ARGUMENT(type, last)      \
  ({                              \
    va_list list_;                \
    type found_;                  \
    va_start(list_, last);        \
    found_ = va_arg(list_, type); \
    va_end(list_);                \
    found_;                       \
  })

/* --- open ------------------------------------------------------------------------------ */

int openat(int folder, const char *path, int flags, ...) {
  if (device_is_path(path)) return device_fail(wire_open(path, flags));
  return REAL(openat)(folder, header_or(path), flags, ARGUMENT(mode_t, flags));
}
int open(const char *path, int flags, ...) {
  return openat(AT_FDCWD, path, flags, ARGUMENT(mode_t, flags));
}
SAME(openat64, openat);
SAME(open64, open);
SAME(__open_2, open);
SAME(__open64_2, open);

/* --- read, write, ioctl ---------------------------------------------------------------- */

/* An answer is believed as far as its bytes have come, and no further than was asked for. */
ssize_t device_read(ino_t file, void *buffer, size_t length) {
  char data[4096];
  uint32_t room = (uint32_t)(length < sizeof(data) ? length : sizeof(data)), asked = room;
  int result = lock_known(file, 0, data, asked);
  if (result > 0) return device_copy(buffer, data, (size_t)result) < 0 ? -EFAULT : result;
  if (device_copy(buffer, buffer, asked) < 0) return -EFAULT;
  result = wire_call(WIRE_READ, file, asked, 0, NULL, 0, data, &room);
  if (result > 0 && (uint32_t)result != room) return -EIO;
  lock_learn(file, 0, data, asked, result);
  if (result > 0 && device_copy(buffer, data, room) < 0) return -EFAULT;
  return result;
}

ssize_t device_write(ino_t file, const void *buffer, size_t length) {
  char data[4096];
  int result;
  if (length > sizeof(data)) return -EINVAL;
  if (device_copy(data, buffer, length) < 0) return -EFAULT;
  if (lock_write_later(file, data, (uint32_t)length)) return (ssize_t)length;
  result = wire_call(WIRE_WRITE, file, 0, 0, data, (uint32_t)length, NULL, NULL);
  return result > (int)length ? -EIO : result;
}

ssize_t read(int fd, void *buffer, size_t length) {
  const ino_t file = wire_file(fd);
  if (file == 0) {
    if (lock_await(fd, POLLIN) == 0) return -1;
    return syscall(SYS_read, fd, buffer, length);
  }
  return device_fail((int)device_read(file, buffer, length));
}

ssize_t __read_chk(int fd, void *buffer, size_t length, size_t size);
ssize_t __read_chk(int fd, void *buffer, size_t length, size_t size) {
  if (length > size) abort();
  return read(fd, buffer, length);
}

static ssize_t write_elsewhere(int fd, const char *from, size_t length) {
  for (size_t done = 0;;) {
    size_t most = lock_await(fd, POLLOUT), part = length - done < most ? length - done : most;
    ssize_t n = most > 0 ? syscall(SYS_write, fd, from + done, part) : -1;
    if (n < 0 && done == 0) return n;
    if (n > 0) done += (size_t)n;
    if (n < (ssize_t)part || done == length) return (ssize_t)done;
  }
}

ssize_t write(int fd, const void *buffer, size_t length) {
  const ino_t file = wire_file(fd);
  if (file == 0) return write_elsewhere(fd, buffer, length);
  return device_fail((int)device_write(file, buffer, length));
}

static int device_ioctl(ino_t file, uint32_t request, void *argument) {
  char in[256] = {0}, out[256];
  uint32_t size = REQUEST_SIZE(request), room = size;
  const int only_out = REQUEST_OUT(request) && !REQUEST_IN(request) && request != MWHY;
  int result;
  if (size > sizeof(in)) return -ENOTTY;
  if (request == MWAIT && lock_on()) return lock_sample(argument);
  if (size > 0 && device_copy(in, argument, size) < 0) return -EFAULT;
  if (REQUEST_OUT(request) && device_copy(argument, argument, size) < 0) return -EFAULT;
  if (only_out && lock_known(file, request, out, size) > 0) return device_copy(argument, out, size);
  result = wire_call(WIRE_IOCTL, file, request, 0, in, REQUEST_IN(request) ? size : 0, out, &room);
  if (result < 0 || !REQUEST_OUT(request)) return result;
  if (room != size) return -EIO;
  if (only_out && result == 0) lock_learn(file, request, out, size, (int)size);
  return device_copy(argument, out, size) < 0 ? -EFAULT : result;
}

int ioctl(int fd, unsigned long request, ...) {
  void *argument = ARGUMENT(void *, request);
  const ino_t file = wire_file(fd);
  if (file == 0) return (int)syscall(SYS_ioctl, fd, request, argument);
  /* a request held in an int arrives sign-extended: its low 32 bits are the number */
  return device_fail(device_ioctl(file, (uint32_t)request, argument));
}

/* A write() that nobody has waited for comes before the end of the file, or of the program. */
int close(int fd) {
  lock_write_first();
  lock_forget_file(fd);
  return (int)syscall(SYS_close, fd);
}
int dup3(int fd, int to, int flags) {
  int result;
  lock_write_first();
  result = REAL(dup3)(fd, to, flags);
  if (result >= 0) lock_forget_file(to);
  return result;
}
int dup2(int fd, int to) {
  return fd == to ? REAL(dup2)(fd, to) : dup3(fd, to, 0);
}

void _exit(int status) {
  lock_write_first();
  REAL(_exit)(status);
  __builtin_unreachable();
}

/* --- fork and exec: who holds the file, for SIGUSR1. close() is the kernel's business. --- */

/* 1: it is /dev/vme16; 2: and open for writing. */
static int hold_file(ino_t file) {
  return wire_call(WIRE_HOLD, file, 0, 0, NULL, 0, NULL, NULL);
}

/* This process holds what it has inherited, by fork or across exec. */
static void hold_all(void) {
  DIR *folder = opendir("/proc/self/fd");
  struct dirent *entry;
  if (folder == NULL) return;
  while ((entry = readdir(folder)) != NULL) {
    const ino_t file = wire_file((int)strtol(entry->d_name, NULL, 10)); /* ".": 0, once more */
    if (file != 0) (void)hold_file(file);
  }
  closedir(folder);
}

__attribute__((constructor)) static void start(void) {
  pthread_atfork(NULL, NULL, hold_all);
  hold_all();
}

/* --- mmap of /dev/vme16 ---------------------------------------------------------------- */

void *mmap(void *address, size_t length, int prot, int flags, int fd, off_t offset) {
  const int shared_writes = prot & PROT_WRITE && flags & MAP_SHARED;
  const ino_t file = flags & MAP_ANONYMOUS ? 0 : wire_file(fd);
  int held;
  if (file == 0) return (void *)syscall(SYS_mmap, address, length, prot, flags, fd, offset);
  held = hold_file(file);
  if (held > shared_writes) return vme_map(address, length, prot, fd, offset, file);
  errno = held == 1 ? EACCES : ENODEV;
  return MAP_FAILED;
}

SAME(mmap64, mmap);

int munmap(void *address, size_t length) {
  if (vme_unmap(address, length)) return 0;
  return (int)syscall(SYS_munmap, address, length);
}
