/* SPDX-License-Identifier: Apache-2.0 */
/* What tests of the driver share: the traffic that they expect, what the driver says, calls. */
#ifndef TRAFFIC_H
#define TRAFFIC_H

#include "harness.h"
#include "mc_priv.h"
#include "mock.h"

#define R(offset) {0, (uint16_t)(offset), 0}
#define W(offset, value) {1, (uint16_t)(offset), (uint8_t)(value)}
/* A counter, its high byte at `offset`: port C of its card, which begins a new pair, and the pair.
 */
#define PAIR(offset) R(((offset) & ~0x3F) | 5), R(offset), R((offset) + 2)

/* What was logged is `want`, in order. Values count for writes only. */
static inline void traffic_check(const char *file, int line, const struct mock *m,
                                 const struct mock_access *want, int n) {
  for (int i = 0; i < n && i < m->used; i++) {
    if (m->log[i].write != want[i].write || m->log[i].offset != want[i].offset ||
        (want[i].write && m->log[i].value != want[i].value)) {
      printf("%s:%d: access %d: %s 0x%03x 0x%02x\n", file, line, i,
             m->log[i].write ? "write" : "read", m->log[i].offset, m->log[i].value);
      exit(1);
    }
  }
  if (m->used != n) {
    printf("%s:%d: %d accesses, want %d\n", file, line, m->used, n);
    exit(1);
  }
}

#define EXPECT(m, want) traffic_check(__FILE__, __LINE__, m, want, (int)(COUNT(want)))
#define TRAFFIC(...)                                     \
  do {                                                   \
    const struct mock_access traffic_[] = {__VA_ARGS__}; \
    EXPECT(&m, traffic_);                                \
  } while (0)

/* A hook for mock.on_access: the handler's accesses are left out of the log. */
static inline void traffic_of_process(struct mock *m) {
  if (m->logging && m->serving) m->used--;
}

/* What an axis has now. */
static inline struct mc_param param_of(struct mc *mc, int axis) {
  struct mc_param par = {.which = axis};
  CHECK_EQ(mc_ioctl(mc, 0, MGETPARAM, &par), 0);
  return par;
}

/* Assignments to members of `par`, the parameters of an axis. */
#define CHANGE(mc, axis, ...)                      \
  do {                                             \
    struct mc_param par = param_of(mc, axis);      \
    __VA_ARGS__;                                   \
    CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0); \
  } while (0)

static inline void set_mode(struct mc *mc, int axis, int mode) {
  CHANGE(mc, axis, par.mode = mode);
}

/* A request of the first client whose argument is a number, and which succeeds. */
static inline void call(struct mc *mc, uint32_t request, int64_t arg) {
  uint32_t word = (uint32_t)arg;
  CHECK_EQ(mc_ioctl(mc, 0, request, &word), 0);
}

/* Setpoints of the first axes, by the first client. */
#define DEMAND(mc, ...)                                                 \
  do {                                                                  \
    const int32_t demand_[] = {__VA_ARGS__};                            \
    CHECK_EQ(mc_write(mc, 0, demand_, sizeof demand_), sizeof demand_); \
  } while (0)

static inline int errcode_of(const struct mock *m, int axis) {
  return mc_state_of(m->memory, axis)->errcode;
}

/* The index of an axis passes at the count `at`, and the axis goes on. */
static inline void pass_index(struct mock *m, int axis, uint16_t at) {
  struct mock_card *c = &m->card[axis / 2];
  c->latched[axis & 1] = at;
  c->has_latch[axis & 1] = c->index[axis & 1] = 1;
  c->count[axis & 1] = (uint16_t)(at + 17);
}

/* Another mode of an axis, its position limits at 100 counts to both sides. */
static inline void set_mode_within_100(struct mc *mc, int axis, int mode) {
  CHANGE(mc, axis, par.mode = mode, par.plo = -100, par.phi = 100);
}

static struct mock m; /* of the test */

/* What the driver says: its lines, each with a newline. */
static char said[1024];

static inline void hear(void *ctx, const char *text) {
  (void)ctx;
  CHECK(strlen(said) + strlen(text) + 2 < sizeof said);
  for (const char *at = text; *at != 0; at++) mock_tell((uint8_t)*at);
  strcat(said, text);
  strcat(said, "\n");
}

#define SAID(text) CHECK_EQ(strcmp(said, text), 0)

static inline int enable(struct mc *mc) {
  return mc_ioctl(mc, 0, MENABLE, NULL);
}

/* A driver of so many cards, opened once, that is listened to. */
static inline struct mc *listening(int cards) {
  struct mc *mc = mock_open(&m, cards);
  mc->os.log = hear;
  said[0] = 0;
  return mc;
}

#endif
