/* SPDX-License-Identifier: Apache-2.0 */
/* Lock-step: what comes on a line and what goes there; a program's read() and write() (turns.h). */
#define _GNU_SOURCE
#include <errno.h>
#include <signal.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
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

static void reply(int fd, int result, const void *data, uint32_t length) {
  struct {
    struct wire_reply head;
    char data[sizeof(struct wire_now) + MOST_READ];
  } out = {.head = {result, length}};
  const ssize_t size = (ssize_t)(sizeof(out.head) + length);
  if (length > 0) memcpy(out.data, data, length);
  /* a program that fetches no answers is disconnected; the end of one is heard by epoll */
  if (send(fd, &out, (size_t)size, MSG_NOSIGNAL | MSG_DONTWAIT) != size)
    (void)shutdown(fd, SHUT_RDWR);
}

static struct wire_now now(const struct turns *t, const struct process *of) {
  return (struct wire_now){
      .ns = now_of(t),
      .sample = (uint32_t)mmcs_sim_samples(t->sim),
      .writes = of->writes != NULL && of->wrote == events_of(t),
  };
}

/* The line runs from now on: its wait is answered, or the call that waited is served. */
void go_on(struct turns *t, struct line *l, enum wire_cause cause) {
  struct {
    struct wire_now now;
    char states[MOST_READ];
  } told = {.now = now(t, l->process)};
  const struct process *p = l->process;
  int read = 0;
  if (cause == CAUSE_DUE && l->states > 0 && l->states <= sizeof(told.states) && p->reads != NULL &&
      p->quiet == events_of(t))
    read = mmcs_sim_read(t->sim, p->reads->driver, told.states, (size_t)l->states);
  reply(l->fd, (int)cause, &told, (uint32_t)(sizeof(told.now) + (size_t)(read > 0 ? read : 0)));
}

/* --- requests -------------------------------------------------------------------------- */

static int wake(struct line *l, uint64_t key, uint64_t count) {
  int woken = 0;
  for (l = l->process->lines; l != NULL && (uint64_t)woken < count; l = l->next) {
    if (!wants(l, WAIT_KEY) || l->wait.key != key) continue;
    ready(l, CAUSE_WOKEN);
    woken++;
  }
  return woken;
}

static int is_well_formed(const struct wire_request *r, const void *data) {
  struct wire_wait wait;
  if (r->op == WIRE_LATER) return 1;
  if (r->op != WIRE_WAIT) return r->length == 0 && r->op >= WIRE_LINE && r->op <= WIRE_CANCEL;
  if (r->length < sizeof(wait)) return 0;
  memcpy(&wait, data, sizeof(wait));
  return wait.files < MOST_ASKED && wait.written < MOST_ASKED &&
         r->length == sizeof(wait) + 4 * wait.files + wait.written;
}

static void serve(struct turns *t, struct line *l, const struct wire_request *r, const char *data) {
  struct process *p = l->process;
  int result = 0;
  struct wire_wait wait;
  struct wire_now moment;
  t->requests++;
  if (!is_well_formed(r, data)) {
    reply(l->fd, -EINVAL, NULL, 0);
    return;
  }
  switch (r->op) {
    case WIRE_LINE:
      leave_line(t, l, 1);
      return;
    case WIRE_WAIT:
      memcpy(&wait, data, sizeof(wait));
      l->states = r->a;
      if (wait.written > 0 && p->writes != NULL)
        (void)turns_write(t, p->pid, p->writes, data + r->length - wait.written, wait.written);
      begin_wait(t, l, &wait, (const int32_t *)(const void *)(data + sizeof(wait)));
      return;
    case WIRE_CANCEL:
      if (l->state == WAITS) ready(l, CAUSE_SIGNAL);
      return;
    case WIRE_NOW:
      moment = now(t, p);
      reply(l->fd, 0, &moment, sizeof(moment));
      return;
    case WIRE_LATER:
      if (p->writes != NULL) result = turns_write(t, p->pid, p->writes, data, r->length);
      break;
    case WIRE_WAKE:
      result = wake(l, r->a, r->b);
      break;
    case WIRE_POKE:
      if (r->b > 0 && r->b <= 64) turns_signalled(t, (int)r->a, BIT(r->b));
      break;
    default: /* WIRE_SPAWN */
      if (r->a == 0) p->expected += r->b ? -1 : 1;
      if (r->a != 0) turns_expect(t, (int)r->a);
  }
  reply(l->fd, result, NULL, 0);
}

/* One request; anything else ends the line. */
static void hear(struct turns *t, struct line *l) {
  struct {
    struct wire_request head;
    char data[MOST_ASKED];
  } r;
  const ssize_t got = recv(l->fd, &r, sizeof(r), MSG_DONTWAIT);
  if (got < 0 && errno == EAGAIN) return;
  if (got < (ssize_t)sizeof(r.head) || r.head.magic != WIRE_MAGIC ||
      (size_t)got != sizeof(r.head) + r.head.length)
    leave_line(t, l, 0);
  else
    serve(t, l, &r.head, r.data);
}

int turns_hear(struct turns *t, int fd) {
  EACH_LINE(t, p, l) {
    if (l->fd != fd) continue;
    hear(t, l);
    return 1;
  }
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
