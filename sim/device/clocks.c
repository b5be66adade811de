/* SPDX-License-Identifier: Apache-2.0 */
/* Lock-step: the clocks show machine time, and the timers run by it. */
#define _GNU_SOURCE
#include <errno.h>
#include <signal.h>
#include <stdint.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#include "device.h"

#define ALARM 0 /* the number of the timer of alarm() and setitimer() */

/* --- clocks ---------------------------------------------------------------------------- */

int clock_gettime(clockid_t clock, struct timespec *at) {
  uint64_t now;
  int real = clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE || clock == CLOCK_TAI;
  int cpu = clock == CLOCK_PROCESS_CPUTIME_ID || clock == CLOCK_THREAD_CPUTIME_ID || clock < 0;
  if (!lock_on() || cpu) return REAL(clock_gettime)(clock, at);
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

static void tell_left(const struct wire_timer *timer, struct itimerspec *left) {
  uint64_t now = lock_now();
  if (left == NULL) return;
  left->it_interval = lock_span(timer->interval);
  left->it_value = lock_span(timer->first == 0 ? 0 : timer->first > now ? timer->first - now : 1);
}

/* Sets a timer of the server, or asks (`to` is null); what was left of it. */
static int set_timer(uint64_t number, const struct wire_timer *to, struct itimerspec *left) {
  struct wire_timer before = {0};
  uint32_t room = sizeof(before);
  int result = lock_ask(WIRE_TIMER, number, 0, to, to != NULL ? sizeof(*to) : 0, &before, &room);
  if (result >= 0) tell_left(&before, left);
  return device_fail(result);
}

static int is_time(const struct timespec *at) {
  if (at->tv_sec >= 0 && at->tv_sec <= INT32_MAX && at->tv_nsec >= 0 && at->tv_nsec < SECOND)
    return 1;
  errno = EINVAL;
  return 0;
}

static int arm(struct wire_timer *timer, clockid_t clock, int absolute,
               const struct itimerspec *to) {
  if (!is_time(&to->it_value) || !is_time(&to->it_interval)) return -1;
  timer->interval = lock_ns(&to->it_interval);
  timer->first = 0;
  if (lock_ns(&to->it_value) > 0) {
    timer->first = absolute ? lock_until(clock, &to->it_value) : lock_after(lock_ns(&to->it_value));
    if (timer->first == 0) timer->first = 1; /* it was long ago, and is not off */
  }
  return 0;
}

int setitimer(__itimer_which_t which, const struct itimerval *to, struct itimerval *before) {
  struct wire_timer timer = {.signal = SIGALRM};
  struct itimerspec at = {0}, left = {0};
  if (!lock_on() || which != ITIMER_REAL) return REAL(setitimer)(which, to, before);
  TIMEVAL_TO_TIMESPEC(&to->it_value, &at.it_value);
  TIMEVAL_TO_TIMESPEC(&to->it_interval, &at.it_interval);
  if (arm(&timer, CLOCK_MONOTONIC, 0, &at) < 0 || set_timer(ALARM, &timer, &left) < 0) return -1;
  if (before != NULL) {
    TIMESPEC_TO_TIMEVAL(&before->it_value, &left.it_value);
    TIMESPEC_TO_TIMEVAL(&before->it_interval, &left.it_interval);
  }
  return 0;
}

int getitimer(__itimer_which_t which, struct itimerval *now) {
  struct itimerspec left = {0};
  if (!lock_on() || which != ITIMER_REAL) return REAL(getitimer)(which, now);
  if (set_timer(ALARM, NULL, &left) < 0) return -1;
  TIMESPEC_TO_TIMEVAL(&now->it_value, &left.it_value);
  TIMESPEC_TO_TIMEVAL(&now->it_interval, &left.it_interval);
  return 0;
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

/* A timer_t is its number. */
static struct own {
  struct wire_timer with;
  clockid_t clock;
} own[WIRE_TIMERS];
static unsigned next_own = 1;

static struct own *own_of(timer_t id) {
  uintptr_t number = (uintptr_t)id;
  if (number > 0 && number < next_own) return &own[number];
  errno = EINVAL;
  return NULL;
}

CALL(int, timer_create, (clockid_t clock, struct sigevent *event, timer_t *id),
     (clock, event, id)) {
  struct own made = {{.signal = SIGALRM}, clock};
  if (next_own == sizeof(own) / sizeof(own[0])) return errno = EAGAIN, -1;
  made.with.value = next_own;
  if (event != NULL) {
    if (event->sigev_notify == SIGEV_THREAD) return errno = EINVAL, -1;
    made.with.signal = event->sigev_notify == SIGEV_NONE ? 0 : event->sigev_signo;
    made.with.value = (uint64_t)(uintptr_t)event->sigev_value.sival_ptr;
  }
  own[next_own] = made;
  *id = (timer_t)(uintptr_t)next_own++;
  return 0;
}

CALL(int, timer_settime,
     (timer_t id, int flags, const struct itimerspec *to, struct itimerspec *before),
     (id, flags, to, before)) {
  struct own *t;
  t = own_of(id);
  if (t == NULL || arm(&t->with, t->clock, flags & TIMER_ABSTIME, to) < 0) return -1;
  return set_timer((uintptr_t)id, &t->with, before);
}

CALL(int, timer_gettime, (timer_t id, struct itimerspec *now), (id, now)) {
  return own_of(id) != NULL ? set_timer((uintptr_t)id, NULL, now) : -1;
}

int timer_getoverrun(timer_t id) {
  return lock_on() ? 0 : REAL(timer_getoverrun)(id);
}

CALL(int, timer_delete, (timer_t id), (id)) {
  const struct wire_timer off = {0};
  return own_of(id) != NULL ? set_timer((uintptr_t)id, &off, NULL) : -1;
}

/* An eventfd, which is read and polled like a timerfd, and which this process writes to. */
static struct own files[1024];
static int most_files; /* have been set */

CALL(int, timerfd_create, (clockid_t clock, int flags), (clock, flags)) {
  int fd;
  fd = eventfd(0,
               (flags & TFD_NONBLOCK ? EFD_NONBLOCK : 0) | (flags & TFD_CLOEXEC ? EFD_CLOEXEC : 0));
  if (fd >= 0 && fd < 1024) files[fd] = (struct own){{0}, clock};
  return fd;
}

int timerfd_settime(int fd, int flags, const struct itimerspec *to, struct itimerspec *before) {
  if (!lock_on() || fd < 0 || fd >= 1024) return REAL(timerfd_settime)(fd, flags, to, before);
  tell_left(&files[fd].with, before);
  if (fd >= most_files) most_files = fd + 1;
  return arm(&files[fd].with, files[fd].clock, flags & TFD_TIMER_ABSTIME, to);
}

CALL(int, timerfd_gettime, (int fd, struct itimerspec *now), (fd, now)) {
  tell_left(&files[fd].with, now);
  return 0;
}

uint64_t lock_timers(uint64_t now) {
  uint64_t next = WIRE_NEVER;
  for (int fd = 0; fd < most_files; fd++) {
    struct wire_timer *timer = &files[fd].with;
    uint64_t times = 1;
    if (timer->first > 0 && timer->first <= now) {
      if (timer->interval > 0) times += (now - timer->first) / timer->interval;
      timer->first = timer->interval > 0 ? timer->first + times * timer->interval : 0;
      (void)!syscall(SYS_write, fd, &times, sizeof(times));
    }
    if (timer->first > 0 && timer->first < next) next = timer->first;
  }
  return next;
}

void lock_forget_timers(void) {
  most_files = 0;
}
