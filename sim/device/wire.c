/* SPDX-License-Identifier: Apache-2.0 */
/* The client's end of the wire: files and channels (wire.h). */
#define _GNU_SOURCE
#include "device.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <unistd.h>

#define LATE_MS 100 /* no answer for so long, and signals are let through */

/* Where the server is, as the environment said when the program began: it may clear that later. */
static char server_path[sizeof(((struct sockaddr_un *)0)->sun_path)];

__attribute__((constructor(101))) static void keep_path(void) {
  const char *path = getenv("MMCS_SOCKET");
  size_t length = path != NULL ? strlen(path) : sizeof(server_path);
  if (length < sizeof(server_path)) memcpy(server_path, path, length + 1);
}

static const char *socket_path(void) {
  return server_path[0] != '\0' ? server_path : NULL;
}

/* The preload library interposes read, write and close; these go straight to the kernel. */
int wire_send(int fd, const void *data, size_t length) {
  const char *at = data;
  while (length > 0) {
    ssize_t n = syscall(SYS_sendto, fd, at, length, MSG_NOSIGNAL, NULL, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return -EIO;
    at += n;
    length -= (size_t)n;
  }
  return 0;
}

/* Whether no answer comes within so many ms: the server is stopped or busy otherwise. */
static int is_late(int fd, int ms) {
  struct pollfd wait = {.fd = fd, .events = POLLIN};
  return syscall(SYS_poll, &wait, 1, ms) == 0;
}

/* getpid() without a call of the kernel, which clears the page in the child of a fork. */
pid_t wire_pid(void) {
  static pid_t *page;
  if (page == NULL) {
    void *made = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (made == MAP_FAILED || madvise(made, 4096, MADV_WIPEONFORK) != 0) return getpid();
    page = made;
  }
  if (*page == 0) *page = getpid();
  return *page;
}

const sigset_t *(*wire_late)(const sigset_t *before);

/* `before` is the program's signal mask. Signals wait for a short time only: the alarm of a program
 * whose server does not answer must reach it. A handler that says so has the call end by EINTR. */
static int receive_all(int fd, void *data, size_t length, int wait_ms, const sigset_t *before) {
  char *at = data;
  while (length > 0) {
    int late = is_late(fd, wait_ms), error;
    sigset_t own;
    ssize_t n;
    if (late) pthread_sigmask(SIG_SETMASK, wire_late != NULL ? wire_late(before) : before, &own);
    n = syscall(SYS_recvfrom, fd, at, length, 0, NULL, NULL);
    error = errno;
    if (late) pthread_sigmask(SIG_SETMASK, &own, NULL);
    if (n < 0 && error == EINTR) return -EINTR;
    if (n < 0 && error == EAGAIN) continue; /* LATE_MS have passed */
    if (n <= 0) return -EIO;
    at += n;
    length -= (size_t)n;
  }
  return 0;
}

/* What comes of a reply within LATE_MS: bytes, 0 if nothing does. */
static size_t take_parts(int fd, struct wire_reply *reply, void *out, uint32_t room) {
  struct iovec parts[2] = {{reply, sizeof(*reply)}, {out, room}};
  struct msghdr message = {.msg_iov = parts, .msg_iovlen = room > 0 ? 2 : 1};
  ssize_t n = syscall(SYS_recvmsg, fd, &message, 0);
  return n > 0 ? (size_t)n : 0;
}

/* Head and data, at once where they come at once. */
static int receive_reply(int fd, struct wire_reply *reply, void *out, uint32_t room,
                         const sigset_t *before) {
  size_t have = take_parts(fd, reply, out, room);
  int got = 0;
  if (have < sizeof(*reply))
    got = receive_all(fd, (char *)reply + have, sizeof(*reply) - have, have ? LATE_MS : 0, before);
  have -= have < sizeof(*reply) ? have : sizeof(*reply);
  if (got == 0 && reply->length > room) return -EIO;
  return got == 0 && have < reply->length
             ? receive_all(fd, (char *)out + have, reply->length - have, LATE_MS, before)
             : got;
}

static void close_directly(int fd) {
  (void)syscall(SYS_close, fd);
}

/* Whoever can make a socket at our path is not yet our server. */
static int is_mine(int fd) {
  static int told;
  struct ucred peer;
  socklen_t length = sizeof(peer);
  if (getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &length) == 0 && peer.uid == geteuid())
    return 1;
  if (!told) {
    static const char text[] = "mmcs: the simulator's socket is another user's: not used\n";
    (void)!syscall(SYS_write, 2, text, sizeof(text) - 1);
  }
  told = 1;
  return 0;
}

