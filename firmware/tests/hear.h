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

#endif
