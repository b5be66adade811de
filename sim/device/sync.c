/* SPDX-License-Identifier: Apache-2.0 */
/* Lock-step: threads and children, and what they wait for of each other. One runs at a time, so
 * that a lock is taken or waited for; what others wait for is known here by its address. Between
 * processes there are only semaphores. */
#define _GNU_SOURCE
#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "device.h"

/* How many threads of this process wait with a key: most wakes wake nobody and go unsaid. */
#define PLACES 1024
static unsigned waiting[PLACES];

static unsigned *place_of(const void *key) {
  return &waiting[((uintptr_t)key >> 3) % PLACES];
}

/* The enum wire_cause. */
static int sleep_with(const void *key, uint64_t until, unsigned how) {
  int cause;
  __atomic_add_fetch(place_of(key), 1, __ATOMIC_SEQ_CST);
  cause = lock_wait(WAIT_KEY | how, until, key, NULL, 0, NULL, 0);
  __atomic_sub_fetch(place_of(key), 1, __ATOMIC_SEQ_CST);
  return cause;
}

/* 0, or ETIMEDOUT. Signals are handled; who waits goes on waiting, also when it is cancelled. */
static int wait_for(const void *key, uint64_t until) {
  int state;
  if (lock_now() >= until) return ETIMEDOUT;
  (void)pthread_setcancelstate(PTHREAD_CANCEL_DISABLE, &state);
  (void)sleep_with(key, until, 0);
  (void)pthread_setcancelstate(state, NULL);
  return 0;
}

static void wake(const void *key, unsigned count) {
  if (*place_of(key) > 0 && lock_on()) (void)lock_tell(WIRE_WAKE, (uint64_t)(uintptr_t)key, count);
}

/* --- threads --------------------------------------------------------------------------- */

struct start {
  void *(*run)(void *);
  void *argument;
  unsigned number;
};

static void *run_thread(void *given) {
  struct start start = *(struct start *)given;
  free(given);
  lock_begin_thread(start.number);
  return start.run(start.argument);
}

CALL(int, pthread_create,
     (pthread_t * thread, const pthread_attr_t *how, void *(*run)(void *), void *arg),
     (thread, how, run, arg)) {
  static unsigned made; /* in the order of their creation they run */
  struct start *start;
  int result;
  start = malloc(sizeof(*start));
  if (start == NULL) return EAGAIN;
  *start = (struct start){run, arg, ++made};
  (void)lock_tell(WIRE_SPAWN, 0, 0);
  result = REAL(pthread_create)(thread, how, run_thread, start);
  if (result == 0) return 0;
  free(start);
  (void)lock_tell(WIRE_SPAWN, 0, 1);
  return result;
}

int pthread_join(pthread_t thread, void **result) {
  const void *key = (void *)thread;
  while (lock_on() && lock_wait(WAIT_THREAD, WIRE_NEVER, key, NULL, 0, NULL, 0) == CAUSE_SIGNAL)
    continue;
  return REAL(pthread_join)(thread, result);
}

/* --- mutexes, read-write locks, semaphores --------------------------------------------- */

/* Without an end, until a time of a clock, and of the real-time clock. EDEADLK: `has`, the thread
 * itself has it, and the C library would know. */
#define LOCK(of, kind, has)                                                               \
  static int of##_##kind##until(of##_t *l, uint64_t until) {                              \
    int result;                                                                           \
    do result = of##_try##kind##lock(l);                                                  \
    while (result == EBUSY && (result = wait_for(l, until)) == 0);                        \
    return result;                                                                        \
  }                                                                                       \
  CALL(int, of##_##kind##lock, (of##_t * l), (l)) {                                       \
    return (has) ? EDEADLK : of##_##kind##until(l, WIRE_NEVER);                           \
  }                                                                                       \
  CALL(int, of##_clock##kind##lock, (of##_t * l, clockid_t c, const struct timespec *at), \
       (l, c, at)) {                                                                      \
    return of##_##kind##until(l, lock_until(c, at));                                      \
  }                                                                                       \
  int of##_timed##kind##lock(of##_t *l, const struct timespec *at) {                      \
    return of##_clock##kind##lock(l, CLOCK_REALTIME, at);                                 \
  }
