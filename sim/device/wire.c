/* SPDX-License-Identifier: Apache-2.0 */
/* The client's end of the wire: files and channels (wire.h). */
#define _GNU_SOURCE
#include "device.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <unistd.h>

#define LATE_MS 100 /* no answer for so long, and signals are let through */

/* Where the server is, as the environment said when the program began: it may clear that later. */
static char server_path[sizeof(((struct sockaddr_un *)0)->sun_path)];

static void close_directly(int fd) {
  (void)syscall(SYS_close, fd);
}

static ino_t inode_of(int fd) {
  struct stat status = {0};
  return syscall(SYS_fstat, fd, &status) == 0 ? status.st_ino : 0;
}

/* The channel of this thread: opened at its first call, closed when the thread ends. It is taken
 * away while a call is under way: a handler that calls meanwhile, or leaves by longjmp, opens
 * another one, and answers never get mixed up. */
static __thread struct channel {
  int fd;
  ino_t inode; /* the program may have closed every descriptor it could count to */
} channel = {.fd = -1};
static pthread_key_t at_thread_end; /* of one that has connected */

static void close_channel(void) {
  if (channel.fd >= 0 && inode_of(channel.fd) == channel.inode) close_directly(channel.fd);
  channel.fd = -1;
}

static void end_thread(void *unused) {
  (void)unused;
  lock_end_thread();
  close_channel();
}

pid_t wire_pid; /* getpid() without a call of the kernel */

/* The channel that a child of fork has is its parent's. */
static void note_pid(void) {
  wire_pid = getpid();
  close_channel();
}

__attribute__((constructor(101))) static void keep_path(void) {
  const char *path = getenv("MMCS_SOCKET");
  size_t length = path != NULL ? strlen(path) : sizeof(server_path);
  if (length < sizeof(server_path)) memcpy(server_path, path, length + 1);
  note_pid();
  (void)pthread_key_create(&at_thread_end, end_thread);
  (void)pthread_atfork(NULL, NULL, note_pid); /* before all that ask for it in the child */
}

/* The preload library interposes read, write and close; these go straight to the kernel. */
int wire_ask(int fd, uint32_t op, ino_t file, uint64_t a, uint64_t b, const void *data,
             uint32_t length) {
  struct wire_request head = {WIRE_MAGIC, op, file, a, b, length, wire_pid};
  struct iovec parts[2] = {{&head, sizeof(head)}, {(void *)(uintptr_t)data, length}};
  struct msghdr message = {.msg_iov = parts, .msg_iovlen = 2};
  ssize_t sent;
  do sent = syscall(SYS_sendmsg, fd, &message, MSG_NOSIGNAL);
  while (sent < 0 && errno == EINTR);
  return sent < 0 ? -1 : 0;
}

/* Its reply: 0; -EIO when the server is gone or answers nonsense. The alarm of a program whose
 * server does not answer must reach it: what has waited for LATE_MS lets signals through that
 * `before`, the program's mask, does, and gives -EINTR when a handler ran. */
static int take(int fd, struct wire_reply *reply, void *out, uint32_t room,
                const sigset_t *before) {
  struct iovec parts[2] = {{reply, sizeof(*reply)}, {out, room}};
  struct msghdr message = {.msg_iov = parts, .msg_iovlen = 2};
  for (int late = 0;;) {
    sigset_t own;
    ssize_t n;
    int error;
    if (late) pthread_sigmask(SIG_SETMASK, lock_late(before), &own);
    n = syscall(SYS_recvmsg, fd, &message, 0);
    error = errno;
    if (late) pthread_sigmask(SIG_SETMASK, &own, NULL);
    if (n >= (ssize_t)sizeof(*reply) && reply->length <= room)
      return (size_t)n == sizeof(*reply) + reply->length ? 0 : -EIO;
    if (n >= 0) return -EIO;
    if (error == EINTR && late) return -EINTR;
    if (error != EINTR && error != EAGAIN) return -EIO;
    late = error == EAGAIN;
  }
}

/* Whoever can make a socket at our path is not yet our server. */
static int is_mine(int fd) {
  struct ucred peer;
  socklen_t length = sizeof(peer);
  return getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &length) == 0 && peer.uid == geteuid();
}

