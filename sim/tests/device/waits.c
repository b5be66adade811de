/* SPDX-License-Identifier: Apache-2.0 */
/* Lock-step: every call that sleeps or waits, one after the other; a line with what it was and how
 * many microseconds of machine time it took. */
#define _GNU_SOURCE
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <threads.h>
#include <time.h>
#include <unistd.h>

static int64_t now_us(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * 1000000 + t.tv_nsec / 1000;
}

#define TIMED(call)                                                    \
  do {                                                                 \
    int64_t begin_ = now_us();                                         \
    long result_ = (long)(call);                                       \
    printf("%s %ld %ld\n", #call, result_, (long)(now_us() - begin_)); \
  } while (0)

static const struct timespec ms5 = {0, 5000000};
static volatile int caught;
static void catch(int number) {
  caught = number;
}

static struct timespec at(clockid_t clock, int ms) {
  struct timespec t;
  clock_gettime(clock, &t);
  t.tv_nsec += ms * 1000000;
  t.tv_sec += t.tv_nsec / 1000000000;
  t.tv_nsec %= 1000000000;
  return t;
}

static void sleeping(void) {
  struct timespec later = at(CLOCK_REALTIME, 12);
  struct timeval tv = {0, 4000};
  fd_set none;
  int e = epoll_create1(0);
  FD_ZERO(&none);
  TIMED(usleep(1500));
  TIMED(nanosleep(&ms5, NULL));
  TIMED(clock_nanosleep(CLOCK_MONOTONIC, 0, &ms5, NULL));
  TIMED(clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, &later, NULL));
  TIMED(sleep(1));
  TIMED(nanosleep(&ms5, NULL));
  TIMED(select(0, NULL, NULL, NULL, &tv));
  TIMED(pselect(0, &none, NULL, NULL, &ms5, NULL));
  TIMED(poll(NULL, 0, 3));
  TIMED(ppoll(NULL, 0, &ms5, NULL));
  TIMED(epoll_wait(e, &(struct epoll_event){0}, 1, 6));
  TIMED(sched_yield());
  close(e);
}

static void signals(void) {
  struct itimerval once = {{0, 0}, {0, 2000}};
  struct itimerspec often = {{0, 3000000}, {0, 1000000}};
  sigset_t set, empty;
  timer_t id;
  uint64_t count;
  int number, fd = timerfd_create(CLOCK_MONOTONIC, 0);
  struct pollfd one = {.fd = fd, .events = POLLIN};
  signal(SIGALRM, catch);
  setitimer(ITIMER_REAL, &once, NULL);
  TIMED(pause());
  alarm(1);
  TIMED(usleep(5000000)); /* ends with the alarm */
  sigemptyset(&empty);
  sigemptyset(&set);
  sigaddset(&set, SIGALRM);
  sigprocmask(SIG_BLOCK, &set, NULL);
  setitimer(ITIMER_REAL, &once, NULL);
  TIMED(sigsuspend(&empty));
  setitimer(ITIMER_REAL, &once, NULL);
  TIMED(sigwait(&set, &number));
  setitimer(ITIMER_REAL, &once, NULL);
  TIMED(sigwaitinfo(&set, NULL));
  TIMED(sigtimedwait(&set, NULL, &ms5));
  sigprocmask(SIG_UNBLOCK, &set, NULL);
  timer_create(CLOCK_MONOTONIC, NULL, &id);
  timer_settime(id, 0, &often, NULL);
  TIMED(pause());
  TIMED(pause());
  timer_delete(id);
  timerfd_settime(fd, 0, &often, NULL);
  TIMED(poll(&one, 1, -1));
  usleep(6500);
  TIMED(read(fd, &count, sizeof count));
  printf("runs out %d\n", (int)count);
  TIMED(read(fd, &count, sizeof count));
}

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t cond = PTHREAD_COND_INITIALIZER;
static pthread_barrier_t barrier;
static sem_t sem;

static void *other(void *arg) {
  pthread_mutex_lock(&lock);
  usleep(3000);
  pthread_mutex_unlock(&lock);
  usleep(1000);
  pthread_mutex_lock(&lock);
  pthread_cond_signal(&cond);
  pthread_mutex_unlock(&lock);
  usleep(2000);
  sem_post(&sem);
  usleep(1000);
  pthread_barrier_wait(&barrier);
  usleep(4000);
  return arg;
}