LOCK(pthread_mutex, ,
     (l->__data.__kind & 3) == PTHREAD_MUTEX_ERRORCHECK && l->__data.__owner == gettid())
LOCK(pthread_rwlock, rd, l->__data.__cur_writer != 0 && l->__data.__cur_writer == gettid())
LOCK(pthread_rwlock, wr, l->__data.__cur_writer != 0 && l->__data.__cur_writer == gettid())
int pthread_mutex_unlock(pthread_mutex_t *m) {
  int result = REAL(pthread_mutex_unlock)(m);
  wake(m, 1);
  return result;
}
int pthread_rwlock_unlock(pthread_rwlock_t *l) {
  int result = REAL(pthread_rwlock_unlock)(l);
  wake(l, UINT32_MAX);
  return result;
}

/* As the C library keeps it: another process may post it, which does not know who waits. */
static int is_shared(const sem_t *s) {
  return ((const int *)(const void *)s)[2] != 0;
}

/* A shared one is tried again each time that somebody else has run. Once more after a signal, as a
 * post may have come with it that woke nobody else. */
static int take(sem_t *s, uint64_t until) {
  unsigned again = 0;
  for (int cause = CAUSE_WOKEN; sem_trywait(s) != 0; again = WAIT_AGAIN) {
    if (errno != EAGAIN) return -1;
    errno = cause == CAUSE_SIGNAL ? EINTR : ETIMEDOUT;
    if (cause == CAUSE_SIGNAL || lock_now() >= until) return -1;
    cause = is_shared(s)
                ? lock_wait(WAIT_FILES | LOCK_RESTARTS | again, until, NULL, NULL, 0, NULL, 0)
                : sleep_with(s, until, LOCK_RESTARTS);
    if (is_shared(s) && cause == CAUSE_OUTSIDE) return REAL(sem_wait)(s);
  }
  return 0;
}
CALL(int, sem_wait, (sem_t * s), (s)) {
  return take(s, WIRE_NEVER);
}
CALL(int, sem_clockwait, (sem_t * s, clockid_t clock, const struct timespec *at), (s, clock, at)) {
  return take(s, lock_until(clock, at));
}
int sem_timedwait(sem_t *s, const struct timespec *at) {
  return sem_clockwait(s, CLOCK_REALTIME, at);
}
int sem_post(sem_t *s) {
  int result = REAL(sem_post)(s);
  wake(s, 1);
  return result;
}

/* --- conditions, barriers -------------------------------------------------------------- */

CALL(int, pthread_cond_signal, (pthread_cond_t * c), (c)) {
  wake(c, 1);
  return 0;
}
CALL(int, pthread_cond_broadcast, (pthread_cond_t * c), (c)) {
  wake(c, UINT32_MAX);
  return 0;
}

static void lock_again(void *m) {
  (void)pthread_mutex_lock(m);
}

/* A thread that is cancelled meanwhile has its mutex again before its own handlers run. */
static int await_condition(pthread_cond_t *c, pthread_mutex_t *m, uint64_t until) {
  int late, result = pthread_mutex_unlock(m);
  if (result != 0) return result;
  pthread_cleanup_push(lock_again, m);
  if (lock_now() < until) (void)sleep_with(c, until, 0);
  late = lock_now() >= until;
  pthread_cleanup_pop(1);
  return late ? ETIMEDOUT : 0;
}
int pthread_cond_wait(pthread_cond_t *c, pthread_mutex_t *m) {
  return lock_on() ? await_condition(c, m, WIRE_NEVER) : REAL(pthread_cond_wait)(c, m);
}
CALL(int, pthread_cond_clockwait,
     (pthread_cond_t * c, pthread_mutex_t *m, clockid_t clock, const struct timespec *at),
     (c, m, clock, at)) {
  return await_condition(c, m, lock_until(clock, at));
}
/* The clock that pthread_condattr_setclock() gave stands in bit 1 of this word. */
CALL(int, pthread_cond_timedwait,
     (pthread_cond_t * c, pthread_mutex_t *m, const struct timespec *at), (c, m, at)) {
  int monotonic = (c->__data.__wrefs & 2) != 0;
  return await_condition(c, m, lock_until(monotonic ? CLOCK_MONOTONIC : CLOCK_REALTIME, at));
}

