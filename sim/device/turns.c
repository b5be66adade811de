/* SPDX-License-Identifier: Apache-2.0 */
/* Whose turn it is, and what ends a wait (turns.h). lines.c has the requests of the lines. */
#define _GNU_SOURCE
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "turns_own.h"

#define SECOND 1000000000
#define STRETCH_S 0.01  /* of time between looks at the stop path */
#define LOOK_S 0.001    /* of time between looks at descriptors from outside */
#define NO_SAMPLE_S 2.5 /* of the machine: with an interval over 1 s MENABLE fails */

int64_t clock_of(const struct turns *t) {
  return mmcs_sim_clock(t->sim);
}

uint64_t now_of(const struct turns *t) {
  return (uint64_t)((__int128)clock_of(t) * SECOND / t->hz);
}

static double wall(void) {
  struct timespec now;
  (void)clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int wants(const struct line *l, unsigned what) {
  return l->state == WAITS && (l->wait.what & what) != 0;
}

void ready(struct line *l, enum wire_cause cause) {
  l->state = READY;
  l->cause = cause;
}

static void begin(struct turns *t) {
  t->began = wall();
  t->clock = clock_of(t);
  t->told = 0;
}

/* --- who there is ---------------------------------------------------------------------- */

struct turns *turns_create(mmcs_sim *sim, mmcs_server *server, int epoll) {
  struct turns *t = calloc(1, sizeof(*t));
  struct epoll_event in = {.events = EPOLLIN | EPOLLET, .data.fd = eventfd(0, EFD_CLOEXEC)};
  if (t == NULL || epoll_ctl(epoll, EPOLL_CTL_ADD, in.data.fd, &in) < 0) abort();
  *t = (struct turns){.limit = INT64_MAX, .silent_s = 5, .outside_s = 1, .good = 1, .sim = sim};
  t->server = server;
  t->epoll = epoll;
  t->bell = in.data.fd;
  t->hz = mmcs_sim_build_clk_hz();
  t->last_process = t->last_line = -1;
  return t;
}

struct process *process_of(const struct turns *t, int pid) {
  EACH_PROCESS(t, p) if (p->pid == pid) return p;
  return NULL;
}

void turns_expect(struct turns *t, int pid) {
  struct process *p = process_of(t, pid), **last = &t->processes;
  struct epoll_event in = {.events = EPOLLIN};
  if (p != NULL) return;
  p = calloc(1, sizeof(*p));
  if (p == NULL) abort();
  while (*last != NULL) last = &(*last)->next;
  *last = p;
  p->pid = pid;
  p->number = ++t->numbers;
  p->quiet = p->wrote = -1;
  p->handle = in.data.fd = (int)syscall(SYS_pidfd_open, pid, 0);
  p->state = p->handle < 0 ? ENDED : STARTING;
  if (p->handle >= 0) (void)epoll_ctl(t->epoll, EPOLL_CTL_ADD, p->handle, &in);
  begin(t);
}

int turns_pids(const struct turns *t, int32_t *pids, int most) {
  int n = 0;
  EACH_PROCESS(t, p) if (n < most) pids[n++] = p->pid;
  return n;
}

/* A wait for the end of a thread ends when the thread is neither there nor on its way. */
static void join(struct process *p) {
  for (struct line *l = p->expected == 0 ? p->lines : NULL; l != NULL; l = l->next) {
    const struct line *other = p->lines;
    while (other != NULL && other->key != l->wait.key) other = other->next;
    if (wants(l, WAIT_THREAD) && other == NULL) ready(l, CAUSE_WOKEN);
  }
}

/* Descriptors may be ready: it looks at them. */
static void look(struct line *l) {
  if (wants(l, WAIT_FILES)) ready(l, CAUSE_WOKEN);
}

static void others_ran(struct turns *t, const struct line *but) {
  EACH_LINE(t, p, l) if (l != but) look(l);
}

static void drop(struct turns *t, struct process *p, struct line *l) {
  struct line **at = &p->lines;
  while (*at != l) at = &(*at)->next;
  *at = l->next;
  (void)close(l->fd);
  (void)close(l->wake);
  (void)munmap(l->page, sizeof(*l->page));
  t->lines--;
  if (t->running == l) {
    t->running = NULL;
    others_ran(t, NULL);
  }
  free(l);
  join(p);
}

/* A thread says that it ends. A line that ends unsaid: all of the program does. */
void leave_line(struct turns *t, struct line *l, int says_so) {
  struct process *p = l->process;
  if (says_so) drop(t, p, l);
  while (!says_so && p->lines != NULL) drop(t, p, p->lines);
  if (p->lines == NULL && p->state == THERE) p->state = STARTING; /* another program, or its end */
}

void turns_line(struct turns *t, int fd, int page, int wake, const void *request) {
  struct wire_request r;
  struct process *p;
  struct line *l = calloc(1, sizeof(*l)), **at;
  if (l == NULL) abort();
  memcpy(&r, request, sizeof(r));
  turns_expect(t, r.pid);
  p = process_of(t, r.pid);
  if (r.a > 0) {
    p->expected--;
  } else {
    while (p->lines != NULL) drop(t, p, p->lines); /* of the program that it was before */
    p->expected = 0;
  }
  if (p->state == STARTING) p->state = THERE; /* also if main() has ended before a thread began */
  *l = (struct line){.process = p, .fd = fd, .wake = wake, .number = (int64_t)r.a};
  l->page = mmap(NULL, sizeof(*l->page), PROT_READ | PROT_WRITE, MAP_SHARED, page, 0);
  if (l->page == MAP_FAILED) abort();
  l->heard = 1;
  l->key = r.b;
  l->wait.until = WIRE_NEVER;
  ready(l, CAUSE_DUE);
  for (at = &p->lines; *at != NULL && (*at)->number <= l->number;) at = &(*at)->next;
  l->next = *at;
  *at = l;
  t->lines++;
  join(p);
}

/* It does not run, and lets one of them through. */
int hears(const struct line *l, uint64_t signals) {
  return l->state != RUNS && !(l->wait.what & WAIT_DEAF) && (signals & ~l->wait.mask) != 0;
}

/* Signals are pending in a process: the first thread that lets one through wakes. */
void turns_signalled(struct turns *t, int pid, uint64_t signals) {
  const struct process *p = process_of(t, pid);
  struct line *first = NULL;
  for (struct line *l = p != NULL ? p->lines : NULL; l != NULL; l = l->next) {
    if (!hears(l, signals)) continue;
    if (l->state == READY) return;
    if (first == NULL) first = l;
  }
  if (first != NULL) ready(first, CAUSE_SIGNAL);
}

/* Processes that have ended, or all. */
static int forget(struct turns *t, int all) {
  int found = 0;
  for (struct process **at = &t->processes, *p; (p = *at) != NULL;) {
    if (!all && p->state != ENDED) {
      at = &p->next;
      continue;
    }
    *at = p->next;
    while (p->lines != NULL) drop(t, p, p->lines);
    if (p->handle >= 0) (void)close(p->handle);
    free(p);
    found = 1;
  }
  return found;
}

void turns_destroy(struct turns *t) {
  (void)forget(t, 1);
  (void)close(t->bell);
  free(t);
}

static void reap(struct turns *t) {
  if (!forget(t, 0)) return;
  others_ran(t, NULL);
  EACH_LINE(t, p, l) if (wants(l, WAIT_CHILD)) ready(l, CAUSE_WOKEN);
  EACH_PROCESS(t, p) turns_signalled(t, p->pid, BIT(SIGCHLD));
}

/* --- what a line asks ------------------------------------------------------------------ */

/* It runs no more, until it is ready. */
void begin_wait(struct turns *t, struct line *l, const struct wire_wait *wait,
                const int32_t *files) {
  struct process *p = l->process;
  l->wait = *wait;
  l->state = WAITS;
  l->patience = clock_of(t) + (int64_t)(NO_SAMPLE_S * (double)t->hz);
  if (t->running == l) t->running = NULL;
  if (!(wait->what & WAIT_AGAIN)) others_ran(t, l);
  if (wait->pending) turns_signalled(t, p->pid, wait->pending);
  join(p);
  if (wait->what & WAIT_CHILD && t->processes->next == NULL) {
    ready(l, CAUSE_OUTSIDE);
    l->outside = 1;
  }
  if (!(wait->what & WAIT_FILES)) return;
  l->outside = wait->files > 0;
  for (uint32_t n = 0; n < wait->files && l->outside; n++)
    l->outside = t->is_outside(p->pid, files[n]);
  if (l->outside && wait->until == WIRE_NEVER) ready(l, CAUSE_OUTSIDE);
  if (wait->what & WAIT_ERROR) l->outside = 1; /* some of them may be */
}

/* --- whose turn it is ------------------------------------------------------------------ */

static const struct process *awaited(const struct turns *t) {
  EACH_PROCESS(t, p) if (p->state == STARTING || p->expected > 0) return p;
  return NULL;
}

int turns_busy(const struct turns *t) {
  return t->running != NULL || awaited(t) != NULL;
}

int turns_rest(const struct turns *t) {
  EACH_PROCESS(t, p) if (p->state == ENDED) return 0;
  return turns_busy(t) || t->processes == NULL;
}

static void tell(struct turns *t, const struct process *p, enum turns_why why) {
  if (why == TURNS_SILENT && t->clock != clock_of(t)) begin(t); /* its accesses take time */
  if (t->told || wall() - t->began < (why == TURNS_SILENT ? t->silent_s : t->outside_s)) return;
  t->told = 1;
  t->tell(p != NULL ? p->pid : 0, (int)why);
}

/* The next line that may go on, behind the one that ran last. */
static struct line *next_line(const struct turns *t) {
  struct line *first = NULL;
  EACH_LINE(t, p, l) {
    if (l->state != READY) continue;
    if (p->number > t->last_process || (p->number == t->last_process && l->number > t->last_line))
      return l;
    if (first == NULL) first = l;
  }
  return first;
}

static void release(struct turns *t, struct line *l) {
  l->state = RUNS;
  l->outside = l->cause == CAUSE_OUTSIDE;
  t->running = l;
  t->last_process = l->process->number;
  t->last_line = l->number;
  begin(t);
  go_on(t, l, l->cause);
}

void turns_passed(struct turns *t, int sampled) {
  const int64_t clock = clock_of(t);
  const uint64_t now = now_of(t);
  EACH_LINE(t, p, l) {
    const unsigned what = l->wait.what;
    if (l->state == WAITS && l->wait.until <= now)
      ready(l, what & WAIT_SAMPLE ? CAUSE_WOKEN : CAUSE_DUE);
    /* a signal or timer that came with the sample takes it not away */
    if (sampled && what & WAIT_SAMPLE && l->state != RUNS) ready(l, CAUSE_DUE);
    if (wants(l, WAIT_SAMPLE) && clock > l->patience) ready(l, CAUSE_LATE);
    if (l->outside) look(l);
  }
}

/* All that any thread waits for is another one. */
static const struct process *deadlocked(const struct turns *t) {
  const struct process *found = NULL;
  EACH_LINE(t, p, l) {
    if (!wants(l, WAIT_KEY | WAIT_THREAD | WAIT_CHILD) || l->wait.until != WIRE_NEVER) return NULL;
    if (l->wait.what & (WAIT_KEY | WAIT_THREAD)) found = p;
  }
  return found;
}

/* While every line waits: up to the first end of a wait, or a stretch. */
static void pass_time(struct turns *t) {
  const int64_t clock = clock_of(t), before = mmcs_sim_samples(t->sim);
  const struct process *stuck = deadlocked(t);
  int samples = 0, others = 0, outside = 0;
  struct line *files = NULL;
  uint64_t end = WIRE_NEVER;
  int64_t to;
  EACH_LINE(t, p, l) {
    const int of_files = (l->wait.what & WAIT_FILES) != 0;
    if (l->wait.until < end) end = l->wait.until;
    samples |= (l->wait.what & WAIT_SAMPLE) != 0;
    others |= !(l->wait.what & (WAIT_FILES | WAIT_KEY | WAIT_THREAD | WAIT_CHILD)) ||
              l->wait.what & WAIT_ERROR;
    outside |= of_files && l->outside;
    if (of_files && files == NULL) files = l;
  }
  if (files != NULL && end == WIRE_NEVER && !samples && !others) {
    ready(files, CAUSE_OUTSIDE); /* only the outside world can go on */
    return;
  }
  if (stuck != NULL) tell(t, stuck, TURNS_EACH_OTHER);
  to = clock + (int64_t)((outside ? LOOK_S : STRETCH_S) * (double)t->hz);
  if (end != WIRE_NEVER) {
    const __int128 due = ((__int128)end * t->hz + SECOND - 1) / SECOND;
    if (due < to) to = (int64_t)due;
  }
  if (to > t->limit) to = t->limit;
  if (to > clock && mmcs_sim_run_to(t->sim, to, samples) != 0) t->good = 0;
  see_signals(t);
  turns_passed(t, mmcs_sim_samples(t->sim) != before);
}

static void turn(struct turns *t) {
  const int64_t events = events_of(t);
  struct line *next;
  reap(t);
  if (turns_busy(t) || t->processes == NULL) return;
  next = next_line(t);
  if (next == NULL) pass_time(t);
  if (next == NULL && events_of(t) == events) next = next_line(t);
  if (next != NULL) release(t, next);
}

/* Nobody runs, and more has come than what was asked: whoever closes and then asks has closed. */
static int has_more(const struct turns *t) {
  struct epoll_event came;
  return !turns_busy(t) && epoll_wait(t->epoll, &came, 1, 0) > 0;
}

void turns_run(struct turns *t, int turns, int timeout_ms) {
  const int64_t events = events_of(t), requests = t->requests;
  (void)turns_hear(t, t->bell); /* an edge of it may have been taken beside another event */
  if (t->requests > requests && has_more(t)) return;
  for (; turns > 0; turns--) {
    struct epoll_event came[2];
    int n, busy;
    if (!turns_rest(t)) turn(t);
    if (events_of(t) != events) break;
    busy = turns_busy(t);
    n = epoll_wait(t->epoll, came, 2, busy ? timeout_ms : 0);
    if (n == 0 && !busy && t->processes != NULL) continue;
    if (n == 0 && busy && t->running == NULL) tell(t, awaited(t), TURNS_SILENT);
    if (t->running != NULL) /* or it asks, and does not wait */
      tell(t, t->running->process, n == 0 && t->running->outside ? TURNS_OUTSIDE : TURNS_SILENT);
    if (n != 1 || !turns_hear(t, came[0].data.fd) || has_more(t)) break;
  }
}