/* Bound first, so that it has a name of its own. */
int wire_connect(int cloexec) {
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  const struct timeval late = {0, LATE_MS * 1000};
  const char *path = socket_path();
  int fd;
  if (path == NULL) return -ENXIO;
  fd = socket(AF_UNIX, SOCK_STREAM | (cloexec ? SOCK_CLOEXEC : 0), 0);
  if (fd < 0) return -errno;
  (void)setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &late, sizeof(late));
  /* autobind: the kernel picks a free abstract address */
  if (bind(fd, (struct sockaddr *)&address, sizeof(address.sun_family)) == 0) {
    memcpy(address.sun_path, path, strlen(path) + 1);
    if (connect(fd, (struct sockaddr *)&address, sizeof(address)) == 0 && is_mine(fd)) return fd;
  }
  close_directly(fd);
  return -ENXIO; /* as a driver answers without its hardware */
}

/* Signals are blocked, or nothing is lost by them. */
int wire_take(int fd, struct wire_reply *reply, void *out, uint32_t room) {
  struct iovec parts[2] = {{reply, sizeof(*reply)}, {out, room}};
  struct msghdr message = {.msg_iov = parts, .msg_iovlen = 2};
  size_t have = 0;
  while (have < sizeof(*reply) || have - sizeof(*reply) < reply->length) {
    ssize_t n = syscall(SYS_recvmsg, fd, &message, 0);
    if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (n <= 0) return -1;
    have += (size_t)n;
    if (have >= sizeof(*reply) && reply->length > room) return -1;
    for (size_t i = 0; i < 2; i++) { /* the rest, if it comes apart */
      size_t of = (size_t)n < parts[i].iov_len ? (size_t)n : parts[i].iov_len;
      parts[i].iov_base = (char *)parts[i].iov_base + of;
      parts[i].iov_len -= of;
      n -= (ssize_t)of;
    }
  }
  return 0;
}

unsigned long wire_calls, wire_others;
void (*wire_first)(uint32_t op, uint64_t a);

/* The connection broke; distinct from every errno that the server may answer. */
#define LOST (-0x10000)

static int exchange(int fd, const struct wire_request *request, const void *data, void *out,
                    uint32_t *out_length, const sigset_t *before) {
  struct wire_reply reply;
  uint32_t room = out_length != NULL ? *out_length : 0;
  int got;
  char whole[sizeof(*request) + 256]; /* what is short goes in one piece */
  uint32_t first = request->length <= 256 ? request->length : 0;
  memcpy(whole, request, sizeof(*request));
  if (first > 0) memcpy(whole + sizeof(*request), data, first);
  if (wire_send(fd, whole, sizeof(*request) + first) < 0) return LOST;
  if (request->length > first && wire_send(fd, data, request->length) < 0) return LOST;
  got = receive_reply(fd, &reply, out, room, before);
  if (got < 0) return got == -EINTR ? -EINTR : LOST;
  if (out_length != NULL) *out_length = reply.length;
  return reply.result;
}

int wire_open(const char *path, int flags) {
  struct wire_request request = {.magic = WIRE_MAGIC, .op = WIRE_OPEN, .a = (uint64_t)flags};
  struct statx status = {0};
  sigset_t now;
  int result, fd = wire_connect((flags & O_CLOEXEC) != 0);
  if (fd < 0) return fd;
  pthread_sigmask(SIG_SETMASK, NULL, &now);
  if (statx(fd, "", AT_EMPTY_PATH, STATX_INO, &status) == 0) request.b = status.stx_ino;
  request.length = (uint32_t)strlen(path);
  request.pid = getpid();
  result = exchange(fd, &request, path, NULL, NULL, &now);
  if (result < 0) {
    close_directly(fd);
    return result == LOST ? -ENXIO : result;
  }
  (void)fcntl(fd, F_SETFL, flags); /* of these the kernel keeps O_NONBLOCK and O_APPEND */
  return fd;
}

