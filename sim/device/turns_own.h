/* SPDX-License-Identifier: Apache-2.0 */
/* What turns.c and lines.c have in common. */
#ifndef MMCS_TURNS_OWN_H
#define MMCS_TURNS_OWN_H

#include "mmcs_sim.h"
/* first mmcs_sim.h */
#include "mmcs_service.h"
#include "turns.h"
#include "wire.h"

#define BIT(number) (UINT64_C(1) << ((number) - 1))

/* A thread. It runs, waits, or is ready to go on, because of `cause`. */
struct line {
  struct line *next; /* of the process, by number */
  struct process *process;
  int fd, wake;
  uint32_t heard; /* requests */
  struct wire_page *page;
  enum { RUNS, WAITS, READY } state;
  enum wire_cause cause;
  int64_t number;
  uint64_t key;
  struct wire_wait wait;
  uint64_t states;  /* bytes of states that it would read next */
  int64_t patience; /* the clock until which it waits for a sample */
  int outside;      /* no attached process has the other ends of those */
};

struct process {
  struct process *next; /* in the order of their starts */
  int pid, handle;
  int64_t number;
  enum { STARTING, THERE, ENDED } state; /* STARTING: has no line yet, and will */
  int expected;                          /* threads of it of which the same holds */
  struct line *lines;
  /* Of the last read() and write(); events there were if it took no time and had no error, or -1 */
  mmcs_client *reads, *writes;
  int64_t quiet, wrote;
};

#define EACH_PROCESS(t, p) for (struct process *p = (t)->processes; p != NULL; p = p->next)
#define EACH_LINE(t, p, l) \
  EACH_PROCESS(t, p) for (struct line *l = p->lines; l != NULL; l = l->next)

/* turns.c */
int64_t clock_of(const struct turns *t);
uint64_t now_of(const struct turns *t);
struct process *process_of(const struct turns *t, int pid);
void leave_line(struct turns *t, struct line *l, int says_so);
void begin_wait(struct turns *t, struct line *l, const struct wire_wait *wait,
                const int32_t *files);
void ready(struct line *l, enum wire_cause cause);
int wants(const struct line *l, unsigned what);
int hears(const struct line *l, uint64_t signals);

/* lines.c */
int64_t events_of(const struct turns *t);
void see_signals(struct turns *t);
void go_on(struct turns *t, struct line *l, enum wire_cause cause);

#endif
