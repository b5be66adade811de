/* SPDX-License-Identifier: Apache-2.0 */
/* The devices as files, for the calls that never reach open(), read() and write() of preload.c:
 * stat and access of the path, vectors of buffers, and stdio, which calls the kernel by itself,
 * §2.3.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdio_ext.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include "device.h"

#define MOST 4096 /* bytes of one call, as in preload.c */

/* --- stat, access ---------------------------------------------------------------------- */

int fstatat(int folder, const char *path, struct stat *status, int flags) {
  struct stat found = {.st_mode = S_IFCHR | 0600, .st_nlink = 1, .st_blksize = MOST};
  if (!device_is_path(path)) return (int)syscall(SYS_newfstatat, folder, path, status, flags);
  found.st_uid = getuid();
  return device_fail(device_copy(status, &found, sizeof(found)));
}
int stat(const char *path, struct stat *status) {
  return fstatat(AT_FDCWD, path, status, 0);
}
int lstat(const char *path, struct stat *status) {
  return fstatat(AT_FDCWD, path, status, AT_SYMLINK_NOFOLLOW);
}
SAME(stat64, stat);
SAME(lstat64, lstat);
SAME(fstatat64, fstatat);

int faccessat(int folder, const char *path, int mode, int flags) {
  if (!device_is_path(path)) return REAL(faccessat)(folder, path, mode, flags);
  return device_fail(mode & X_OK ? -EACCES : 0);
}
int access(const char *path, int mode) {
  return faccessat(AT_FDCWD, path, mode, 0);
}

/* --- vectors --------------------------------------------------------------------------- */

ssize_t writev(int fd, const struct iovec *vector, int count) {
  const ino_t file = wire_file(fd);
  char data[MOST];
  size_t done = 0;
  if (file == 0) return syscall(SYS_writev, fd, vector, count);
  for (int i = 0; i < count; done += vector[i++].iov_len) {
    if (vector[i].iov_len > MOST - done) return device_fail(-EINVAL);
    if (device_copy(data + done, vector[i].iov_base, vector[i].iov_len) < 0)
      return device_fail(-EFAULT);
  }
  return device_fail((int)device_write(file, data, done));
}

/* The first buffer: a read may give less than was asked for. */
ssize_t readv(int fd, const struct iovec *vector, int count) {
  if (wire_file(fd) == 0) return syscall(SYS_readv, fd, vector, count);
  return read(fd, vector->iov_base, vector->iov_len);
}

/* --- stdio ------------------------------------------------------------------------------ */

/* Buffered as on any device: a read takes the states of all axes, a write goes out with fflush().
 * The cookie of such a stream is its descriptor. */
static int fd_of(void *cookie) {
  return (int)(intptr_t)cookie;
}

static ssize_t stream_read(void *cookie, char *buffer, size_t length) {
  return read(fd_of(cookie), buffer, length);
}

static ssize_t stream_write(void *cookie, const char *buffer, size_t length) {
  ssize_t n = write(fd_of(cookie), buffer, length);
  return n < 0 ? 0 : n; /* as fopencookie() wants to hear it; errno stands */
}

/* To any place: what was read ahead is old then, and the next read takes a new sample. */
static int stream_seek(void *cookie, off64_t *place, int whence) {
  if (wire_file(fd_of(cookie)) == 0) return (int)lseek(fd_of(cookie), *place, whence);
  *place = 0;
  return 0;
}

static int stream_close(void *cookie) {
  return close(fd_of(cookie));
}

FILE *device_stream(int fd, const char *mode) {
  static const cookie_io_functions_t calls = {stream_read, stream_write, stream_seek, stream_close};
  FILE *file = fopencookie((void *)(intptr_t)fd, mode, calls);
  if (file != NULL) file->_fileno = fd;
  return file;
}

/* Unbuffered, the library reads a file in one piece, but such a stream byte by byte. */
size_t fread(void *to, size_t size, size_t n, FILE *file) {
  ssize_t got;
  if (size == 0 || n == 0 || n > SSIZE_MAX / size || __fbufsize(file) != 1 ||
      wire_file(fileno(file)) == 0)
    return REAL(fread)(to, size, n, file);
  got = read(fileno(file), to, size * n);
  if (got < 0) file->_flags |= _IO_ERR_SEEN;
  return got < 0 ? 0 : (size_t)got / size;
}
size_t __fread_chk(void *to, size_t room, size_t size, size_t n, FILE *file);
size_t __fread_chk(void *to, size_t room, size_t size, size_t n, FILE *file) {
  if (size > 0 && n > room / size) abort();
  return fread(to, size, n, file);
}
SAME(fread_unlocked, fread);

static int flags_of(const char *mode) {
  int cloexec = strchr(mode, 'e') != NULL ? O_CLOEXEC : 0;
  if (strchr(mode, '+') != NULL) return O_RDWR | cloexec;
  return (*mode == 'r' ? O_RDONLY : O_WRONLY) | cloexec;
}

static FILE *open_stream(const char *path, const char *mode) {
  int fd = device_fail(strchr("rwa", *mode) && *mode ? wire_open(path, flags_of(mode)) : -EINVAL);
  FILE *file = fd < 0 ? NULL : device_stream(fd, mode);
  if (fd >= 0 && file == NULL) (void)close(fd);
  return file;
}

FILE *fopen(const char *path, const char *mode) {
  if (device_is_path(path)) return open_stream(path, mode);
  return REAL(fopen)(path, mode);
}
SAME(fopen64, fopen);

FILE *fdopen(int fd, const char *mode) {
  if (wire_file(fd) != 0) return device_stream(fd, mode);
  return REAL(fdopen)(fd, mode);
}