/* Some that were files lately, by the kernel's number of the socket. */
static __thread struct {
  ino_t inode;
  char name[WIRE_NAME];
} known[8];

int wire_is_file(int fd, char name[WIRE_NAME]) {
  struct sockaddr_un address = {0};
  struct stat status = {0};
  socklen_t length = sizeof(address);
  const char *path = socket_path();
  int ours = 0, saved = errno, place = fd & 7;
  if (fd < 0 || syscall(SYS_fstat, fd, &status) != 0 || !S_ISSOCK(status.st_mode)) goto end;
  if (status.st_ino == known[place].inode) {
    memcpy(name, known[place].name, WIRE_NAME);
    return 1;
  }
  if (path != NULL && getpeername(fd, (struct sockaddr *)&address, &length) == 0 &&
      address.sun_family == AF_UNIX && length > sizeof(address.sun_family) &&
      strncmp(address.sun_path, path, sizeof(address.sun_path)) == 0) {
    length = sizeof(address);
    memset(&address, 0, sizeof(address));
    if (getsockname(fd, (struct sockaddr *)&address, &length) == 0) {
      memcpy(name, address.sun_path + 1, WIRE_NAME - 1);
      name[WIRE_NAME - 1] = 0;
      ours = 1;
      known[place].inode = status.st_ino;
      memcpy(known[place].name, name, WIRE_NAME);
    }
  }
end:
  errno = saved;
  return ours;
}

/* The channel of this thread: opened at its first call, closed when the thread ends. It is taken
 * away while a call is under way: a handler that calls meanwhile, or leaves by longjmp, opens
 * another one, and answers never get mixed up. */
static __thread int channel = -1, named = -1; /* that channel_name is of */
static __thread pid_t channel_pid;
static __thread char channel_name[WIRE_NAME];
static pthread_key_t at_thread_end;
static pthread_once_t once = PTHREAD_ONCE_INIT;

/* The program may have closed every descriptor it could count to: then the number is another's. */
static int channel_lives(void) {
  char name[WIRE_NAME];
  return channel >= 0 && channel_pid == wire_pid() && wire_is_file(channel, name) &&
         strcmp(name, channel_name) == 0;
}

static void end_thread(void *unused) {
  (void)unused;
  if (channel_lives()) close_directly(channel);
  channel = -1;
}

static void make_key(void) {
  (void)pthread_key_create(&at_thread_end, end_thread);
}

void wire_after_fork(void) {
  channel_pid = wire_pid();
  if (channel_lives()) close_directly(channel);
  channel = -1;
}

static int take_channel(void) {
  int lives = channel_lives(), fd = lives ? channel : wire_connect(1);
  channel = -1;
  if (!lives) named = -1;
  return fd;
}

static void put_channel(int fd) {
  char name[WIRE_NAME] = {0};
  if (channel >= 0) { /* a handler has left its own */
    close_directly(fd);
    return;
  }
  channel = fd;
  if (named == fd) return;
  if (wire_is_file(fd, name)) memcpy(channel_name, name, WIRE_NAME);
  named = fd;
  channel_pid = wire_pid();
  (void)pthread_once(&once, make_key);
  (void)pthread_setspecific(at_thread_end, &channel);
}

/* A handler of SIGUSR1 calls the driver too: signals wait for the reply, as long as one comes. */
int wire_call(uint32_t op, const char name[WIRE_NAME], uint64_t a, uint64_t b, const void *data,
              uint32_t length, void *out, uint32_t *out_length) {
  struct wire_request request = {.magic = WIRE_MAGIC, .op = op, .a = a, .b = b, .length = length};
  sigset_t all, before;
  int result = LOST, fd;
  __atomic_add_fetch(&wire_calls, 1, __ATOMIC_RELAXED);
  if (op != WIRE_WRITE) __atomic_add_fetch(&wire_others, 1, __ATOMIC_RELAXED);
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  if (wire_first != NULL) wire_first(op, a);
  fd = take_channel();
  if (fd >= 0) {
    memcpy(request.name, name, WIRE_NAME);
    request.pid = wire_pid();
    result = exchange(fd, &request, data, out, out_length, &before);
    if (result == LOST || result == -EINTR) {
      close_directly(fd);
    } else {
      put_channel(fd);
    }
  }
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  return result == LOST ? -EIO : result;
}
