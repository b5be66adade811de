/* SPDX-License-Identifier: Apache-2.0 */
/* Error codes and the signal that tells of them, §2.3.4. The level is masked. */
#include "mc_priv.h"

#define COUNT_BP 16
#define AXIS_BP 8

void mc_count(int *counter, unsigned by) {
  if (by < (unsigned)(INT32_MAX - *counter)) {
    *counter += (int)by;
  } else {
    *counter = INT32_MAX;
  }
}

static void set_code(struct mc *mc, int axis, uint8_t flags, uint16_t count) {
  uint32_t code = 0;
  if (flags != 0) {
    code = (uint32_t)count << COUNT_BP | (uint32_t)axis << AXIS_BP | flags;
  }
  mc->axis[axis].state.errcode = (int32_t)code;
}

static void add(struct mc *mc, int axis, uint8_t flags, uint16_t count) {
  uint8_t all = (uint8_t)((mc->axis[axis].state.errcode & MERR_MASK) | flags);
  set_code(mc, axis, all, count);
  for (int i = 0; i < MC_MAX_CLIENTS; i++) mc->client[i].fresh[axis] |= flags;
}

static uint16_t index_count(const struct mc *mc, int axis) {
  return (uint16_t)((uint32_t)mc->axis[axis].state.errcode >> COUNT_BP);
}

void error_raise(struct mc *mc, int axis, uint8_t flags) {
  add(mc, axis, flags, index_count(mc, axis));
}

void error_raise_index(struct mc *mc, int axis, uint16_t count) {
  add(mc, axis, MERR_ZINDEX, count);
}

/* A client read the states of the first `axes` axes: of the others it has seen nothing. */
void error_seen(struct mc *mc, int client, int axes) {
  struct mc_client *c = &mc->client[client];
  c->has_read = 1;
  for (int axis = 0; axis < MC_MAX_AXES; axis++) c->fresh[axis] = axis < axes ? 0 : MERR_MASK;
}

/* Clears what the caller's last read() showed; what came since stays, and signals again. */
void error_clear(struct mc *mc, int client) {
  int remains = 0;
  for (int axis = 0; axis < mc->axes; axis++) {
    int keep = mc->client[client].has_read ? mc->client[client].fresh[axis] : 0;
    uint8_t left = (uint8_t)(mc->axis[axis].state.errcode & MERR_MASK & keep);
    set_code(mc, axis, left, (left & MERR_ZINDEX) != 0 ? index_count(mc, axis) : 0);
    if (left != 0) remains = 1;
  }
  if (remains) error_signal(mc);
}

void error_signal(struct mc *mc) {
  for (int i = 0; i < MC_MAX_CLIENTS; i++) {
    if (mc->client[i].used && mc->client[i].can_write) mc->os.signal(mc->os.ctx, i);
  }
}