int wire_connect(int cloexec) {
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  const struct timeval late = {0, LATE_MS * 1000};
  int fd;
  if (!server_path[0]) return -ENXIO;
  fd = socket(AF_UNIX, SOCK_SEQPACKET | (cloexec ? SOCK_CLOEXEC : 0), 0);
  if (fd < 0) return -errno;
  (void)pthread_setspecific(at_thread_end, &channel);
  (void)setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &late, sizeof(late));
  memcpy(address.sun_path, server_path, sizeof(address.sun_path));
  if (connect(fd, (struct sockaddr *)&address, sizeof(address)) == 0 && is_mine(fd)) return fd;
  close_directly(fd);
  return -ENXIO; /* as a driver answers without its hardware */
}

unsigned long wire_calls, wire_others;

/* The connection broke; distinct from every errno that the server may answer. */
#define LOST (-0x10000)

static int exchange(int fd, uint32_t op, ino_t file, uint64_t a, uint64_t b, const void *data,
                    uint32_t length, void *out, uint32_t *out_length, const sigset_t *before) {
  struct wire_reply reply;
  int got = wire_ask(fd, op, file, a, b, data, length);
  if (got == 0) got = take(fd, &reply, out, out_length != NULL ? *out_length : 0, before);
  if (got != 0) return got == -EINTR ? -EINTR : LOST;
  if (out_length != NULL) *out_length = reply.length;
  return reply.result;
}

int wire_open(const char *path, int flags) {
  sigset_t now;
  int result, fd = wire_connect((flags & O_CLOEXEC) != 0);
  if (fd < 0) return fd;
  pthread_sigmask(SIG_SETMASK, NULL, &now);
  result = exchange(fd, WIRE_OPEN, inode_of(fd), (uint64_t)flags, 0, path, (uint32_t)strlen(path),
                    NULL, NULL, &now);
  if (result < 0) {
    close_directly(fd);
    return result == LOST ? -ENXIO : result;
  }
  (void)fcntl(fd, F_SETFL, flags); /* of these the kernel keeps O_NONBLOCK and O_APPEND */
  return fd;
}

ino_t wire_file(int fd) {
  static __thread ino_t known[8]; /* some that were files lately */
  struct sockaddr_un peer = {0};
  struct stat status = {0};
  socklen_t length = sizeof(peer);
  const int saved = errno;
  int ours = fd >= 0 && syscall(SYS_fstat, fd, &status) == 0 && S_ISSOCK(status.st_mode);
  if (ours && status.st_ino != known[fd & 7]) {
    ours = server_path[0] && getpeername(fd, (struct sockaddr *)&peer, &length) == 0 &&
           peer.sun_family == AF_UNIX &&
           strncmp(peer.sun_path, server_path, sizeof(peer.sun_path)) == 0;
    if (ours) known[fd & 7] = status.st_ino;
  }
  errno = saved;
  return ours ? status.st_ino : 0;
}

static struct channel take_channel(void) {
  const struct channel had = channel, none = {.fd = -1};
  int fd;
  channel = none;
  if (had.fd >= 0 && inode_of(had.fd) == had.inode) return had;
  fd = wire_connect(1);
  return (struct channel){fd, inode_of(fd)};
}

/* Setpoints alone, or nothing. */
static int changes(uint32_t op, uint64_t a) {
  return op != WIRE_WRITE && op != WIRE_READ &&
         (op != WIRE_IOCTL || REQUEST_IN(a) || !REQUEST_OUT(a));
}

/* A handler of SIGUSR1 calls the driver too: signals wait for the reply, as long as one comes. */
int wire_call(uint32_t op, ino_t file, uint64_t a, uint64_t b, const void *data, uint32_t length,
              void *out, uint32_t *out_length) {
  sigset_t all, before;
  struct channel c;
  int result = LOST;
  __atomic_add_fetch(&wire_calls, 1, __ATOMIC_RELAXED);
  if (changes(op, a)) __atomic_add_fetch(&wire_others, 1, __ATOMIC_RELAXED);
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  lock_write_first();
  c = take_channel();
  if (c.fd >= 0) {
    result = exchange(c.fd, op, file, a, b, data, length, out, out_length, &before);
    if (result == LOST || result == -EINTR || channel.fd >= 0) { /* a handler has left its own */
      close_directly(c.fd);
    } else {
      channel = c;
    }
  }
  lock_after_call();
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  return result == LOST ? -EIO : result;
}
