/* SPDX-License-Identifier: Apache-2.0 */
/* The devices as files, for the calls that never reach open(), read() and write() of preload.c:
 * stat and access of the path, stdio (which calls the kernel by itself), vectors of buffers and
 * places, §2.3.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdio_ext.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <sys/uio.h>
#include <unistd.h>

#include "device.h"

#define MC_MAJOR 60 /* of those that are free for local use */
#define VME_MAJOR 61
#define MODE (S_IFCHR | 0600)
#define MOST 4096 /* bytes of one call, as in preload.c */

/* --- stat, access ---------------------------------------------------------------------- */

static dev_t number_of(const char *path) {
  int is_vme = path[5] == 'v';
  return makedev(is_vme ? VME_MAJOR : MC_MAJOR, is_vme ? 0u : (unsigned)(path[7] - '0'));
}

static struct stat stat_path(const char *path) {
  struct stat status = {.st_mode = MODE, .st_nlink = 1, .st_blksize = MOST};
  status.st_uid = getuid();
  status.st_gid = getgid();
  status.st_rdev = number_of(path);
  status.st_ino = status.st_rdev;
  return status;
}

/* The inode stays: it names the file to the server. */
static int stat_open(int fd, struct stat *status) {
  char name[WIRE_NAME];
  if (syscall(SYS_fstat, fd, status) < 0) return -1;
  if (wire_is_file(fd, name)) {
    status->st_mode = MODE;
    status->st_rdev = makedev(device_is_vme(name) ? VME_MAJOR : MC_MAJOR, 0);
  }
  return 0;
}

static int stat_at(int folder, const char *path, struct stat *status, int flags) {
  if (device_is_path(path)) {
    struct stat found = stat_path(path);
    return device_fail(device_copy_out(status, &found, sizeof(found)));
  }
  if ((flags & AT_EMPTY_PATH) && path != NULL && *path == '\0') return stat_open(folder, status);
  return (int)syscall(SYS_newfstatat, folder, path, status, flags);
}

int stat(const char *path, struct stat *status) {
  return stat_at(AT_FDCWD, path, status, 0);
}
int lstat(const char *path, struct stat *status) {
  return stat_at(AT_FDCWD, path, status, AT_SYMLINK_NOFOLLOW);
}
int fstat(int fd, struct stat *status) {
  return stat_open(fd, status);
}
int fstatat(int folder, const char *path, struct stat *status, int flags) {
  return stat_at(folder, path, status, flags);
}

/* Under their names for large files, which are the same where a long has 64 bits. */
_Static_assert(sizeof(struct stat) == sizeof(struct stat64), "a long has 64 bits");
int stat64(const char *path, struct stat64 *status) {
  return stat(path, (struct stat *)status);
}
int lstat64(const char *path, struct stat64 *status) {
  return lstat(path, (struct stat *)status);
}
int fstat64(int fd, struct stat64 *status) {
  return fstat(fd, (struct stat *)status);
}
int fstatat64(int folder, const char *path, struct stat64 *status, int flags) {
  return fstatat(folder, path, (struct stat *)status, flags);
}

/* What programs call that were linked before stat() was a function of the C library. */
int __xstat(int version, const char *path, struct stat *status);
int __xstat(int version, const char *path, struct stat *status) {
  return (void)version, stat(path, status);
}
int __lxstat(int version, const char *path, struct stat *status);
int __lxstat(int version, const char *path, struct stat *status) {
  return (void)version, lstat(path, status);
}
int __fxstat(int version, int fd, struct stat *status);
int __fxstat(int version, int fd, struct stat *status) {
  return (void)version, fstat(fd, status);
}

int statx(int folder, const char *restrict path, int flags, unsigned mask,
          struct statx *restrict status) {
  struct statx found = {.stx_mode = MODE, .stx_nlink = 1};
  struct stat plain;
  if (!device_is_path(path)) return (int)syscall(SYS_statx, folder, path, flags, mask, status);
  plain = stat_path(path);
  found.stx_mask = STATX_TYPE | STATX_MODE | STATX_NLINK | STATX_UID | STATX_GID | STATX_INO;
  found.stx_uid = plain.st_uid;
  found.stx_gid = plain.st_gid;
  found.stx_ino = plain.st_ino;
  found.stx_rdev_major = major(plain.st_rdev);
  found.stx_rdev_minor = minor(plain.st_rdev);
  return device_fail(device_copy_out(status, &found, sizeof(found)));
}

static int access_device(int mode) {
  if (!(mode & X_OK)) return 0;
  errno = EACCES;
  return -1;
}

int access(const char *path, int mode) {
  if (device_is_path(path)) return access_device(mode);
  return (int)syscall(SYS_faccessat, AT_FDCWD, path, mode);
}
int faccessat(int folder, const char *path, int mode, int flags) {
  if (device_is_path(path)) return access_device(mode);
  return NEXT(faccessat)(folder, path, mode, flags);
}
int euidaccess(const char *path, int mode) {
  return faccessat(AT_FDCWD, path, mode, AT_EACCESS);
}
int eaccess(const char *path, int mode) {
  return euidaccess(path, mode);
}

