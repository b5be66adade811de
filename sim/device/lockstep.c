/* SPDX-License-Identifier: Apache-2.0 */
/* Lock-step (device.h): lines, waiting, signals, processes. */
#define _GNU_SOURCE
#include "device.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#define BIT(number) (UINT64_C(1) << ((number) - 1))
/* Whoever waits for them gets these whenever they come: they are the user's, not the machine's. */
#define OUTSIDE (BIT(SIGINT) | BIT(SIGQUIT) | BIT(SIGTERM) | BIT(SIGHUP) | BIT(SIGTSTP))
#define HIGH 100 /* descriptors that a program makes or closes by number are below, mostly */

static int enabled;                       /* until the server is gone */
static __thread int line = -1, wake = -1; /* a connection, and the eventfd of its answers */
static __thread struct wire_page *page;
static int bell = -1; /* the eventfd of all requests */
static uint64_t now_ns;
static uint32_t now_sample;
static unsigned long now_calls; /* wire_calls when now_ns was told */

/* Where a name has two versions, the oldest is found first. */
void lock_find(void **real, const char *name) {
  static const char *const versions[] = {"GLIBC_2.34", "GLIBC_2.30", "GLIBC_2.3.3", "GLIBC_2.3.2"};
  for (unsigned n = 0; *real == NULL && n < sizeof(versions) / sizeof(versions[0]); n++)
    *real = dlvsym(RTLD_NEXT, name, versions[n]);
  if (*real == NULL) *real = dlsym(RTLD_NEXT, name);
}

int lock_on(void) {
  return enabled && line >= 0;
}

static void close_line(void) {
  if (line >= 0) (void)syscall(SYS_close, line), (void)syscall(SYS_close, wake);
  if (line >= 0) (void)munmap(page, sizeof(*page));
  line = -1;
}

static int request(uint32_t op, uint64_t a, uint64_t b) {
  static const uint64_t one = 1;
  page->request = (struct wire_request){.op = op, .a = a, .b = b};
  __atomic_store_n(&page->asked, page->asked + 1, __ATOMIC_RELEASE);
  return syscall(SYS_write, bell, &one, sizeof(one)) < 0 ? -1 : 0;
}

/* Its result; -EINTR when a handler of `mask`, that of a wait, has run: a wait can be cancelled,
 * too. -EIO when the server is gone: then nothing here is in lock-step any more. */
static int answer(const sigset_t *mask) {
  struct pollfd ends[] = {{wake, POLLIN, 0}, {line, POLLIN, 0}};
  uint64_t times;
  while (__atomic_load_n(&page->answered, __ATOMIC_ACQUIRE) != page->asked) {
    const long n = mask != NULL ? REAL(ppoll)(ends, 2, NULL, mask)
                                : syscall(SYS_ppoll, ends, 2, NULL, NULL, 0);
    if (n < 0 && errno == EINTR) return -EINTR;
    if (!(ends[0].revents & POLLIN)) {
      enabled = 0;
      close_line();
      return -EIO;
    }
    (void)syscall(SYS_read, wake, &times, sizeof(times));
  }
  return page->result;
}

int lock_tell(uint32_t op, uint64_t a, uint64_t b) {
  sigset_t all, before;
  int result = -EIO, saved = errno;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  if (request(op, a, b) == 0) result = answer(NULL);
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  errno = saved;
  return result;
}

/* --- time ------------------------------------------------------------------------------ */

static void learn(void) {
  now_ns = page->now.ns;
  now_sample = page->now.sample;
  now_calls = wire_calls;
  lock_timers(now_ns);
}

uint64_t lock_now(void) {
  if (now_calls != wire_calls && lock_tell(WIRE_NOW, 0, 0) >= 0) learn();
  return now_ns;
}

uint64_t lock_after(uint64_t ns) {
  uint64_t now = lock_now();
  return ns < WIRE_NEVER - now ? now + ns : WIRE_NEVER - 1;
}