static void threads(void) {
  struct timespec later;
  pthread_t t;
  sem_init(&sem, 0, 0);
  pthread_barrier_init(&barrier, NULL, 2);
  pthread_create(&t, NULL, other, NULL);
  usleep(100);
  TIMED(pthread_mutex_lock(&lock));
  TIMED(pthread_cond_wait(&cond, &lock));
  later = at(CLOCK_REALTIME, 1);
  TIMED(pthread_cond_timedwait(&cond, &lock, &later));
  pthread_mutex_unlock(&lock);
  TIMED(sem_wait(&sem));
  later = at(CLOCK_REALTIME, 1);
  TIMED(sem_timedwait(&sem, &later));
  TIMED(pthread_barrier_wait(&barrier) == 0);
  TIMED(pthread_join(t, NULL));
}

static void processes(void) {
  int ends[2];
  char byte;
  if (pipe(ends) < 0) return;
  if (fork() == 0) {
    usleep(8000);
    _exit(write(ends[1], "x", 1) == 1 ? 0 : 1);
  }
  TIMED(read(ends[0], &byte, 1));
  TIMED(wait(NULL) > 0);
  TIMED(system("sleep 0.25"));
  if (fork() == 0) {
    usleep(3000);
    _exit(kill(getppid(), SIGSTOP) != 0 || kill(getppid(), SIGCONT) != 0);
  }
  TIMED(usleep(9000)); /* stopped and continued meanwhile */
  (void)wait(NULL);
}

/* A child that writes, or connects, every 2 ms. */
static void sockets(void) {
  struct sockaddr_un name = {.sun_family = AF_UNIX};
  socklen_t size = sizeof(sa_family_t);
  int pair[2], door = socket(AF_UNIX, SOCK_STREAM, 0), e = epoll_create1(0);
  char byte;
  struct iovec part = {&byte, 1};
  struct msghdr message = {.msg_iov = &part, .msg_iovlen = 1};
  if (socketpair(AF_UNIX, SOCK_STREAM, 0, pair) < 0) return;
  if (bind(door, (struct sockaddr *)&name, size) < 0 || listen(door, 2) < 0) return;
  size = sizeof name; /* the kernel has chosen one */
  if (getsockname(door, (struct sockaddr *)&name, &size) < 0) return;
  if (fork() == 0) {
    for (int n = 0; n < 3; n++) {
      usleep(2000);
      if (write(pair[1], "x", 1) != 1) _exit(1);
    }
    for (int n = 0; n < 2; n++) {
      usleep(2000);
      if (connect(socket(AF_UNIX, SOCK_STREAM, 0), (struct sockaddr *)&name, size) < 0) _exit(1);
    }
    usleep(2000);
    _exit(0);
  }
  TIMED(recv(pair[0], &byte, 1, 0));
  TIMED(recvfrom(pair[0], &byte, 1, 0, NULL, NULL));
  TIMED(recvmsg(pair[0], &message, 0));
  TIMED(accept(door, NULL, NULL) > 0);
  TIMED(accept4(door, NULL, NULL, 0) > 0);
  TIMED(waitpid(-1, NULL, 0) > 0);
  TIMED(epoll_pwait(e, &(struct epoll_event){0}, 1, 6, NULL));
}

static void child(void) {
  fflush(stdout);
  if (fork() == 0) {
    usleep(2000);
    _exit(0);
  }
}

static pthread_rwlock_t rw = PTHREAD_RWLOCK_INITIALIZER;

static void *holder(void *arg) {
  pthread_mutex_lock(&lock);
  pthread_rwlock_wrlock(&rw);
  usleep(3000);
  pthread_rwlock_unlock(&rw);
  pthread_mutex_unlock(&lock);
  usleep(2000);
  return arg;
}

static void kin(void) {
  struct sigevent by_thread = {.sigev_notify = SIGEV_THREAD};
  struct timespec later;
  timer_t id;
  pthread_t t;
  pthread_create(&t, NULL, holder, NULL);
  usleep(100);
  later = at(CLOCK_REALTIME, 1);
  TIMED(pthread_mutex_timedlock(&lock, &later));
  later = at(CLOCK_REALTIME, 1);
  TIMED(pthread_rwlock_timedwrlock(&rw, &later));
  TIMED(pthread_rwlock_rdlock(&rw));
  pthread_rwlock_unlock(&rw);
  TIMED(pthread_join(t, NULL));
  later = at(CLOCK_MONOTONIC, 1);
  pthread_mutex_lock(&lock);
  TIMED(pthread_cond_clockwait(&cond, &lock, CLOCK_MONOTONIC, &later));
  later = at(CLOCK_MONOTONIC, 1);
  TIMED(sem_clockwait(&sem, CLOCK_MONOTONIC, &later));
  ualarm(2000, 0);
  TIMED(pause());
  TIMED(timer_create(CLOCK_MONOTONIC, &by_thread, &id));
  child();
  TIMED(wait3(NULL, 0, NULL) > 0);
  child();
  TIMED(wait4(-1, NULL, 0, NULL) > 0);
  child();
  ualarm(1000, 0);
  (void)siginterrupt(SIGALRM, 1);  /* without SA_RESTART */
  TIMED(wait4(-1, NULL, 0, NULL)); /* ends with the alarm */
  TIMED(wait4(-1, NULL, 0, NULL) > 0);
}