/* --- vectors, places ------------------------------------------------------------------- */

/* The program's vector, and the sum of its lengths; or a negative errno. */
static ssize_t take_vector(struct iovec taken[IOV_MAX], const struct iovec *vector, int count) {
  size_t length = 0;
  if (count < 0 || count > IOV_MAX) return -EINVAL;
  if (device_copy_in(taken, vector, (size_t)count * sizeof(*vector)) < 0) return -EFAULT;
  for (int i = 0; i < count; i++) {
    if (taken[i].iov_len > SSIZE_MAX - length) return -EINVAL;
    length += taken[i].iov_len;
  }
  return (ssize_t)length;
}

static ssize_t write_vector(const char name[WIRE_NAME], const struct iovec *vector, int count) {
  struct iovec v[IOV_MAX];
  char data[MOST], *at = data;
  ssize_t length = take_vector(v, vector, count);
  if (length < 0) return length;
  if (length > MOST) return -EINVAL;
  for (int i = 0; i < count; at += v[i++].iov_len)
    if (device_copy_in(at, v[i].iov_base, v[i].iov_len) < 0) return -EFAULT;
  return device_write(name, data, (size_t)length);
}

static ssize_t read_vector(const char name[WIRE_NAME], const struct iovec *vector, int count) {
  struct iovec v[IOV_MAX];
  char data[MOST];
  ssize_t got, done = 0, length = take_vector(v, vector, count);
  if (length < 0) return length;
  for (int i = 0; i < count; i++) {
    size_t room = (size_t)(MOST - done);
    if (v[i].iov_len > room) v[i].iov_len = room;
    if (device_can_take(v[i].iov_base, v[i].iov_len) < 0) return -EFAULT;
    done += (ssize_t)v[i].iov_len;
  }
  got = device_read(name, data, (size_t)done);
  done = 0;
  for (int i = 0; i < count && done < got; done += (ssize_t)v[i++].iov_len) {
    size_t part = (size_t)(got - done);
    if (part > v[i].iov_len) part = v[i].iov_len;
    if (device_copy_out(v[i].iov_base, data + done, part) < 0) return -EFAULT;
  }
  return got;
}

ssize_t writev(int fd, const struct iovec *vector, int count) {
  char name[WIRE_NAME];
  if (!wire_is_file(fd, name)) return syscall(SYS_writev, fd, vector, count);
  return device_fail((int)write_vector(name, vector, count));
}

ssize_t readv(int fd, const struct iovec *vector, int count) {
  char name[WIRE_NAME];
  if (!wire_is_file(fd, name)) return syscall(SYS_readv, fd, vector, count);
  return device_fail((int)read_vector(name, vector, count));
}

/* The same at a place, which a device does not have; with flags, under the second name. */
#define VECTOR_AT(call, call2, plain)                                               \
  ssize_t call(int fd, const struct iovec *vector, int count, off_t at) {           \
    char name[WIRE_NAME];                                                           \
    if (!wire_is_file(fd, name)) return NEXT(call)(fd, vector, count, at);          \
    return device_fail((int)plain(name, vector, count));                            \
  }                                                                                 \
  ssize_t call2(int fd, const struct iovec *vector, int count, off_t at, int how) { \
    char name[WIRE_NAME];                                                           \
    if (!wire_is_file(fd, name)) return NEXT(call2)(fd, vector, count, at, how);    \
    return device_fail((int)plain(name, vector, count));                            \
  }
VECTOR_AT(pwritev, pwritev2, write_vector)
VECTOR_AT(pwritev64, pwritev64v2, write_vector)
VECTOR_AT(preadv, preadv2, read_vector)
VECTOR_AT(preadv64, preadv64v2, read_vector)

/* A device has no places: as read() and write(). */
ssize_t pread(int fd, void *buffer, size_t length, off_t at) {
  char name[WIRE_NAME];
  if (!wire_is_file(fd, name)) return syscall(SYS_pread64, fd, buffer, length, at);
  return device_fail((int)device_read(name, buffer, length));
}
ssize_t pread64(int fd, void *buffer, size_t length, off64_t at) {
  return pread(fd, buffer, length, at);
}
ssize_t pwrite(int fd, const void *buffer, size_t length, off_t at) {
  char name[WIRE_NAME];
  if (!wire_is_file(fd, name)) return syscall(SYS_pwrite64, fd, buffer, length, at);
  return device_fail((int)device_write(name, buffer, length));
}
ssize_t pwrite64(int fd, const void *buffer, size_t length, off64_t at) {
  return pwrite(fd, buffer, length, at);
}

/* --- stdio ------------------------------------------------------------------------------ */

/* Buffered as on any device: a read takes the states of all axes, a write goes out with fflush().
 */
#define STREAMS 32
static struct stream {
  FILE *file;
  int fd;
} streams[STREAMS];

