/* SPDX-License-Identifier: Apache-2.0 */
/* The client's end of the wire: files and channels (wire.h). */
#define _GNU_SOURCE
#include "wire.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

static const char *socket_path(void) {
  const char *path = getenv("MMCS_SOCKET");
  return path != NULL && strlen(path) < sizeof(((struct sockaddr_un *)0)->sun_path) ? path : NULL;
}

/* The preload library interposes read, write and close; these go straight to the kernel. */
static int send_all(int fd, const void *data, size_t length) {
  const char *at = data;
  while (length > 0) {
    ssize_t n = send(fd, at, length, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return -EIO;
    at += n;
    length -= (size_t)n;
  }
  return 0;
}

static int receive_all(int fd, void *data, size_t length) {
  char *at = data;
  while (length > 0) {
    ssize_t n = recv(fd, at, length, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return -EIO;
    at += n;
    length -= (size_t)n;
  }
  return 0;
}

static void close_directly(int fd) {
  (void)syscall(SYS_close, fd);
}

/* A connection to the server; bound first, so that it has a name of its own. */
static int connect_to_server(int cloexec) {
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  const char *path = socket_path();
  int fd;
  if (path == NULL) return -ENXIO;
  fd = socket(AF_UNIX, SOCK_STREAM | (cloexec ? SOCK_CLOEXEC : 0), 0);
  if (fd < 0) return -errno;
  /* autobind: the kernel picks a free abstract address */
  if (bind(fd, (struct sockaddr *)&address, sizeof(address.sun_family)) == 0) {
    memcpy(address.sun_path, path, strlen(path) + 1);
    if (connect(fd, (struct sockaddr *)&address, sizeof(address)) == 0) return fd;
  }
  close_directly(fd);
  return -ENXIO; /* as a driver answers without its hardware */
}

/* The connection broke; distinct from every errno that the server may answer. */
#define LOST (-0x10000)

static int exchange(int fd, const struct wire_request *request, const void *data, void *out,
                    uint32_t *out_length) {
  struct wire_reply reply;
  uint32_t room = out_length != NULL ? *out_length : 0;
  if (send_all(fd, request, sizeof(*request)) < 0) return LOST;
  if (request->length > 0 && send_all(fd, data, request->length) < 0) return LOST;
  if (receive_all(fd, &reply, sizeof(reply)) < 0) return LOST;
  if (reply.length > room) return LOST;
  if (reply.length > 0 && receive_all(fd, out, reply.length) < 0) return -EIO;
  if (out_length != NULL) *out_length = reply.length;
  return reply.result;
}

int wire_open(const char *path, int flags) {
  struct wire_request request = {.magic = WIRE_MAGIC, .op = WIRE_OPEN, .a = (uint64_t)flags};
  struct stat status;
  int result, fd = connect_to_server((flags & O_CLOEXEC) != 0);
  if (fd < 0) return fd;
  request.b = fstat(fd, &status) == 0 ? status.st_ino : 0;
  request.length = (uint32_t)strlen(path);
  request.pid = getpid();
  result = exchange(fd, &request, path, NULL, NULL);
  if (result < 0) {
    close_directly(fd);
    return result == LOST ? -ENXIO : result;
  }
  return fd;
}

int wire_is_file(int fd, char name[WIRE_NAME]) {
  struct sockaddr_un address = {0};
  socklen_t length = sizeof(address);
  const char *path = socket_path();
  int ours = 0, saved = errno;
  if (path != NULL && getpeername(fd, (struct sockaddr *)&address, &length) == 0 &&
      address.sun_family == AF_UNIX && length > sizeof(address.sun_family) &&
      strncmp(address.sun_path, path, sizeof(address.sun_path)) == 0) {
    length = sizeof(address);
    memset(&address, 0, sizeof(address));
    if (getsockname(fd, (struct sockaddr *)&address, &length) == 0) {
      memcpy(name, address.sun_path + 1, WIRE_NAME - 1);
      name[WIRE_NAME - 1] = 0;
      ours = 1;
    }
  }
  errno = saved;
  return ours;
}

/* The channel of this thread: opened at its first call, closed when the thread ends. */
static __thread int channel = -1;
static __thread pid_t channel_pid;
static __thread char channel_name[WIRE_NAME];
static pthread_key_t at_thread_end;
static pthread_once_t once = PTHREAD_ONCE_INIT;

/* The program may have closed every descriptor it could count to: then the number is another's. */
static int channel_lives(void) {
  char name[WIRE_NAME];
  return channel >= 0 && channel_pid == getpid() && wire_is_file(channel, name) &&
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
  channel_pid = getpid();
  if (channel_lives()) close_directly(channel);
  channel = -1;
}

static void open_channel(void) {
  char name[WIRE_NAME] = {0};
  channel = connect_to_server(1);
  channel_pid = getpid();
  if (channel >= 0 && wire_is_file(channel, name)) memcpy(channel_name, name, WIRE_NAME);
  (void)pthread_once(&once, make_key);
  (void)pthread_setspecific(at_thread_end, &channel);
}

/* A handler of SIGUSR1 calls the driver too: no signal may come between a request and its reply. */
int wire_call(uint32_t op, const char name[WIRE_NAME], uint64_t a, uint64_t b, const void *data,
              uint32_t length, void *out, uint32_t *out_length) {
  struct wire_request request = {.magic = WIRE_MAGIC, .op = op, .a = a, .b = b, .length = length};
  sigset_t all, before;
  int result = LOST;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  if (!channel_lives()) open_channel();
  if (channel >= 0) {
    memcpy(request.name, name, WIRE_NAME);
    request.pid = channel_pid;
    result = exchange(channel, &request, data, out, out_length);
    if (result == LOST) {
      close_directly(channel);
      channel = -1;
    }
  }
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  return result == LOST ? -EIO : result;
}
