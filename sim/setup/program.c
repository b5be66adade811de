// SPDX-License-Identifier: Apache-2.0
// A program with one thread that holds its own machine: linked in place of libc's calls, by `mmcs
// compile --cflags --libs`. Time is the machine's and passes in calls that wait, as in lock-step
// (docs/use/device.md). A debugger sees program, driver and servo in one process.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "mcdef.h"
#include "mmcs_service.h"
#include "mmcs_sim.h"
#include "sys/mmcs.h"

extern const char mmcs_setup_file[];  // program.h, in the program

enum { FILES = 1024, EPOCH = 599616000, SECOND = 1000000000 };  // machine time 0: 1 January 1989
static mmcs_sim *sim;
static int client[FILES];  // 1 + the driver's number, by descriptor
static int64_t hz;
static bool making;  // the engine may start threads of its own

_Noreturn static void die(const char *why) {
  fprintf(stderr, "mmcs: %s\n", why);
  exit(2);
}

#define NEEDS_SERVER(what) \
  die("a program " what " needs `mmcs exec`: this one is linked with its machine")

static void start(void) {
  char err[300] = "";
  size_t size = 0;
  if (sim) return;
  void *setup = mmcs_setup_load(mmcs_setup_file, &size, err, sizeof err);
  making = true;
  if (setup) sim = mmcs_sim_create_from(setup, size, NULL, err, sizeof err);
  making = false;
  if (!sim) die(err);
  free(setup);
  hz = mmcs_sim_build_clk_hz();
}

// Delivers SIGUSR1; whether a call that waits ends by one.
static int deliver(void) {
  int due = 0;
  sigset_t blocked;
  for (int fd = 0; sim && fd < FILES; fd++)
    if (client[fd] && mmcs_sim_signals(sim, client[fd] - 1) > 0) due = 1;
  if (!due || raise(SIGUSR1) != 0 || sigprocmask(SIG_BLOCK, NULL, &blocked) != 0) return 0;
  return !sigismember(&blocked, SIGUSR1);
}

static int answer(int result) {
  deliver();
  if (result >= 0) return result;
  errno = -result;
  return -1;
}

// Lets at least so much time pass; -1 and EINTR after a signal.
static int pass(int64_t ns) {
  start();
  const int64_t end = mmcs_sim_clock(sim) + (int64_t)(((__int128)ns * hz + SECOND - 1) / SECOND);
  while (mmcs_sim_clock(sim) < end) {
    if (mmcs_sim_run_to(sim, end, 0) != 0) die("an assertion of the machine has failed");
    if (deliver()) {
      errno = EINTR;
      return -1;
    }
  }
  return 0;
}

static bool is_machine(int fd) {
  return fd >= 0 && fd < FILES && client[fd];
}

int open(const char *path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const int mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(list, int) : 0;
  va_end(list);
  if (strcmp(path, "/dev/vme16") == 0) die("/dev/vme16 needs `mmcs exec`");
  if (strcmp(path, "/dev/mc0") != 0) return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
  start();
  const int number = mmcs_sim_open(sim, flags & O_ACCMODE);
  if (number < 0) return answer(number);
  const int fd = eventfd(1, flags & O_CLOEXEC ? EFD_CLOEXEC : 0);
  if (fd < 0 || fd >= FILES) die("too many open files");
  client[fd] = number + 1;
  return fd;
}

int close(int fd) {
  if (is_machine(fd)) {
    mmcs_sim_close(sim, client[fd] - 1);
    client[fd] = 0;
  }
  return (int)syscall(SYS_close, fd);
}

// MWAIT: until the next servo sample.
static int wait_sample(int *samples) {
  const int64_t before = mmcs_sim_samples(sim), end = mmcs_sim_clock(sim) + hz * 5 / 2;
  while (mmcs_sim_samples(sim) == before && mmcs_sim_clock(sim) < end)
    if (mmcs_sim_run_to(sim, end, 1) != 0) die("an assertion of the machine has failed");
  if (mmcs_sim_samples(sim) == before) return -EIO;
  if (!samples) return -EFAULT;
  *samples = (int)mmcs_sim_samples(sim);
  return 0;
}

int ioctl(int fd, unsigned long request, ...) {
  va_list list;
  va_start(list, request);
  void *argument = va_arg(list, void *);
  va_end(list);
  if (!is_machine(fd)) return (int)syscall(SYS_ioctl, fd, request, argument);
  if ((uint32_t)request == (uint32_t)MWAIT) return answer(wait_sample(argument));
  return answer(mmcs_sim_ioctl(sim, client[fd] - 1, (uint32_t)request, argument));
}

ssize_t read(int fd, void *data, size_t size) {
  if (!is_machine(fd)) return syscall(SYS_read, fd, data, size);
  return answer(mmcs_sim_read(sim, client[fd] - 1, data, size));
}
ssize_t write(int fd, const void *data, size_t size) {
  if (!is_machine(fd)) return syscall(SYS_write, fd, data, size);
  return answer(mmcs_sim_write(sim, client[fd] - 1, data, size));
}

int nanosleep(const struct timespec *time, struct timespec *left) {
  (void)left;
  return pass(time->tv_sec * (int64_t)SECOND + time->tv_nsec);
}
int usleep(useconds_t us) {
  return pass(us * INT64_C(1000));
}
unsigned sleep(unsigned seconds) {
  return pass(seconds * (int64_t)SECOND) == 0 ? 0 : 1;
}
int pause(void) {
  while (pass(SECOND) == 0) {
  }
  return -1;
}
int sigsuspend(const sigset_t *mask) {
  sigset_t before, waiting;
  sigpending(&waiting);
  sigprocmask(SIG_SETMASK, mask, &before);  // SIGUSR1 that has come runs its handler
  if (!sigismember(&waiting, SIGUSR1) || sigismember(mask, SIGUSR1)) pause();
  sigprocmask(SIG_SETMASK, &before, NULL);
  errno = EINTR;
  return -1;
}
int poll(struct pollfd *files, nfds_t count, int ms) {
  if (count) return (int)syscall(SYS_poll, files, count, ms);
  return pass(ms * INT64_C(1000000));
}

int clock_gettime(clockid_t clock, struct timespec *time) {
  if (!sim) return (int)syscall(SYS_clock_gettime, clock, time);
  const int64_t ns = (int64_t)((__int128)mmcs_sim_clock(sim) * SECOND / hz);
  time->tv_sec = ns / SECOND + (clock == CLOCK_REALTIME ? EPOCH : 0);
  time->tv_nsec = ns % SECOND;
  return 0;
}
int gettimeofday(struct timeval *restrict time, void *restrict zone) {
  (void)zone;
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  *time = (struct timeval){now.tv_sec, now.tv_nsec / 1000};
  return 0;
}

pid_t fork(void) {
  NEEDS_SERVER("of several processes");
}
int setitimer(__itimer_which_t which, const struct itimerval *restrict every,
              struct itimerval *restrict before) {
  (void)which, (void)every, (void)before;
  NEEDS_SERVER("with timers");  // whose signals would come by the computer's time
}
int pthread_create(pthread_t *thread, const pthread_attr_t *how, void *(*run)(void *), void *with) {
  __typeof__(&pthread_create) real = dlsym(RTLD_NEXT, "pthread_create");
  if (making) return real(thread, how, run, with);
  NEEDS_SERVER("with threads");
}