static ssize_t stream_read(void *cookie, char *buffer, size_t length) {
  return read(((struct stream *)cookie)->fd, buffer, length);
}

static ssize_t stream_write(void *cookie, const char *buffer, size_t length) {
  ssize_t n = write(((struct stream *)cookie)->fd, buffer, length);
  return n < 0 ? 0 : n; /* as fopencookie() wants to hear it; errno stands */
}

/* To any place: what was read ahead is old then, and the next read takes a new sample. */
static int stream_seek(void *cookie, off64_t *place, int whence) {
  (void)cookie;
  (void)whence;
  *place = 0;
  return 0;
}

static int stream_close(void *cookie) {
  struct stream *s = cookie;
  int fd = s->fd;
  s->file = NULL;
  return close(fd);
}

/* Unbuffered, the library reads a file in one piece, but such a stream byte by byte. */
static size_t read_unbuffered(void *to, size_t size, size_t n, FILE *file) {
  ssize_t got = read(fileno(file), to, size * n);
  if (got < 0) file->_flags |= _IO_ERR_SEEN;
  return got < 0 ? 0 : (size_t)got / size;
}

static int is_unbuffered(FILE *file) {
  for (struct stream *s = streams; s < streams + STREAMS; s++)
    if (s->file == file) return __fbufsize(file) == 1;
  return 0;
}

size_t fread(void *to, size_t size, size_t n, FILE *file) {
  static __typeof__(&fread) next;
  if (size > 0 && n > 0 && n <= SSIZE_MAX / size && is_unbuffered(file))
    return read_unbuffered(to, size, n, file);
  if (next == NULL) next = NEXT(fread);
  return next(to, size, n, file);
}
size_t __fread_chk(void *to, size_t room, size_t size, size_t n, FILE *file);
size_t __fread_chk(void *to, size_t room, size_t size, size_t n, FILE *file) {
  if (size > 0 && n > room / size) abort();
  return fread(to, size, n, file);
}
size_t(fread_unlocked)(void *to, size_t size, size_t n, FILE *file) {
  return fread(to, size, n, file);
}

static FILE *make_stream(int fd, const char *mode) {
  static const cookie_io_functions_t calls = {stream_read, stream_write, stream_seek, stream_close};
  for (struct stream *s = streams; s < streams + STREAMS; s++) {
    FILE *free_place = NULL;
    FILE *file;
    /* a mark of our own until the stream exists */
    if (!__atomic_compare_exchange_n(&s->file, &free_place, (FILE *)(void *)s, 0, __ATOMIC_SEQ_CST,
                                     __ATOMIC_SEQ_CST))
      continue;
    s->fd = fd;
    file = fopencookie(s, mode, calls);
    s->file = file;
    return file;
  }
  errno = EMFILE;
  return NULL;
}

static int flags_of(const char *mode) {
  int cloexec = strchr(mode, 'e') != NULL ? O_CLOEXEC : 0;
  int fresh = *mode != 'r' && strchr(mode, 'x') != NULL ? O_CREAT | O_EXCL : 0;
  if (strchr(mode, '+') != NULL) return O_RDWR | cloexec | fresh;
  return (*mode == 'r' ? O_RDONLY : O_WRONLY) | cloexec | fresh;
}

static FILE *open_stream(const char *path, const char *mode) {
  int fd = device_fail(strchr("rwa", *mode) && *mode ? wire_open(path, flags_of(mode)) : -EINVAL);
  FILE *file = fd < 0 ? NULL : make_stream(fd, mode);
  if (fd >= 0 && file == NULL) (void)close(fd);
  return file;
}

FILE *fopen(const char *path, const char *mode) {
  if (device_is_path(path)) return open_stream(path, mode);
  return NEXT(fopen)(path, mode);
}
FILE *fopen64(const char *path, const char *mode) {
  if (device_is_path(path)) return open_stream(path, mode);
  return NEXT(fopen64)(path, mode);
}

FILE *fdopen(int fd, const char *mode) {
  char name[WIRE_NAME];
  if (wire_is_file(fd, name)) return make_stream(fd, mode);
  return NEXT(fdopen)(fd, mode);
}

int fileno(FILE *file) {
  for (struct stream *s = streams; s < streams + STREAMS; s++)
    if (s->file == file && file != NULL) return s->fd;
  return NEXT(fileno)(file);
}
int fileno_unlocked(FILE *file) {
  return fileno(file);
}

/* The C library would write the text past write(). */
int vdprintf(int fd, const char *format, va_list list) {
  char name[WIRE_NAME], text[MOST];
  int length;
  if (!wire_is_file(fd, name)) return NEXT(vdprintf)(fd, format, list);
  length = vsnprintf(text, sizeof(text), format, list);
  return length < 0 ? length : device_fail((int)device_write(name, text, (size_t)length));
}
int dprintf(int fd, const char *format, ...) {
  va_list list;
  int result;
  va_start(list, format);
  result = vdprintf(fd, format, list);
  va_end(list);
  return result;
}
