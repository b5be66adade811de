/* SPDX-License-Identifier: Apache-2.0 */
/* Checks that the report does not have, off unless struct mc_guard asks for them. */
#include "mc_priv.h"

/* A shaft has a greatest speed; what a counter holds may have changed without it. */
static int jumps(const struct mc *mc, int axis) {
  const struct mc_axis *x = &mc->axis[axis];
  int32_t moved = (int16_t)(uint16_t)(mc->sample.counter[axis] - x->counter);
  int64_t limit = (int64_t)mc->config.guard.jump * mc->skipped;
  return mc->config.guard.jump > 0 && (moved > limit || -moved > limit);
}

/* The error of the last sample, in a row of samples that were no better. */
static int strays(const struct mc *mc, struct mc_axis *x) {
  const struct mc_guard *g = &mc->config.guard;
  if (g->follow <= 0 || (x->par.mode & MD_MASK) != MD_POS) return 0;
  int far = x->state.error > g->follow || x->state.error < -g->follow;
  x->astray = far ? x->astray + 1 : 0;
  return x->astray > g->samples;
}

static int all_off(const struct mc *mc) {
  int axis = 0;
  while (axis < mc->joints && axis_is_off(&mc->axis[axis].par)) axis++;
  return axis == mc->joints;
}

/* A program that has begun to write goes on, or lets all modes off: a setpoint grows old. */
static int lapses(struct mc *mc) {
  if (mc->unwritten > 0 && all_off(mc)) mc->unwritten = 0;
  if (mc->unwritten > mc->config.guard.lease) return 1;
  if (mc->unwritten > 0) mc->unwritten += mc->skipped;
  return 0;
}

/* A sample has been read, and its pass is not yet computed. 1: the machine has been stopped. */
int guard_trips(struct mc *mc) {
  const struct mc_guard *g = &mc->config.guard;
  int asked = g->jump > 0 || g->follow > 0 || g->missed > 0 || g->lease > 0;
  if (!asked || mc->power != MC_RUNNING) return 0;
  if (g->missed > 0 && mc->skipped > g->missed) {
    power_trip(mc, MCAUSE_GUARD, "PANIC: SCLOCKs that no pass served", (int)mc->skipped - 1, "");
    return 1;
  }
  if (lapses(mc)) {
    power_trip(mc, MCAUSE_GUARD, "PANIC: SCLOCKs without a setpoint", (int)(mc->unwritten - 1), "");
    return 1;
  }
  for (int axis = 0; axis < mc->joints; axis++) {
    if (jumps(mc, axis)) {
      power_trip(mc, MCAUSE_GUARD, "PANIC: axis", axis, ": its counter jumps");
      mc->cause_of = (uint8_t)(axis + 1);
      return 1;
    }
    if (strays(mc, &mc->axis[axis])) {
      power_trip(mc, MCAUSE_GUARD, "PANIC: axis", axis, " does not follow");
      mc->cause_of = (uint8_t)(axis + 1);
      return 1;
    }
  }
  return 0;
}

int guard_locks(const struct mc *mc) {
  return mc->config.guard.lock != 0 && mc->power == MC_RUNNING;
}
