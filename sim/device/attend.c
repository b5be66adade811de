/* SPDX-License-Identifier: Apache-2.0 */
/* The server's inner loop in lock-step, when one thread of one program runs: its read(), write()
 * and waits for samples, each as mmcs/device/programs.py and lockstep.py serve it. Whatever else
 * comes is handed to them. */
#define _GNU_SOURCE
#include <stdint.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include "../../firmware/include/mcdef.h"
#include "../abi/mmcs_sim.h"
#include "wire.h"

enum attend_end { END_IDLE = 0, END_BYTES = 1, END_WAIT = 2, END_REFUSED = 3 };

struct attend {
  mmcs_sim *sim;
  int (*read)(mmcs_sim *, int, void *, size_t);
  int (*write)(mmcs_sim *, int, const void *, size_t);
  int (*run_to)(mmcs_sim *, int64_t, int);
  int64_t (*clock)(const mmcs_sim *);
  int64_t (*samples)(const mmcs_sim *);
  int (*tap_head)(const mmcs_sim *, mmcs_tap_head *);
  int epoll, timeout_ms, line, channel, client;
  char name[WIRE_NAME];
  int64_t hz, limit, stretch, patience; /* clocks */
  int64_t quiet; /* events there were when a read took no time and showed no error; or -1 */
  int64_t wrote; /* events there were when a write took no time and succeeded; or -1 */
  struct wire_later *later; /* or null */
  /* what ended it */
  int64_t events; /* there had been before the last call */
  int fd, length, result, sampled, failed, waits;
  char data[sizeof(struct wire_request) + WIRE_MAX];
};

static int64_t events_of(const struct attend *a) {
  mmcs_tap_head head;
  (void)a->tap_head(a->sim, &head);
  return head.events;
}

static int reply(int fd, int result, const void *data, uint32_t length) {
  struct {
    struct wire_reply head;
    char data[WIRE_MAX];
  } out;
  ssize_t size = (ssize_t)(sizeof out.head + length);
  out.head.result = result;
  out.head.length = length;
  memcpy(out.data, data, length);
  (void)!send(fd, &out, (size_t)size, MSG_NOSIGNAL); /* who has gone is heard of by poll */
  return END_IDLE;
}

/* Up to the next sample; 0: what else ends a wait is not for here. */
static int wait_for_sample(struct attend *a) {
  int64_t patience = a->clock(a->sim) + a->patience, before = a->samples(a->sim);
  a->sampled = a->failed = 0;
  while (!a->sampled) {
    int64_t now = a->clock(a->sim), end = now + a->stretch < a->limit ? now + a->stretch : a->limit;
    if (end <= now || now > patience) return 0;
    a->failed = a->run_to(a->sim, end, 1) != 0;
    a->sampled = a->samples(a->sim) != before;
    if (a->failed || events_of(a) != a->events) return 0;
  }
  static struct {
    struct wire_now now;
    char states[WIRE_MAX - sizeof(struct wire_now)];
  } told;
  const struct wire_request *r = (const void *)a->data;
  int read = 0;
  told.now = (struct wire_now){.sample = (uint32_t)a->samples(a->sim)};
  told.now.flags = a->later != NULL && a->wrote == a->events ? NOW_WRITES : 0;
  told.now.ns = (uint64_t)((__int128)a->clock(a->sim) * 1000000000 / a->hz);
  if (r->a > 0 && r->a <= sizeof told.states && a->quiet == a->events)
    read = a->read(a->sim, a->client, told.states, (size_t)r->a);
  a->waits++;
  (void)reply(a->line, CAUSE_DUE, &told, (uint32_t)(sizeof told.now + (read > 0 ? read : 0)));
  return 1;
}

static int is_plain_wait(const struct attend *a) {
  const struct wire_request *r = (const void *)a->data;
  const struct wire_wait *w = (const void *)(a->data + sizeof *r);
  return r->op == WIRE_WAIT && r->length == sizeof *w && w->what == WAIT_SAMPLE &&
         w->until == WIRE_NEVER && w->pending == 0 && w->files == 0;
}

static int shows_error(const char *states, int bytes) {
  int bad = 0;
  for (const char *s = states; s < states + bytes; s += sizeof(struct mc_state))
    bad |= ((const struct mc_state *)(const void *)s)->errcode;
  return bad != 0;
}

static int write_now(struct attend *a, const void *data, uint32_t length) {
  int64_t before = a->clock(a->sim);
  a->result = a->write(a->sim, a->client, data, length);
  a->wrote = a->result != (int)length || a->clock(a->sim) != before ? -1 : a->events;
  return a->result;
}

/* Who stopped the machine meanwhile has said so: this write() is answered already. */
static void write_first(struct attend *a) {
  struct wire_later w = {0};
  if (a->later != NULL) w = *a->later;
  if (!w.due || memcmp(w.name, a->name, WIRE_NAME) != 0 || w.length > sizeof w.data) return;
  a->later->due = 0;
  (void)write_now(a, w.data, w.length);
}

/* A call of the program: -1 if it is not for here. */
static int call(struct attend *a) {
  static char states[WIRE_MAX];
  const struct wire_request *r = (const void *)a->data;
  if (memcmp(r->name, a->name, WIRE_NAME) != 0) return -1;
  if (r->op == WIRE_READ && r->length == 0 && r->a <= WIRE_MAX) {
    int64_t before = a->clock(a->sim);
    a->result = a->read(a->sim, a->client, states, (size_t)r->a);
    if (a->result < 0) return END_REFUSED;
    a->quiet = a->clock(a->sim) != before || shows_error(states, a->result) ? -1 : a->events;
    return reply(a->channel, a->result, states, (uint32_t)a->result);
  }
  if (r->op != WIRE_WRITE) return -1;
  if (write_now(a, a->data + sizeof *r, r->length) < 0) return END_REFUSED;
  return reply(a->channel, a->result, "", 0);
}

/* Until something comes that is not for here, or `turns` requests have been served. */
int attend(struct attend *a, int turns) {
  const struct wire_request *r = (const void *)a->data;
  a->waits = 0;
  a->events = events_of(a);
  while (turns-- > 0) {
    struct epoll_event ready[2];
    int n = epoll_wait(a->epoll, ready, 2, a->timeout_ms), end;
    if (n != 1 || ready[0].events != EPOLLIN) return END_IDLE;
    a->fd = ready[0].data.fd;
    if (a->fd != a->line && a->fd != a->channel) return END_IDLE;
    a->length = (int)recv(a->fd, a->data, sizeof a->data, MSG_DONTWAIT);
    if (a->length < (int)sizeof *r || r->magic != WIRE_MAGIC ||
        (size_t)a->length != sizeof *r + r->length)
      return END_BYTES;
    if (a->fd == a->line) {
      write_first(a);
      if (events_of(a) != a->events || !is_plain_wait(a)) return END_BYTES;
      if (!wait_for_sample(a)) return END_WAIT;
      continue;
    }
    end = call(a);
    if (end != END_IDLE) return end < 0 ? END_BYTES : end;
    if (events_of(a) != a->events) return END_IDLE;
  }
  return END_IDLE;
}