uint64_t lock_until(clockid_t clock, const struct timespec *at) {
  int64_t seconds = at->tv_sec - (clock == CLOCK_REALTIME ? (int64_t)EPOCH : 0);
  if (seconds < 0) return 0;
  if (seconds > INT32_MAX) return WIRE_NEVER - 1;
  return (uint64_t)seconds * SECOND + (uint64_t)at->tv_nsec;
}

/* --- waiting --------------------------------------------------------------------------- */

static uint64_t bits_of(const sigset_t *set) { /* the C library's first word */
  uint64_t bits;
  memcpy(&bits, set, sizeof(bits));
  return bits;
}

static uint64_t pending(void) {
  sigset_t set;
  sigpending(&set);
  return bits_of(&set);
}

/* Whether a handler of one of these signals ends a call. Not if it lets calls go on that
 * `restart`; and a process that a signal without a handler has stopped goes on in its call. */
static int is_heard(uint64_t signals, int restart) {
  for (int n = 1; n <= 64; n++) {
    struct sigaction action;
    if ((signals & BIT(n)) == 0 || sigaction(n, NULL, &action) != 0) continue;
    if (action.sa_handler == SIG_IGN || action.sa_handler == SIG_DFL) continue;
    if (!restart || !(action.sa_flags & SA_RESTART)) return 1;
  }
  return 0;
}

/* By a handler, or by a call that waits for it. */
static int takes_errors(uint64_t mask) {
  struct sigaction action = {.sa_handler = SIG_DFL};
  (void)sigaction(SIGUSR1, NULL, &action);
  return mask & BIT(SIGUSR1) || (action.sa_handler != SIG_DFL && action.sa_handler != SIG_IGN);
}

/* All but what comes from outside and `mask` lets through. */
static const sigset_t *only_outside(const sigset_t *mask) {
  static __thread sigset_t others;
  uint64_t bits;
  sigfillset(&others);
  bits = bits_of(&others) & (bits_of(mask) | ~OUTSIDE);
  memcpy(&others, &bits, sizeof(bits));
  return &others;
}

const sigset_t *lock_late(const sigset_t *before) {
  return lock_on() ? only_outside(before) : before;
}

static __thread unsigned polls; /* such calls since this thread has waited */

void lock_polls(void) {
  if (lock_on() && ++polls >= 100)
    (void)lock_wait(WAIT_DEAF, lock_now() + 100000, NULL, NULL, 0, NULL, 0);
}

/* The last answer to a read(), which may have come with a sample, and to a request. It holds until
 * a thread waits, or makes a call that may change something. */
static struct known {
  ino_t file;
  uint32_t request, asked, length;
  unsigned long others; /* wire_others then */
  char data[32 * 28];
} known[2];
static int has_read; /* since the last wait: states shall come with the next sample */

int lock_known(ino_t file, uint32_t request, void *data, uint32_t asked) {
  struct known *k = &known[request != 0];
  lock_polls();
  if (!lock_on()) return 0;
  has_read |= request == 0;
  if (k->file != file || k->request != request || k->asked != asked || k->others != wire_others)
    return 0;
  memcpy(data, k->data, k->length);
  return (int)k->length;
}

void lock_learn(ino_t file, uint32_t request, const void *data, uint32_t asked, int length) {
  struct known *k = &known[request != 0];
  if (!lock_on() || length < 0 || (size_t)length > sizeof(k->data)) return;
  k->file = file;
  k->request = request;
  k->asked = asked;
  k->length = (uint32_t)length;
  k->others = wire_others;
  memcpy(k->data, data, (size_t)length);
}

/* The last write(). With an answer: one like it may do without, and is carried out in front of what
 * this process asks next. */
static struct {
  ino_t file;
  char data[128]; /* of 32 axes */
  uint32_t length;
  int due;
  unsigned long others; /* wire_others then */
} last;
static int may_be_later;

