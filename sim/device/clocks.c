/* SPDX-License-Identifier: Apache-2.0 */
/* Lock-step: the clocks show machine time, and the timers run by it. */
#define _GNU_SOURCE
#include <errno.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#include "device.h"

/* --- clocks ---------------------------------------------------------------------------- */

struct timespec lock_span(uint64_t ns) {
  return (struct timespec){(time_t)(ns / SECOND), (long)(ns % SECOND)};
}

uint64_t lock_ns(const struct timespec *span) {
  if (span->tv_sec > INT32_MAX) return WIRE_NEVER - 1;
  return (uint64_t)span->tv_sec * SECOND + (uint64_t)span->tv_nsec;
}

int clock_gettime(clockid_t clock, struct timespec *at) {
  uint64_t now;
  int real = clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE || clock == CLOCK_TAI;
  int cpu = clock == CLOCK_PROCESS_CPUTIME_ID || clock == CLOCK_THREAD_CPUTIME_ID || clock < 0;
  if (!lock_on() || cpu) return (int)syscall(SYS_clock_gettime, clock, at);
  now = lock_now();
  at->tv_sec = (time_t)(now / SECOND + (real ? EPOCH : 0));
  at->tv_nsec = (long)(now % SECOND);
  return 0;
}

int gettimeofday(struct timeval *restrict at, void *restrict zone) {
  struct timespec now;
  (void)zone;
  (void)clock_gettime(CLOCK_REALTIME, &now);
  *at = (struct timeval){now.tv_sec, now.tv_nsec / 1000};
  return 0;
}

time_t time(time_t *at) {
  struct timespec now;
  (void)clock_gettime(CLOCK_REALTIME, &now);
  if (at != NULL) *at = now.tv_sec;
  return now.tv_sec;
}

int timespec_get(struct timespec *at, int base) {
  return base == TIME_UTC && clock_gettime(CLOCK_REALTIME, at) == 0 ? base : 0;
}

/* --- timers ---------------------------------------------------------------------------- */

#define TIMERS 64

static struct timer {
  uint64_t first, interval; /* ns; first = machine time, 0: off */
  clockid_t clock;
  int signal, file; /* what an end sends, or is written to; 0: none */
  union sigval value;
  int taken;
} timers[TIMERS] = {
    {.signal = SIGALRM, .taken = 1}}; /* of alarm(), of others; a timer_t is a place */

static struct timer *made(clockid_t clock, int signal, int file) {
  for (struct timer *t = timers; t < timers + TIMERS; t++) {
    if (t->taken && (file == 0 || t->file != file)) continue;
    *t = (struct timer){.clock = clock, .signal = signal, .file = file, .taken = 1};
    t->value.sival_int = (int)(t - timers);
    return t;
  }
  errno = EAGAIN;
  return NULL;
}

static struct timer *timer_of(timer_t id) {
  const uintptr_t number = (uintptr_t)id;
  return number > 0 && number < TIMERS && timers[number].taken ? &timers[number] : NULL;
}

static struct timer *timer_of_file(int file) {
  struct timer *t = timers;
  while (t < timers + TIMERS && t->file != file) t++;
  return file > 0 && t < timers + TIMERS ? t : NULL;
}

static int is_time(const struct timespec *at) {
  return at->tv_sec >= 0 && at->tv_sec <= INT32_MAX && at->tv_nsec >= 0 && at->tv_nsec < SECOND;
}

/* Either may be null. */
static int set(struct timer *t, int absolute, const struct itimerspec *to,
               struct itimerspec *before) {
  const uint64_t now = lock_now();
  if (t == NULL || (to != NULL && (!is_time(&to->it_value) || !is_time(&to->it_interval))))
    return errno = EINVAL, -1;
  if (before != NULL) {
    before->it_interval = lock_span(t->interval);
    before->it_value = lock_span(t->first == 0 ? 0 : t->first > now ? t->first - now : 1);
  }
  if (to == NULL) return 0;
  t->interval = lock_ns(&to->it_interval);
  t->first = 0;
  if (to->it_value.tv_sec > 0 || to->it_value.tv_nsec > 0) {
    t->first = absolute ? lock_until(t->clock, &to->it_value) : now + lock_ns(&to->it_value);
    if (t->first == 0) t->first = 1; /* it was long ago, and is not off */
  }
  return 0;
}

