/* SPDX-License-Identifier: Apache-2.0 */
/* Error codes and the signal that tells of them, §2.3.4. The level is masked. */
#include "mc_priv.h"

#define COUNT_BP 16
#define AXIS_BP 8

void mc_count(int *counter, unsigned by) {
  *counter = by < (unsigned)(INT32_MAX - *counter) ? *counter + (int)by : INT32_MAX;
}

/* errcode of these flags; the count belongs to MERR_ZINDEX. */
static int code_of(const struct mc *mc, int axis, unsigned flags) {
  uint32_t code = 0;
  if (flags != 0) code = (uint32_t)axis << AXIS_BP | flags;
  if ((flags & MERR_ZINDEX) != 0) code |= (uint32_t)mc->axis[axis].index << COUNT_BP;
  return (int)code;
}

static unsigned flags_of(const struct mc *mc, int axis) {
  return mc->axis[axis].state.errcode & MERR_MASK;
}

void error_raise(struct mc *mc, int axis, uint8_t flags) {
  mc->axis[axis].state.errcode = code_of(mc, axis, flags_of(mc, axis) | flags);
  for (struct mc_client *c = mc->client; c < mc->client + MC_MAX_CLIENTS; c++) {
    c->since[axis] |= flags;
    c->untold[axis] |= flags;
    c->again[axis] &= (uint8_t)~flags;
  }
}

void error_raise_index(struct mc *mc, int axis, uint16_t count) {
  mc->axis[axis].index = count;
  error_raise(mc, axis, MERR_ZINDEX);
}

/* A client reads the states of the first `axes` axes, with what is pending and what came since it
 * looked, whoever has cleared that meanwhile. One loop: a pass that waits for its end is late. */
void error_show(struct mc *mc, int client, int axes, struct mc_state *states) {
  struct mc_client *c = &mc->client[client];
  c->has_read = 1;
  for (int axis = 0; axis < mc->axes; axis++) {
    c->since[axis] = c->again[axis] = 0;
    if (axis >= axes) continue;
    states[axis] = mc->axis[axis].state;
    if ((states[axis].errcode | c->untold[axis]) == 0) continue;
    states[axis].errcode = code_of(mc, axis, flags_of(mc, axis) | c->untold[axis]);
    c->untold[axis] = 0;
  }
}

/* It did not get them: a clear takes nothing away, and what was shown is shown again. */
void error_unseen(struct mc *mc, int client, int axes, const struct mc_state *shown) {
  struct mc_client *c = &mc->client[client];
  for (int axis = 0; axis < MC_MAX_AXES; axis++) {
    c->since[axis] = MERR_MASK;
    if (axis < axes) c->untold[axis] |= (uint8_t)(shown[axis].errcode & MERR_MASK);
  }
}

/* Clears what was pending at the caller's last read(), on all axes, covered by it or not; what came
 * since stays and signals once more: the handler that reads and clears has not seen it. */
void error_clear(struct mc *mc, int client) {
  struct mc_client *c = &mc->client[client];
  unsigned remains = 0;
  for (int axis = 0; axis < mc->axes; axis++) {
    uint8_t left = (uint8_t)(flags_of(mc, axis) & (c->has_read ? c->since[axis] : 0u));
    mc->axis[axis].state.errcode = code_of(mc, axis, left);
    c->untold[axis] &= c->has_read ? c->since[axis] : 0u; /* also what somebody else has cleared */
    remains |= left & (unsigned)~c->again[axis];
    c->again[axis] = left;
  }
  if (remains != 0) error_signal(mc);
}

void error_signal(struct mc *mc) {
  for (int i = 0; i < MC_MAX_CLIENTS; i++) {
    if (mc->client[i].used && mc->client[i].can_write) mc->os.signal(mc->os.ctx, i);
  }
}
