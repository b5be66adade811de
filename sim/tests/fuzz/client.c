/* SPDX-License-Identifier: Apache-2.0 */
/* Coverage-guided fuzzing of the client's end of the wire, §2.3: whatever a server answers, a call
 * writes nothing beyond what the program asked for, and returns what read(2) and its like may.
 *
 * Input: the call, how the bytes come, the call's length, then the answer's bytes. */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <unistd.h>

#define FD 1000
#define GUARD 64

static const uint8_t *answer; /* what is left of it */
static size_t left, part;
static int breaks; /* how it ends: closed, reset, interrupted */

/* --- the kernel under wire.c: one socket, whose other end is the input ------------------- */

static int no_socket(int family, int type, int protocol) {
  (void)family, (void)type, (void)protocol;
  return FD;
}

static int no_bind(int fd, const void *address, socklen_t length) {
  (void)fd, (void)address, (void)length;
  return 0;
}

static int no_option(int fd, int level, int name, void *value, socklen_t *length) {
  struct ucred me = {.uid = geteuid()};
  (void)fd, (void)level, (void)name;
  memcpy(value, &me, *length);
  return 0;
}

/* What wire.c asks of the kernel by number: all is sent, and the next part of the input comes. */
static long no_syscall(long number, ...) {
  static unsigned ends;
  const size_t most = part > 0 && part < left ? part : left;
  const struct msghdr *message = NULL;
  size_t bytes = 0;
  va_list list;
  va_start(list, number);
  (void)va_arg(list, int);
  if (number == SYS_sendmsg || number == SYS_recvmsg) message = va_arg(list, const void *);
  va_end(list);
  if (message == NULL) return number == SYS_close ? 0 : -1;
  for (size_t i = 0; i < message->msg_iovlen; i++) {
    size_t n = message->msg_iov[i].iov_len;
    if (number == SYS_recvmsg && n > most - bytes) n = most - bytes;
    if (number == SYS_recvmsg && n > 0) memcpy(message->msg_iov[i].iov_base, answer + bytes, n);
    bytes += n;
  }
  if (number == SYS_sendmsg) return (long)bytes;
  answer += bytes;
  left -= bytes;
  if (bytes > 0 || breaks == 0) return (long)bytes;
  errno = breaks == 1 ? ECONNRESET : ends++ % 2 ? EINTR : EAGAIN; /* late, then interrupted */
  return -1;
}

static int no_name(int fd, void *address, socklen_t *length);

#define socket no_socket
#define bind no_bind
#define connect no_bind
#define getsockopt no_option
#define syscall no_syscall
#define getpeername no_name
#define getsockname no_name
/* what preload.c would take from the fuzzer itself */
#define open dev_open
#define creat dev_creat
#define openat dev_openat
#define read dev_read
#define __read_chk dev_read_chk
#define write dev_write
#define ioctl dev_ioctl
#define mmap dev_mmap
#define munmap dev_munmap
#include "../../device/device.h"
#undef SAME
#define SAME(name, as) _Static_assert(1, "the fuzzer's own")
#include "../../device/preload.c"
#include "../../device/wire.c"

/* The device's path at the far end, a name that the kernel picked at this one. */
static int no_name(int fd, void *address, socklen_t *length) {
  struct sockaddr_un name = {.sun_family = AF_UNIX};
  (void)fd;
  memcpy(name.sun_path, server_path, sizeof(name.sun_path));
  memcpy(address, &name, *length < sizeof(name) ? *length : sizeof(name));
  *length = sizeof(name);
  return 0;
}

/* of lockstep.c, which is not on */
void lock_find(void **real, const char *name) {
  *real = dlsym(RTLD_NEXT, name);
}
int lock_on(void) {
  return 0;
}
int lock_sample(uint32_t *number) {
  return (int)*number;
}
int lock_known(const char *of, uint32_t request, void *data, uint32_t asked) {
  (void)of, (void)request, (void)data, (void)asked;
  return 0;
}
void lock_learn(const char *of, uint32_t request, const void *data, uint32_t asked, int length) {
  (void)of, (void)request, (void)data, (void)asked, (void)length;
}
int lock_write_later(const char *of, const void *data, uint32_t length) {
  (void)of, (void)data, (void)length;
  return 0;
}
void lock_write_first(void) {}
const sigset_t *lock_late(const sigset_t *before) {
  return before;
}
size_t lock_await(int fd, short events) {
  (void)fd, (void)events;
  return SIZE_MAX;
}

/* of vme_map.c, which these calls do not reach */
void *vme_map(void *address, uint64_t length, int prot, int fd, int64_t offset, const char *name) {
  (void)address, (void)length, (void)prot, (void)fd, (void)offset, (void)name;
  return MAP_FAILED;
}
int vme_unmap(void *address, uint64_t length) {
  (void)address, (void)length;
  return 0;
}

/* --- a call ------------------------------------------------------------------------------ */

static void expect(int truth, const char *what) {
  if (truth) return;
  fprintf(stderr, "client: %s\n", what);
  abort();
}

static const char name[WIRE_NAME] = "name";

static long call(unsigned which, uint8_t *room, size_t length, uint32_t request) {
  uint32_t size = (uint32_t)length;
  switch (which % 6) {
    case 0:
      return device_read(name, room, length);
    case 1:
      return device_write(name, room, length);
    case 2:
      return device_ioctl(name, (request & ~0x1FFF0000u) | (uint32_t)(length & 255) << 16, room);
    case 3:
      return wire_call(WIRE_LOAD, name, request, 2, NULL, 0, room, &size);
    case 4:
      return wire_open("/dev/mc0", O_RDWR);
    default:
      return wire_call(WIRE_HOLD, name, 0, 0, NULL, 0, NULL, NULL);
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static uint8_t room[4096 + 2 * GUARD];
  uint32_t request;
  if (size < 8) return 0;
  unsigned which = data[0];
  size_t length = (data[2] | (size_t)data[3] << 8) % 4097;
  memcpy(&request, data + 4, 4);
  if (which % 6 == 2) length &= 255;
  part = data[1] >> 2;
  breaks = data[1] % 3;
  answer = data + 8;
  left = size - 8;
  memcpy(server_path, "/x", 3);
  memset(room, 0x5A, sizeof(room));
  long result = call(which, room + GUARD, length, request);
  for (int i = 0; i < GUARD; i++)
    expect(room[i] == 0x5A && room[GUARD + length + (size_t)i] == 0x5A, "bytes beyond the buffer");
  if (which % 6 < 2) expect(result <= (long)length, "more than was asked for");
  if (channel >= 0) channel = -1;
  return 0;
}

#ifdef SAMPLE /* where there is no fuzzer: PROGRAM COUNT, so many random inputs */
int main(int argc, char **argv) {
  static uint8_t data[200];
  const long count = argc > 1 ? atol(argv[1]) : 1000;
  srandom(1989);
  for (long n = 0; n < count; n++) {
    const size_t size = (size_t)random() % sizeof data;
    for (size_t i = 0; i < size; i++) data[i] = (uint8_t)random();
    (void)LLVMFuzzerTestOneInput(data, size);
  }
  printf("%ld inputs\n", count);
  return 0;
}
#endif
