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
#include <threads.h>
#include <unistd.h>

#include "lockstep.h"

#undef fd_set

static int interrupted(void) {
  errno = EINTR;
  return -1;
}

/* --- sleeping -------------------------------------------------------------------------- */

/* 0, or EINTR and what is left. */
static int sleep_until(uint64_t until, struct timespec *left) {
  uint64_t now;
  if (lock_wait(0, until, NULL, NULL, 0, NULL, 0) != CAUSE_SIGNAL) return 0;
  now = lock_now();
  if (left != NULL) *left = lock_span(until > now ? until - now : 0);
  return EINTR;
}

static int is_time(const struct timespec *at) {
  return at->tv_sec >= 0 && at->tv_nsec >= 0 && at->tv_nsec < SECOND;
}

int clock_nanosleep(clockid_t clock, int flags, const struct timespec *at, struct timespec *left) {
  if (!lock_on()) return REAL(clock_nanosleep)(clock, flags, at, left);
  if (!is_time(at)) return EINVAL;
  if (flags & TIMER_ABSTIME) return sleep_until(lock_until(clock, at), NULL);
  return sleep_until(lock_after(lock_ns(at)), left);
}

int nanosleep(const struct timespec *at, struct timespec *left) {
  if (!lock_on()) return REAL(nanosleep)(at, left);
  errno = clock_nanosleep(CLOCK_MONOTONIC, 0, at, left);
  return errno == 0 ? 0 : -1;
}

int usleep(useconds_t us) {
  struct timespec at = {us / 1000000, us % 1000000 * 1000};
  if (!lock_on()) return REAL(usleep)(us);
  return nanosleep(&at, NULL);
}

unsigned sleep(unsigned seconds) {
  struct timespec at = {seconds, 0}, left = {0};
  if (!lock_on()) return REAL(sleep)(seconds);
  return nanosleep(&at, &left) == 0 ? 0 : (unsigned)left.tv_sec + (left.tv_nsec > 0);
}

int thrd_sleep(const struct timespec *at, struct timespec *left) {
  return nanosleep(at, left);
}

int sched_yield(void) {
  if (!lock_on()) return REAL(sched_yield)();
  (void)lock_wait(WAIT_DEAF, 0, NULL, NULL, 0, NULL, 0);
  return 0;
}

/* --- signals --------------------------------------------------------------------------- */

int pause(void) {
  if (!lock_on()) return REAL(pause)();
  (void)lock_wait(0, WIRE_NEVER, NULL, NULL, 0, NULL, 0);
  return interrupted();
}

int sigsuspend(const sigset_t *mask) {
  if (!lock_on()) return REAL(sigsuspend)(mask);
  (void)lock_wait(0, WIRE_NEVER, NULL, NULL, 0, mask, 0);
  return interrupted();
}

int sigtimedwait(const sigset_t *set, siginfo_t *info, const struct timespec *timeout) {
  static const struct timespec none = {0};
  uint64_t until;
  sigset_t mask;
  if (!lock_on()) return REAL(sigtimedwait)(set, info, timeout);
  until = timeout != NULL ? lock_after(lock_ns(timeout)) : WIRE_NEVER;
  pthread_sigmask(SIG_SETMASK, NULL, &mask);
  for (int n = 1; n < 65; n++)
    if (sigismember(set, n) == 1) sigdelset(&mask, n);
  for (;;) {
    int got = REAL(sigtimedwait)(set, info, &none);
    if (got >= 0 || errno != EAGAIN || lock_now() >= until) return got;
    if (lock_wait(0, until, NULL, NULL, 0, &mask, 1) != CAUSE_SIGNAL) continue;
    got = REAL(sigtimedwait)(set, info, &none);
    return got >= 0 ? got : interrupted();
  }
}

int sigwaitinfo(const sigset_t *set, siginfo_t *info) {
  return lock_on() ? sigtimedwait(set, info, NULL) : REAL(sigwaitinfo)(set, info);
}

int sigwait(const sigset_t *set, int *number) {
  int got;
  if (!lock_on()) return REAL(sigwait)(set, number);
  do got = sigtimedwait(set, NULL, NULL);
  while (got < 0 && errno == EINTR);
  *number = got;
  return got < 0 ? errno : 0;
}

