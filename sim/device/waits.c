/* SPDX-License-Identifier: Apache-2.0 */
/* Lock-step: the calls of the C library that sleep or wait, but for threads and children (sync.c).
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include "device.h"

#undef fd_set

static int interrupted(void) {
  errno = EINTR;
  return -1;
}

/* What has found nothing and was asked to wait for no longer. */
static int is_over(uint64_t until) {
  if (lock_now() < until) return 0;
  lock_polls();
  return 1;
}

/* --- sleeping -------------------------------------------------------------------------- */

/* 0, or EINTR and what is left. */
static int sleep_until(uint64_t until, struct timespec *left) {
  uint64_t now;
  (void)is_over(until);
  if (lock_wait(0, until, NULL, NULL, 0, NULL, 0) != CAUSE_SIGNAL) return 0;
  now = lock_now();
  if (left != NULL) *left = lock_span(until > now ? until - now : 0);
  return EINTR;
}

CALL(int, clock_nanosleep,
     (clockid_t clock, int flags, const struct timespec *at, struct timespec *left),
     (clock, flags, at, left)) {
  if (at->tv_sec < 0 || at->tv_nsec < 0 || at->tv_nsec >= SECOND) return EINVAL;
  if (flags & TIMER_ABSTIME) return sleep_until(lock_until(clock, at), NULL);
  return sleep_until(lock_after(lock_ns(at)), left);
}

CALL(int, nanosleep, (const struct timespec *at, struct timespec *left), (at, left)) {
  errno = clock_nanosleep(CLOCK_MONOTONIC, 0, at, left);
  return errno == 0 ? 0 : -1;
}

SAME(thrd_sleep, nanosleep);
int usleep(useconds_t us) {
  struct timespec at = {us / 1000000, us % 1000000 * 1000};
  return nanosleep(&at, NULL);
}

unsigned sleep(unsigned seconds) {
  struct timespec at = {seconds, 0}, left = {0};
  return nanosleep(&at, &left) == 0 ? 0 : (unsigned)left.tv_sec + (left.tv_nsec > 0);
}

CALL(int, sched_yield, (void), ()) {
  lock_polls();
  (void)lock_wait(WAIT_DEAF, 0, NULL, NULL, 0, NULL, 0);
  return 0;
}

/* --- signals --------------------------------------------------------------------------- */

CALL(int, pause, (void), ()) {
  (void)lock_wait(0, WIRE_NEVER, NULL, NULL, 0, NULL, 0);
  return interrupted();
}

CALL(int, sigsuspend, (const sigset_t *mask), (mask)) {
  (void)lock_wait(0, WIRE_NEVER, NULL, NULL, 0, mask, 0);
  return interrupted();
}

CALL(int, sigtimedwait, (const sigset_t *set, siginfo_t *info, const struct timespec *timeout),
     (set, info, timeout)) {
  static const struct timespec none = {0};
  uint64_t until;
  sigset_t mask;
  until = timeout != NULL ? lock_after(lock_ns(timeout)) : WIRE_NEVER;
  pthread_sigmask(SIG_SETMASK, NULL, &mask);
  for (int n = 1; n < 65; n++)
    if (sigismember(set, n) == 1) sigdelset(&mask, n);
  for (;;) {
    int got = REAL(sigtimedwait)(set, info, &none);
    if (got >= 0 || errno != EAGAIN || is_over(until)) return got;
    if (lock_wait(0, until, NULL, NULL, 0, &mask, 1) != CAUSE_SIGNAL) continue;
    got = REAL(sigtimedwait)(set, info, &none);
    return got >= 0 ? got : interrupted();
  }
}

int sigwaitinfo(const sigset_t *set, siginfo_t *info) {
  return sigtimedwait(set, info, NULL);
}

CALL(int, sigwait, (const sigset_t *set, int *number), (set, number)) {
  int got;
  do got = sigtimedwait(set, NULL, NULL);
  while (got < 0 && errno == EINTR);
  *number = got;
  return got < 0 ? errno : 0;
}