/* The first fields of the C library's; it keeps no others while nobody waits in it. */
struct barrier {
  unsigned arrived, turn, count;
};

CALL(int, pthread_barrier_wait, (pthread_barrier_t * given), (given)) {
  struct barrier *b = (struct barrier *)(void *)given;
  unsigned turn = b->turn;
  if (++b->arrived == b->count) {
    b->arrived = 0;
    b->turn++;
    wake(b, UINT32_MAX);
    return PTHREAD_BARRIER_SERIAL_THREAD;
  }
  while (b->turn == turn) (void)wait_for(b, WIRE_NEVER);
  return 0;
}

/* --- children -------------------------------------------------------------------------- */

/* How to ask for a child again: WNOHANG, or 0 where only the world outside can end one; or -1. */
static int await_child(void) {
  int cause = lock_wait(WAIT_CHILD | LOCK_RESTARTS, WIRE_NEVER, NULL, NULL, 0, NULL, 0);
  if (cause == CAUSE_SIGNAL) errno = EINTR;
  return cause == CAUSE_SIGNAL ? -1 : cause == CAUSE_OUTSIDE ? 0 : WNOHANG;
}

pid_t wait4(pid_t pid, int *status, int options, struct rusage *usage) {
  for (int how = lock_on() ? WNOHANG : 0; how >= 0; how = await_child()) {
    pid_t found = REAL(wait4)(pid, status, options | how, usage);
    if (found == 0 && options & WNOHANG) lock_polls();
    if (found != 0 || (options & WNOHANG)) return found;
  }
  return -1;
}
int waitid(idtype_t kind, id_t id, siginfo_t *to, int options) {
  siginfo_t none, *found = to != NULL ? to : &none;
  for (int how = lock_on() ? WNOHANG : 0; how >= 0; how = await_child()) {
    found->si_pid = 0;
    if (REAL(waitid)(kind, id, found, options | how) < 0) return -1;
    if (found->si_pid == 0 && options & WNOHANG) lock_polls();
    if (found->si_pid != 0 || how == 0 || options & WNOHANG) return 0;
  }
  return -1;
}
pid_t wait3(int *status, int options, struct rusage *usage) {
  return wait4(-1, status, options, usage);
}
pid_t waitpid(pid_t pid, int *status, int options) {
  return wait4(pid, status, options, NULL);
}
pid_t wait(int *status) {
  return wait4(-1, status, 0, NULL);
}

pid_t fork(void) {
  pid_t pid = REAL(fork)();
  if (pid > 0 && lock_on()) (void)lock_tell(WIRE_SPAWN, (uint64_t)pid, 0);
  return pid;
}
SAME(vfork, fork);

#define SPAWN(name)                                                                              \
  CALL(int, name,                                                                                \
       (pid_t * pid, const char *of, const void *act, const void *how, char **argv, char **env), \
       (pid, of, act, how, argv, env)) {                                                         \
    int result = REAL(name)(pid, of, act, how, argv, env);                                       \
    if (result == 0 && pid != NULL) (void)lock_tell(WIRE_SPAWN, (uint64_t)*pid, 0);              \
    return result;                                                                               \
  }
SPAWN(posix_spawn)
SPAWN(posix_spawnp)

int system(const char *command) {
  int status = -1;
  pid_t pid;
  if (!lock_on() || command == NULL) return REAL(system)(command);
  pid = fork();
  if (pid < 0) return -1;
  if (pid == 0) {
    (void)execl("/bin/sh", "sh", "-c", command, NULL);
    _exit(127);
  }
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) continue;
  return status;
}