uint64_t lock_timers(uint64_t now) {
  uint64_t next = WIRE_NEVER;
  for (struct timer *t = timers; t < timers + TIMERS; t++) {
    uint64_t times = 1;
    if (t->first > 0 && t->first <= now) {
      if (t->interval > 0) times += (now - t->first) / t->interval;
      t->first = t->interval > 0 ? t->first + times * t->interval : 0;
      if (t->file > 0) (void)!syscall(SYS_write, t->file, &times, sizeof(times));
      if (t->signal > 0) (void)sigqueue(wire_pid, t->signal, t->value);
    }
    if (t->first > 0 && t->first < next) next = t->first;
  }
  return next;
}

void lock_forget_timers(void) {
  for (struct timer *t = timers; t < timers + TIMERS; t++) t->first = 0;
}

void lock_forget_file(int file) {
  struct timer *t = timer_of_file(file);
  if (t != NULL) *t = (struct timer){0};
}

int setitimer(__itimer_which_t which, const struct itimerval *to, struct itimerval *before) {
  struct itimerspec at = {0}, left = {0};
  if (!lock_on() || which != ITIMER_REAL) return REAL(setitimer)(which, to, before);
  if (to != NULL) TIMEVAL_TO_TIMESPEC(&to->it_value, &at.it_value);
  if (to != NULL) TIMEVAL_TO_TIMESPEC(&to->it_interval, &at.it_interval);
  if (set(timers, 0, to != NULL ? &at : NULL, &left) < 0) return -1;
  if (before != NULL) {
    TIMESPEC_TO_TIMEVAL(&before->it_value, &left.it_value);
    TIMESPEC_TO_TIMEVAL(&before->it_interval, &left.it_interval);
  }
  return 0;
}

int getitimer(__itimer_which_t which, struct itimerval *left) {
  if (!lock_on() || which != ITIMER_REAL) return REAL(getitimer)(which, left);
  return setitimer(which, NULL, left);
}

unsigned alarm(unsigned seconds) {
  struct itimerval at = {.it_value = {(time_t)seconds, 0}}, left = {0};
  (void)setitimer(ITIMER_REAL, &at, &left);
  return (unsigned)left.it_value.tv_sec + (left.it_value.tv_usec > 0);
}

useconds_t ualarm(useconds_t us, useconds_t interval) {
  struct itimerval left = {0},
                   at = {{interval / 1000000, interval % 1000000}, {us / 1000000, us % 1000000}};
  (void)setitimer(ITIMER_REAL, &at, &left);
  return (useconds_t)(left.it_value.tv_sec * 1000000 + left.it_value.tv_usec);
}

CALL(int, timer_create, (clockid_t clock, struct sigevent *event, timer_t *id),
     (clock, event, id)) {
  struct timer *t;
  if (event != NULL && event->sigev_notify == SIGEV_THREAD) return errno = EINVAL, -1;
  t = made(clock, event == NULL ? SIGALRM : event->sigev_signo, 0);
  if (t == NULL) return -1;
  if (event != NULL && event->sigev_notify == SIGEV_NONE) t->signal = 0;
  if (event != NULL) t->value = event->sigev_value;
  *id = (timer_t)(t - timers);
  return 0;
}

CALL(int, timer_settime,
     (timer_t id, int flags, const struct itimerspec *to, struct itimerspec *before),
     (id, flags, to, before)) {
  return set(timer_of(id), flags & TIMER_ABSTIME, to, before);
}

CALL(int, timer_gettime, (timer_t id, struct itimerspec *left), (id, left)) {
  return set(timer_of(id), 0, NULL, left);
}

int timer_getoverrun(timer_t id) {
  return lock_on() ? 0 : REAL(timer_getoverrun)(id);
}

CALL(int, timer_delete, (timer_t id), (id)) {
  struct timer *t = timer_of(id);
  if (t == NULL) return errno = EINVAL, -1;
  *t = (struct timer){0};
  return 0;
}

/* An eventfd, which is read and polled like a timerfd, and which this process writes to. */
CALL(int, timerfd_create, (clockid_t clock, int flags), (clock, flags)) {
  const int how =
      (flags & TFD_NONBLOCK ? EFD_NONBLOCK : 0) | (flags & TFD_CLOEXEC ? EFD_CLOEXEC : 0);
  const int fd = eventfd(0, how);
  return fd >= 0 && made(clock, 0, fd) == NULL ? -1 : fd;
}

CALL(int, timerfd_settime,
     (int fd, int flags, const struct itimerspec *to, struct itimerspec *before),
     (fd, flags, to, before)) {
  return set(timer_of_file(fd), flags & TFD_TIMER_ABSTIME, to, before);
}

CALL(int, timerfd_gettime, (int fd, struct itimerspec *left), (fd, left)) {
  return set(timer_of_file(fd), 0, NULL, left);
}