/* A signal's handler that interrupts this finds may_be_later taken, and its write() is answered. */
int lock_write_later(ino_t file, const void *data, uint32_t length) {
  int may = may_be_later && lock_on() && last.others == wire_others && last.length == length &&
            last.file == file;
  may_be_later = 0;
  if (may) {
    memcpy(last.data, data, length);
    last.due = 1;
  } else {
    last.others = wire_others;
    last.length = length;
    last.file = file;
  }
  return may;
}

__attribute__((destructor)) void lock_write_first(void) {
  if (!last.due || !lock_on()) return;
  last.due = 0;
  (void)wire_call(WIRE_WRITE, last.file, 0, 0, last.data, last.length, NULL, NULL);
}

/* A timer that has run out meanwhile sends its signal. */
void lock_after_call(void) {
  if (lock_on() && lock_timers(now_ns) != WIRE_NEVER) (void)lock_now();
}

/* By a handler, or as the thread is cancelled, whose own handlers run when it is its turn. */
static void end_wait(void *result) {
  if (request(WIRE_CANCEL, 0, 0) == 0) *(int *)result = answer(NULL);
}

/* What comes from outside meanwhile is let through: `heard`, it came. Its handler may have waited,
 * which takes the place of this wait. */
static int wait_once(struct wire_wait *head, const int *files, const sigset_t *mask, int *heard) {
  static __thread unsigned waits;
  const unsigned number = ++waits;
  struct known *states = &known[0];
  int result, more = head->what == WAIT_SAMPLE && has_read && states->asked <= sizeof(states->data);
  known[0].length = known[1].length = 0;
  has_read = may_be_later = 0;
  if (head->until > now_ns) polls = 0;
  head->written = last.due ? last.length : 0;
  last.due = 0;
  memcpy(page->data, head, sizeof(*head));
  if (head->files > 0) memcpy(page->data + sizeof(*head), files, 4 * head->files);
  memcpy(page->data + sizeof(*head) + 4 * head->files, last.data, head->written);
  if (request(WIRE_WAIT, more ? states->asked : 0, 0) < 0) return -EIO;
  pthread_cleanup_push(end_wait, &result);
  result = answer(only_outside(mask));
  pthread_cleanup_pop(0);
  *heard = result == -EINTR;
  if (*heard && waits != number) return CAUSE_SIGNAL;
  if (*heard) end_wait(&result);
  if (result < 0) return result;
  learn();
  may_be_later = page->now.writes && last.length <= sizeof(last.data);
  lock_learn(states->file, 0, page->states, states->asked, (int)page->length);
  return result;
}

int lock_wait(unsigned what, uint64_t until, const void *key, const int *files, unsigned count,
              const sigset_t *mask, int keep) {
  struct wire_wait head = {.key = (uint64_t)(uintptr_t)key};
  const int restart = (what & LOCK_RESTARTS) != 0;
  const int timed = what & WAIT_SAMPLE ? CAUSE_WOKEN : CAUSE_DUE;
  sigset_t all, before, meanwhile;
  int cause, saved = errno;
  sigfillset(&all);
  (void)lock_timers(now_ns); /* one set to what has passed ends no wait that begins later */
  pthread_sigmask(SIG_SETMASK, &all, &before);
  meanwhile = mask != NULL ? *mask : before;
  head.what = what & ~LOCK_RESTARTS;
  head.mask = bits_of(&meanwhile);
  if (what & WAIT_FILES && until == WIRE_NEVER && takes_errors(head.mask)) head.what |= WAIT_ERROR;
  head.files = count < 64 ? count : 64;
  /* where nothing was blocked, nothing is pending */
  for (int blocked = bits_of(&before) != 0;; blocked = 1) {
    uint64_t come;
    int heard = 0;
    head.until = lock_timers(now_ns);
    if (until < head.until) head.until = until;
    head.pending = blocked ? pending() : 0;
    cause = (head.pending & ~head.mask) != 0 && !(what & WAIT_DEAF)
                ? CAUSE_SIGNAL
                : wait_once(&head, files, &meanwhile, &heard);
    if (cause == CAUSE_WOKEN && what & WAIT_FILES && restart && pending() & ~head.mask)
      cause = CAUSE_SIGNAL;
    /* which one has come from outside is not known */
    heard = heard && cause >= 0 && (!restart || is_heard(OUTSIDE & ~head.mask, restart));
    if (heard) cause = CAUSE_SIGNAL;
    if (cause == timed && head.until < until && now_ns >= head.until) { /* a timer's */
      if (!(what & (WAIT_FILES | WAIT_CHILD | WAIT_KEY))) continue;
      cause = (pending() & ~head.mask) != 0 ? CAUSE_SIGNAL : CAUSE_WOKEN;
    }
    if (cause != CAUSE_SIGNAL || keep) break;
    come = pending() & ~head.mask;
    pthread_sigmask(SIG_SETMASK, &meanwhile, NULL);
    pthread_sigmask(SIG_SETMASK, &all, NULL);
    if (heard || is_heard(come, restart)) break;
    if (what & (WAIT_FILES | WAIT_CHILD)) { /* what it waits for may have come as well */
      cause = CAUSE_WOKEN;
      break;
    }
  }
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  errno = saved;
  return cause < 0 ? CAUSE_OUTSIDE : cause;
}

