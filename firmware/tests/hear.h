/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver under test says: its lines, each with a newline, in the order of saying. */
#ifndef HEAR_H
#define HEAR_H
#include "traffic.h"

static char said[1024];

static void hear(void *ctx, const char *text) {
  (void)ctx;
  CHECK(strlen(said) + strlen(text) + 2 < sizeof said);
  strcat(said, text);
  strcat(said, "\n");
}

/* A driver of so many cards, opened once, that is listened to. */
static inline struct mc *listening(int cards) {
  struct mc *mc = mock_open(&m, cards);
  mc->os.log = hear;
  said[0] = 0;
  return mc;
}

static inline void set_modes(struct mc *mc, int mode) {
  for (int axis = 0; axis < 2; axis++) {
    set_mode(mc, axis, mode);
  }
}

/* Two axes under power in position mode, at rest, 1 ms. */
static inline struct mc *guarded(struct mc_guard guard) {
  struct mc *mc = listening(1);
  mc->config.guard = guard;
  call(mc, MSETINTERVAL, 1000);
  set_modes(mc, MD_POS);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  mock_run(&m, 20000);
  CHECK(mc_is_enabled(mc));
  said[0] = 0;
  m.signals[0] = 0;
  return mc;
}

#endif