/* What a signal is sent by: who waits hears of it from the server. SIGSTOP wakes nobody. */
static int sent(int result, uint64_t to, int number, uint64_t kind) {
  if (result == 0 && number != 0 && number != SIGSTOP && lock_on() && to != (uint64_t)wire_pid)
    (void)lock_tell(WIRE_POKE, to, (uint64_t)number | kind);
  return result;
}
#define SENDS(name, parameters, arguments, to, kind)                 \
  int name parameters {                                              \
    return sent(REAL(name) arguments, (uint64_t)(to), number, kind); \
  }
SENDS(kill, (pid_t pid, int number), (pid, number), pid, 0)
SENDS(killpg, (pid_t group, int number), (group, number), -group, 0)
SENDS(sigqueue, (pid_t pid, int number, const union sigval value), (pid, number, value), pid, 0)
SENDS(pthread_kill, (pthread_t thread, int number), (thread, number), thread, WIRE_THREAD)

/* --- descriptors ----------------------------------------------------------------------- */

/* What a call finds ready `now`; or waits for `files` and looks again, after `anew`. Where only the
 * outside world can make them ready, the call itself waits: `outside`. */
#define UNTIL_READY(now, files, count, until, mask, anew, outside)            \
  for (unsigned what_ = (count) > 0 ? WAIT_FILES : 0;; what_ |= WAIT_AGAIN) { \
    int cause_, ready_ = (now);                                               \
    if (ready_ != 0 || is_over(until)) return ready_;                         \
    cause_ = lock_wait(what_, until, NULL, files, count, mask, 0);            \
    anew;                                                                     \
    if (cause_ == CAUSE_SIGNAL) return interrupted();                         \
    if (cause_ == CAUSE_OUTSIDE) return (outside);                            \
  }

CALL(int, ppoll,
     (struct pollfd * fds, nfds_t n, const struct timespec *timeout, const sigset_t *mask),
     (fds, n, timeout, mask)) {
  static const struct timespec none = {0};
  const uint64_t until = timeout != NULL ? lock_after(lock_ns(timeout)) : WIRE_NEVER;
  int files[64];
  unsigned count = 0;
  for (nfds_t i = 0; i < n && count < 64; i++)
    if (fds[i].fd >= 0) files[count++] = fds[i].fd;
  UNTIL_READY(REAL(ppoll)(fds, n, &none, NULL), files, count, until, mask, ,
              REAL(ppoll)(fds, n, NULL, mask))
}

int poll(struct pollfd *fds, nfds_t n, int ms) {
  const struct timespec timeout = lock_span((uint64_t)ms * 1000000);
  return ppoll(fds, n, ms < 0 ? NULL : &timeout, NULL);
}
int __poll_chk(struct pollfd *fds, nfds_t n, int ms, size_t size);
int __poll_chk(struct pollfd *fds, nfds_t n, int ms, size_t size) {
  if (size / sizeof(*fds) < n) abort();
  return poll(fds, n, ms);
}

static int select_until(int n, fd_set *in, fd_set *out, fd_set *bad, uint64_t until,
                        const sigset_t *mask) {
  fd_set asked[3] = {0}, *set[3] = {in, out, bad};
  static const struct timespec none = {0};
  int files[64];
  unsigned count = 0;
  for (int i = 0; i < 3; i++)
    if (set[i] != NULL) asked[i] = *set[i];
  for (int fd = 0; fd < n && count < 64; fd++)
    if ((in && FD_ISSET(fd, in)) || (out && FD_ISSET(fd, out)) || (bad && FD_ISSET(fd, bad)))
      files[count++] = fd;
  UNTIL_READY(REAL(pselect)(n, in, out, bad, &none, NULL), files, count, until, mask,
              for (int i = 0; i < 3; i++) if (set[i] != NULL) * set[i] = asked[i],
              REAL(pselect)(n, in, out, bad, NULL, mask))
}

CALL(int, select, (int n, fd_set *in, fd_set *out, fd_set *bad, struct timeval *timeout),
     (n, in, out, bad, timeout)) {
  uint64_t until = WIRE_NEVER, now;
  int ready;
  if (timeout != NULL)
    until = lock_after((uint64_t)timeout->tv_sec * SECOND + (uint64_t)timeout->tv_usec * 1000);
  ready = select_until(n, in, out, bad, until, NULL);
  now = lock_now();
  if (timeout != NULL) {
    uint64_t left = until > now ? (until - now) / 1000 : 0;
    *timeout = (struct timeval){(time_t)(left / 1000000), (suseconds_t)(left % 1000000)};
  }
  return ready;
}

