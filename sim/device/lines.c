/* SPDX-License-Identifier: Apache-2.0 */
/* Lock-step: what comes on a line and what goes there; a program's read() and write() (turns.h). */
#define _GNU_SOURCE
#include <errno.h>
#include <signal.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "mcdef.h"
#include "turns_own.h"

int64_t events_of(const struct turns *t) {
  mmcs_tap_head head;
  (void)mmcs_sim_tap_head(t->sim, &head);
  return head.events;
}

/* Each signal of the driver is an event as well. */
void see_signals(struct turns *t) {
  const int64_t events = events_of(t);
  if (events == t->events) return;
  t->events = events;
  (void)t->send_signals();
}

/* --- read() and write() ---------------------------------------------------------------- */

int turns_read(struct turns *t, int pid, mmcs_client *client, void *states, size_t size) {
  struct process *p = process_of(t, pid);
  const int64_t before = clock_of(t);
  const int result = mmcs_sim_read(t->sim, client->driver, states, size);
  const struct mc_state *state = states;
  int errors = result < 0 || clock_of(t) != before;
  for (int n = 0; n < result / (int)sizeof(*state); n++) errors |= state[n].errcode;
  if (p != NULL) {
    p->reads = client;
    p->quiet = errors ? -1 : events_of(t);
  }
  return result;
}

int turns_write(struct turns *t, int pid, mmcs_client *client, const void *data, size_t size) {
  struct process *p = process_of(t, pid);
  const int64_t before = clock_of(t);
  const int result = mmcs_server_write(t->server, client, data, size);
  see_signals(t);
  if (p != NULL) {
    p->writes = client;
    p->wrote = result != (int)size || clock_of(t) != before ? -1 : events_of(t);
  }
  return result;
}

void turns_closes(struct turns *t, const mmcs_client *client) {
  EACH_PROCESS(t, p) {
    if (p->reads == client) p->reads = NULL;
    if (p->writes == client) p->writes = NULL;
  }
}

/* --- answers --------------------------------------------------------------------------- */

static void reply(const struct turns *t, struct line *l, int result, int length) {
  l->page->result = result;
  l->page->length = length > 0 ? (uint32_t)length : 0;
  l->page->now = (struct wire_now){
      .ns = now_of(t),
      .sample = (uint32_t)mmcs_sim_samples(t->sim),
      .writes = l->process->writes != NULL && l->process->wrote == events_of(t),
  };
  __atomic_store_n(&l->page->answered, l->heard, __ATOMIC_RELEASE);
  (void)eventfd_write(l->wake, 1);
}

/* The line runs from now on: its wait is answered, or the call that waited is served. */
void go_on(struct turns *t, struct line *l, enum wire_cause cause) {
  const struct process *p = l->process;
  int read = 0;
  if (cause == CAUSE_DUE && l->states > 0 && l->states <= sizeof(l->page->states) &&
      p->reads != NULL && p->quiet == events_of(t))
    read = mmcs_sim_read(t->sim, p->reads->driver, l->page->states, (size_t)l->states);
  reply(t, l, (int)cause, read);
}

/* --- requests -------------------------------------------------------------------------- */

static int wake(struct line *l, uint64_t key, uint64_t count) {
  int woken = 0;
  for (l = l->process->lines; l != NULL && (uint64_t)woken < count; l = l->next)
    if (wants(l, WAIT_KEY) && l->wait.key == key) ready(l, CAUSE_WOKEN), woken++;
  return woken;
}

static void poke(struct turns *t, const struct process *from, uint64_t to, uint64_t signal) {
  const uint64_t number = signal & ~(uint64_t)WIRE_THREAD;
  const int pid = (int)to, group = pid == 0 ? getpgid(from->pid) : -pid;
  if (number < 1 || number > 64) return;
  if (signal & WIRE_THREAD) {
    for (struct line *l = from->lines; l != NULL; l = l->next)
      if (l->key == to && l->state == WAITS && hears(l, BIT(number))) ready(l, CAUSE_SIGNAL);
    return;
  }
  EACH_PROCESS(t, p)
  if (p->pid == pid || pid == -1 || (pid <= 0 && getpgid(p->pid) == group))
    turns_signalled(t, p->pid, BIT(number));
}

static void serve(struct turns *t, struct line *l, const struct wire_request *r, const char *data) {
  struct process *p = l->process;
  int result = 0;
  struct wire_wait wait;
  t->requests++;
  switch (r->op) {
    case WIRE_LINE:
      leave_line(t, l, 1);
      return;
    case WIRE_WAIT:
      memcpy(&wait, data, sizeof(wait));
      result = -EINVAL;
      if (wait.files > 64 || wait.written > 128) break;
      l->states = r->a;
      data += sizeof(wait);
      if (wait.written > 0 && p->writes != NULL)
        (void)turns_write(t, p->pid, p->writes, data + 4 * wait.files, wait.written);
      begin_wait(t, l, &wait, (const int32_t *)(const void *)data);
      return;
    case WIRE_CANCEL:
      if (l->state == WAITS) ready(l, CAUSE_SIGNAL);
      if (l->state == RUNS) go_on(t, l, l->cause); /* as before */
      return;
    case WIRE_NOW:
      break;
    case WIRE_WAKE:
      result = wake(l, r->a, r->b);
      break;
    case WIRE_POKE:
      poke(t, l->process, r->a, r->b);
      break;
    default: /* WIRE_SPAWN */
      if (r->a == 0) p->expected += r->b ? -1 : 1;
      if (r->a != 0) turns_expect(t, (int)r->a);
  }
  reply(t, l, result, 0);
}

/* A request that has come on any line: 1, and it has been served. */
static int hear(struct turns *t) {
  EACH_LINE(t, p, l) {
    const uint32_t asked = __atomic_load_n(&l->page->asked, __ATOMIC_ACQUIRE);
    struct wire_request r;
    _Alignas(uint64_t) char data[sizeof(l->page->data)];
    if (asked == l->heard) continue;
    r = l->page->request;
    memcpy(data, l->page->data, sizeof(data));
    l->heard = asked;
    serve(t, l, &r, data);
    return 1;
  }
  return 0;
}

/* What comes on a line's connection is its end; what its thread has asked before counts. */
int turns_hear(struct turns *t, int fd) {
  for (int n = t->lines; n > 0 && hear(t); n--) continue;
  if (fd == t->bell) return 1;
  EACH_LINE(t, p, l) if (l->fd == fd) return leave_line(t, l, 0), 1;
  EACH_PROCESS(t, p) {
    if (p->handle != fd) continue;
    (void)epoll_ctl(t->epoll, EPOLL_CTL_DEL, fd, NULL);
    (void)close(fd);
    p->handle = -1;
    p->state = ENDED;
    return 1;
  }
  return 0;
}