int kill(pid_t pid, int number) {
  int result = REAL(kill)(pid, number);
  /* SIGSTOP wakes nobody */
  if (result == 0 && number != 0 && number != SIGSTOP && lock_on() && pid != wire_pid())
    (void)lock_tell(WIRE_POKE, (uint64_t)pid, (uint64_t)number);
  return result;
}

/* --- descriptors ----------------------------------------------------------------------- */

/* What has found nothing and was asked to wait for no longer. */
static int is_over(uint64_t until) {
  if (lock_now() < until) return 0;
  lock_polls();
  return 1;
}

static int ppoll_once(struct pollfd *fds, nfds_t n, uint64_t until, const sigset_t *mask) {
  static const struct timespec none = {0};
  int files[64];
  unsigned count = 0, what;
  for (nfds_t i = 0; i < n && count < 64; i++)
    if (fds[i].fd >= 0) files[count++] = fds[i].fd;
  for (what = count > 0 ? WAIT_FILES : 0;; what |= WAIT_AGAIN) {
    int cause, ready = REAL(ppoll)(fds, n, &none, NULL);
    if (ready != 0 || is_over(until)) return ready;
    cause = lock_wait(what, until, NULL, files, count, mask, 0);
    if (cause == CAUSE_SIGNAL) return interrupted();
    if (cause == CAUSE_OUTSIDE) return REAL(ppoll)(fds, n, NULL, mask);
  }
}

int ppoll(struct pollfd *fds, nfds_t n, const struct timespec *timeout, const sigset_t *mask) {
  if (!lock_on()) return REAL(ppoll)(fds, n, timeout, mask);
  return ppoll_once(fds, n, timeout != NULL ? lock_after(lock_ns(timeout)) : WIRE_NEVER, mask);
}

int poll(struct pollfd *fds, nfds_t n, int ms) {
  if (!lock_on()) return REAL(poll)(fds, n, ms);
  return ppoll_once(fds, n, ms < 0 ? WIRE_NEVER : lock_after((uint64_t)ms * 1000000), NULL);
}

int __poll_chk(struct pollfd *fds, nfds_t n, int ms, size_t size);
int __poll_chk(struct pollfd *fds, nfds_t n, int ms, size_t size) {
  if (size / sizeof(*fds) < n) abort();
  return poll(fds, n, ms);
}

static int select_until(int n, fd_set *in, fd_set *out, fd_set *bad, uint64_t until,
                        const sigset_t *mask) {
  fd_set asked[3] = {0}, *set[3] = {in, out, bad};
  int files[64];
  unsigned count = 0, what;
  for (int i = 0; i < 3; i++)
    if (set[i] != NULL) asked[i] = *set[i];
  for (int fd = 0; fd < n && count < 64; fd++)
    if ((in && FD_ISSET(fd, in)) || (out && FD_ISSET(fd, out)) || (bad && FD_ISSET(fd, bad)))
      files[count++] = fd;
  for (what = count > 0 ? WAIT_FILES : 0;; what |= WAIT_AGAIN) {
    struct timespec none = {0};
    int cause, ready = REAL(pselect)(n, in, out, bad, &none, NULL);
    if (ready != 0 || is_over(until)) return ready;
    cause = lock_wait(what, until, NULL, files, count, mask, 0);
    for (int i = 0; i < 3; i++)
      if (set[i] != NULL) *set[i] = asked[i];
    if (cause == CAUSE_SIGNAL) return interrupted();
    if (cause == CAUSE_OUTSIDE) return REAL(pselect)(n, in, out, bad, NULL, mask);
  }
}