CALL(int, pselect,
     (int n, fd_set *in, fd_set *out, fd_set *bad, const struct timespec *timeout,
      const sigset_t *mask),
     (n, in, out, bad, timeout, mask)) {
  return select_until(n, in, out, bad, timeout ? lock_after(lock_ns(timeout)) : WIRE_NEVER, mask);
}

CALL(int, epoll_pwait, (int fd, struct epoll_event *events, int most, int ms, const sigset_t *mask),
     (fd, events, most, ms, mask)) {
  const uint64_t until = ms < 0 ? WIRE_NEVER : lock_after((uint64_t)ms * 1000000);
  UNTIL_READY(REAL(epoll_pwait)(fd, events, most, 0, NULL), &fd, 1, until, mask, ,
              REAL(epoll_pwait)(fd, events, most, -1, mask))
}

int epoll_wait(int fd, struct epoll_event *events, int most, int ms) {
  return epoll_pwait(fd, events, most, ms, NULL);
}

/* Pipes and streams, which take a part of what is written. */
static int takes_parts(int fd) {
  struct stat status;
  int kind = 0;
  socklen_t size = sizeof(kind);
  if (fstat(fd, &status) < 0) return 0;
  if (S_ISSOCK(status.st_mode)) (void)getsockopt(fd, SOL_SOCKET, SO_TYPE, &kind, &size);
  return S_ISFIFO(status.st_mode) || kind == SOCK_STREAM;
}

/* A blocking descriptor that would block. */
size_t lock_await(int fd, short events) {
  struct pollfd one = {.fd = fd, .events = events};
  static const struct timespec none = {0};
  int flags = lock_on() ? fcntl(fd, F_GETFL) : O_NONBLOCK, saved = errno;
  unsigned what = WAIT_FILES;
  size_t most = SIZE_MAX;
  sigset_t all; /* lock_wait() knows what a signal does to the call */
  sigfillset(&all);
  while (flags >= 0 && !(flags & O_NONBLOCK) && REAL(ppoll)(&one, 1, &none, &all) == 0) {
    int cause = lock_wait(what | LOCK_RESTARTS, WIRE_NEVER, NULL, &fd, 1, NULL, 0);
    if (cause == CAUSE_SIGNAL && REAL(ppoll)(&one, 1, &none, &all) == 0) return errno = EINTR, 0;
    if (cause == CAUSE_OUTSIDE) break;
    what |= WAIT_AGAIN;
  }
  if (events == POLLOUT && flags >= 0 && !(flags & O_NONBLOCK) && takes_parts(fd)) most = PIPE_BUF;
  errno = saved;
  return most;
}

/* A call that takes from a socket, once there is something. */
#define TAKES(result, name, parameters, arguments, flags)                    \
  CALL(result, name, parameters, arguments) {                                \
    int waits = !((flags) & MSG_DONTWAIT) && wire_file(fd) == 0;             \
    return waits && lock_await(fd, POLLIN) == 0 ? -1 : REAL(name) arguments; \
  }
TAKES(ssize_t, recv, (int fd, void *to, size_t size, int flags), (fd, to, size, flags), flags)
TAKES(ssize_t, recvfrom,
      (int fd, void *restrict to, size_t size, int flags, struct sockaddr *restrict from,
       socklen_t *restrict length),
      (fd, to, size, flags, from, length), flags)
TAKES(ssize_t, recvmsg, (int fd, struct msghdr *to, int flags), (fd, to, flags), flags)
TAKES(int, accept, (int fd, struct sockaddr *restrict from, socklen_t *restrict length),
      (fd, from, length), 0)
TAKES(int, accept4, (int fd, struct sockaddr *restrict from, socklen_t *restrict length, int flags),
      (fd, from, length, flags), 0)

static void replace(FILE **stream, int fd, const char *mode) {
  struct stat status;
  FILE *made = NULL;
  if (fstat(fd, &status) == 0 && S_ISFIFO(status.st_mode)) made = device_stream(fd, mode);
  if (made != NULL) *stream = made;
}

void lock_take_pipes(void) {
  replace(&stdin, 0, "r");
  replace(&stdout, 1, "w");
}