static void *reader(void *end) {
  char byte;
  return (void *)read(*(int *)end, &byte, 1);
}

/* What is left of a timer, what a closed one does no more, one that is set to what is long ago. */
static void timers(void) {
  struct itimerspec often = {{0, 1000000}, {0, 3000000}}, once = {.it_value = {0, 1}};
  struct itimerval left;
  timer_t id;
  int fd = timerfd_create(CLOCK_MONOTONIC, 0), other = timerfd_create(CLOCK_MONOTONIC, 0), status;
  FILE *file;
  timer_create(CLOCK_MONOTONIC, NULL, &id);
  timer_settime(id, 0, &often, NULL);
  timerfd_settime(fd, 0, &often, NULL);
  timerfd_settime(other, 0, &often, NULL);
  ualarm(3000, 700);
  usleep(1000);
  TIMED((getitimer(ITIMER_REAL, &left), left.it_value.tv_usec + left.it_interval.tv_usec));
  TIMED((timer_gettime(id, &often), often.it_value.tv_nsec + often.it_interval.tv_nsec));
  TIMED((timerfd_gettime(fd, &often), often.it_value.tv_nsec + often.it_interval.tv_nsec));
  TIMED((timer_delete(id), timer_delete(id)));
  fflush(stdout);
  if (fork() == 0) _exit((getitimer(ITIMER_REAL, &left), left.it_value.tv_usec > 0));
  TIMED((wait(&status), status)); /* it inherits none */
  TIMED(ualarm(0, 0));
  close(fd);
  file = tmpfile();
  dup2(fd, other); /* closes it, too */
  usleep(5000);
  TIMED(fileno(file) == fd ? lseek(fd, 0, SEEK_END) : -1);
  fclose(file);
  close(other);
  timer_create(CLOCK_REALTIME, NULL, &id);
  TIMED((caught = 0, timer_settime(id, TIMER_ABSTIME, &once, NULL), usleep(10), caught));
  once.it_value = at(CLOCK_REALTIME, 2);
  TIMED((timer_settime(id, TIMER_ABSTIME, &once, NULL), pause()));
  TIMED((once.it_value.tv_nsec = 1000000000, timer_settime(id, 0, &once, NULL)));
  TIMED(timerfd_settime(0, 0, &often, NULL));
  TIMED((alarm(2), usleep(500000), alarm(0)));
  TIMED(read(timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK), &left, sizeof left));
  for (fd = 0; timer_create(CLOCK_MONOTONIC, NULL, &id) == 0;) fd++;
  TIMED(fd);
}

/* Loops that wait for no time; signals to a thread, and to a group. */
static void asking(void) {
  pthread_mutexattr_t checks;
  pthread_mutex_t mine;
  pthread_t t;
  void *got;
  int ends[2];
  const int64_t begin = now_us();
  while (now_us() < begin + 300) usleep(0);
  while (now_us() < begin + 600) sched_yield();
  TIMED(now_us() - begin);
  child();
  while (waitpid(-1, NULL, WNOHANG) == 0) continue;
  TIMED(now_us() - begin);
  if (pipe(ends) < 0) return;
  pthread_create(&t, NULL, reader, ends);
  usleep(1000);
  TIMED(pthread_kill(t, SIGALRM)); /* which has no SA_RESTART */
  TIMED((pthread_join(t, &got), (long)got));
  setpgid(0, 0);
  fflush(stdout);
  if (fork() == 0) _exit(usleep(50000) == -1 ? 0 : 1);
  usleep(1000);
  TIMED(kill(0, SIGALRM));
  TIMED(wait(NULL) > 0);
  pthread_mutexattr_init(&checks);
  pthread_mutexattr_settype(&checks, PTHREAD_MUTEX_ERRORCHECK);
  pthread_mutex_init(&mine, &checks);
  pthread_mutex_lock(&mine);
  TIMED(pthread_mutex_lock(&mine));
}

int main(void) {
  struct timeval tv;
  gettimeofday(&tv, NULL);
  printf("begin %ld %ld %ld\n", (long)time(NULL), (long)tv.tv_sec, (long)tv.tv_usec);
  fflush(stdout);
  sleeping();
  signals();
  threads();
  fflush(stdout);
  processes();
  fflush(stdout);
  sockets();
  kin();
  timers();
  asking();
  return 0;
}