int select(int n, fd_set *in, fd_set *out, fd_set *bad, struct timeval *timeout) {
  uint64_t until = WIRE_NEVER, now;
  int ready;
  if (!lock_on()) return REAL(select)(n, in, out, bad, timeout);
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

int pselect(int n, fd_set *in, fd_set *out, fd_set *bad, const struct timespec *timeout,
            const sigset_t *mask) {
  if (!lock_on()) return REAL(pselect)(n, in, out, bad, timeout, mask);
  return select_until(n, in, out, bad, timeout ? lock_after(lock_ns(timeout)) : WIRE_NEVER, mask);
}

int epoll_pwait(int fd, struct epoll_event *events, int most, int ms, const sigset_t *mask) {
  uint64_t until;
  if (!lock_on()) return REAL(epoll_pwait)(fd, events, most, ms, mask);
  until = ms < 0 ? WIRE_NEVER : lock_after((uint64_t)ms * 1000000);
  for (unsigned what = WAIT_FILES;; what |= WAIT_AGAIN) {
    int cause, ready = REAL(epoll_pwait)(fd, events, most, 0, NULL);
    if (ready != 0 || is_over(until)) return ready;
    cause = lock_wait(what, until, NULL, &fd, 1, mask, 0);
    if (cause == CAUSE_SIGNAL) return interrupted();
    if (cause == CAUSE_OUTSIDE) return REAL(epoll_pwait)(fd, events, most, -1, mask);
  }
}

int epoll_wait(int fd, struct epoll_event *events, int most, int ms) {
  if (!lock_on()) return REAL(epoll_wait)(fd, events, most, ms);
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

/* A blocking descriptor that would block. Signals are seen to when the call itself is made. */
static size_t await_ready(int fd, short events) {
  struct pollfd one = {.fd = fd, .events = events};
  static const struct timespec none = {0};
  int flags = lock_on() ? fcntl(fd, F_GETFL) : O_NONBLOCK, saved = errno;
  unsigned what = WAIT_FILES;
  size_t most = SIZE_MAX;
  while (flags >= 0 && !(flags & O_NONBLOCK) && REAL(ppoll)(&one, 1, &none, NULL) == 0) {
    if (lock_wait(what, WIRE_NEVER, NULL, &fd, 1, NULL, 0) == CAUSE_OUTSIDE) break;
    what |= WAIT_AGAIN;
  }
  if (events == POLLOUT && flags >= 0 && !(flags & O_NONBLOCK) && takes_parts(fd)) most = PIPE_BUF;
  errno = saved;
  return most;
}

static void await_socket(int fd, int flags) {
  char name[WIRE_NAME];
  if (!(flags & MSG_DONTWAIT) && lock_on() && !wire_is_file(fd, name))
    (void)await_ready(fd, POLLIN);
}

ssize_t recv(int fd, void *to, size_t length, int flags) {
  await_socket(fd, flags);
  return REAL(recv)(fd, to, length, flags);
}

ssize_t recvfrom(int fd, void *restrict to, size_t length, int flags,
                 struct sockaddr *restrict from, socklen_t *restrict size) {
  await_socket(fd, flags);
  return REAL(recvfrom)(fd, to, length, flags, from, size);
}

ssize_t recvmsg(int fd, struct msghdr *message, int flags) {
  await_socket(fd, flags);
  return REAL(recvmsg)(fd, message, flags);
}

int accept(int fd, struct sockaddr *restrict from, socklen_t *restrict size) {
  await_socket(fd, 0);
  return REAL(accept)(fd, from, size);
}

int accept4(int fd, struct sockaddr *restrict from, socklen_t *restrict size, int flags) {
  await_socket(fd, 0);
  return REAL(accept4)(fd, from, size, flags);
}

/* A pipe as standard input or output: the C library would read and write it past us. */
static ssize_t pipe_read(void *fd, char *to, size_t length) {
  return read((int)(intptr_t)fd, to, length);
}
static ssize_t pipe_write(void *fd, const char *from, size_t length) {
  ssize_t n = write((int)(intptr_t)fd, from, length);
  return n < 0 ? 0 : n;
}

static void replace(FILE **stream, int fd, const char *mode) {
  static const cookie_io_functions_t calls = {pipe_read, pipe_write, NULL, NULL};
  struct stat status;
  FILE *made;
  if (fstat(fd, &status) < 0 || !S_ISFIFO(status.st_mode)) return;
  made = fopencookie((void *)(intptr_t)fd, mode, calls);
  if (made == NULL) return;
  made->_fileno = fd;
  *stream = made;
}

extern void (*lock_at_start)(void);
static void take_pipes(void) {
  device_await = await_ready;
  replace(&stdin, 0, "r");
  replace(&stdout, 1, "w");
}
__attribute__((constructor(101))) static void offer(void) {
  lock_at_start = take_pipes;
}