int lock_sample(void *number) {
  int cause = lock_wait(WAIT_SAMPLE | LOCK_RESTARTS, WIRE_NEVER, NULL, NULL, 0, NULL, 0);
  if (cause == CAUSE_SIGNAL) return -EINTR;
  if (cause == CAUSE_LATE) return -EIO;
  return device_copy(number, &now_sample, sizeof(now_sample));
}

/* --- lines ----------------------------------------------------------------------------- */

/* What comes with a line: 0, or -1. */
static int take_page(void) {
  int ends[3];
  _Alignas(struct cmsghdr) char control[CMSG_SPACE(sizeof(ends))];
  char byte;
  struct iovec one = {&byte, 1};
  struct msghdr message = {
      .msg_iov = &one, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof(control)};
  ssize_t n;
  do n = syscall(SYS_recvmsg, line, &message, MSG_CMSG_CLOEXEC);
  while (n < 0 && (errno == EAGAIN || errno == EINTR));
  if (n != 1 || message.msg_controllen < CMSG_LEN(sizeof(ends))) return -1;
  memcpy(ends, CMSG_DATA(CMSG_FIRSTHDR(&message)), sizeof(ends));
  page = mmap(NULL, sizeof(*page), PROT_READ | PROT_WRITE, MAP_SHARED, ends[0], 0);
  if (bell < 0) bell = fcntl(ends[2], F_DUPFD_CLOEXEC, HIGH);
  wake = fcntl(ends[1], F_DUPFD_CLOEXEC, HIGH);
  for (unsigned n = 0; n < 3; n++) (void)syscall(SYS_close, ends[n]);
  return page == MAP_FAILED || bell < 0 || wake < 0 ? -1 : 0;
}

void lock_begin_thread(unsigned number) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  line = wire_connect(1);
  enabled = enabled && line >= 0 &&
            wire_ask(line, WIRE_LINE, 0, number, (uint64_t)pthread_self(), NULL, 0) == 0 &&
            take_page() == 0 && answer(NULL) >= 0;
  if (enabled) learn();
  pthread_sigmask(SIG_SETMASK, &before, NULL);
}

/* Whoever joins this thread may go on: the server sees the line's end. */
void lock_end_thread(void) {
  if (!lock_on()) return;
  lock_write_first();
  (void)request(WIRE_LINE, 0, 0);
  close_line();
}

static void child_of_fork(void) {
  close_line(); /* the parent's */
  lock_forget_timers();
  known[0].length = known[1].length = 0;
  last.due = 0;
  if (enabled) lock_begin_thread(0);
}

__attribute__((constructor(102))) static void attach(void) {
  if (getenv("MMCS_LOCKSTEP") == NULL) return;
  enabled = 1;
  (void)pthread_atfork(NULL, NULL, child_of_fork);
  lock_begin_thread(0);
  lock_take_pipes();
}
