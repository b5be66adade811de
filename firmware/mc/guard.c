/* SPDX-License-Identifier: Apache-2.0 */
/* Checks that the report does not have, off unless struct mc_guard asks for them. */
#include "mc_priv.h"

static int64_t size(int64_t v) {
  return v < 0 ? -v : v;
}

/* A shaft has a greatest speed; what a counter holds may have changed without it. */
static int jumps(const struct mc *mc, int32_t moved) {
  int32_t jump = mc->config.guard.jump;
  if (jump == 0 || (moved <= jump && moved >= -jump)) return 0;
  return size(moved) > (int64_t)jump * mc->skipped;
}

/* The error of the last sample, in a row of samples that were no better. */
static int is_astray(const struct mc_guard *g, struct mc_axis *x) {
  int32_t error = x->state.error;
  x->astray = error > g->follow || error < -g->follow ? x->astray + 1 : 0;
  return x->astray > g->samples;
}

/* A loop without an integral is slow by a part of its demand, and a speed has a count of doubt. An
 * axis that comes nearer to its speed is on its way. */
static int slips(const struct mc_guard *g, struct mc_axis *x) {
  if (x->wait > 0) return 0; /* no new sample since */
  int64_t demand = (int64_t)x->state.error + x->state.vel, off = size(x->state.error);
  int nears = off < x->astray;
  int64_t slip = x->slip + (nears ? 0 : off) - size(demand) / 4 - 2;
  x->astray = (uint32_t)off;
  x->slip = slip < 0 ? 0 : slip > INT32_MAX ? INT32_MAX : (int32_t)slip;
  return x->slip > g->follow;
}

/* Nobody asked it to move. */
static int creeps(const struct mc_guard *g, const struct mc_axis *x) {
  return x->code == MC_DAC_ZERO && size((int64_t)x->position - x->still_at) > g->follow;
}

/* The current does all that it may against the movement, and the axis is getting faster: what the
 * servo asks for is not what happens. An axis that is braked gets slower. */
static int runs_away(const struct mc *mc, struct mc_axis *x, int32_t moved) {
  int32_t error = x->state.error, speed = moved < 0 ? -moved : moved, slowest = x->slowest;
  int mode = x->par.mode & (MD_MASK | ADFB | ZEROFB);
  x->slowest = INT32_MAX;
  if (!x->servo.clipped && x->servo.over == 0) return 0;
  if ((mode != MD_POS && mode != MD_VEL) || mc->skipped > 1) return 0;
  if (!(moved > 0 && error < 0) && !(moved < 0 && error > 0)) return 0;
  x->slowest = speed < slowest ? speed : slowest;
  return mc->config.guard.runaway > 0 && speed - x->slowest > mc->config.guard.runaway;
}

static int strays(const struct mc *mc, struct mc_axis *x) {
  const struct mc_guard *g = &mc->config.guard;
  int mode = x->par.mode & MD_MASK, is_off = axis_is_off(&x->par);
  if (g->follow <= 0) return 0;
  if (!is_off || x->code != MC_DAC_ZERO) x->still_at = x->position;
  if (is_off) return creeps(g, x);
  if ((x->par.mode & ZEROFB) != 0) return 0; /* nothing is fed back: its error is its demand */
  if (mode == MD_POS) return is_astray(g, x);
  return mode == MD_VEL && (x->par.mode & ADFB) == 0 && slips(g, x);
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

/* One card after the other: nothing but the driver writes its modes. */
static int changed_card(struct mc *mc) {
  int card = mc->looked + 1 < mc->cards ? mc->looked + 1 : 0;
  mc->looked = (uint8_t)card;
  if (hw_card_get(mc, card, MMCS_CARD_PPI_A) != mc->card[card].a ||
      hw_card_get(mc, card, MMCS_CARD_PPI_B) != mc->card[card].b) {
    return card;
  }
  return -1;
}

static int trips_on_cards(struct mc *mc) {
  int card = mc->config.guard.readback ? changed_card(mc) : -1;
  if (card < 0) return 0;
  power_trip(mc, MCAUSE_GUARD, "PANIC: card", mc->card[card].dip, ": its modes changed");
  return 1;
}

int guard_refuses(struct mc *mc, const struct mmcs_setpoints *s) {
  int joins = !mc->sequenced || s->sequence == mc->sequence + 1;
  int good = s->check == mmcs_check(s);
  if (good && s->axes > (unsigned)mc->joints) return -MC_EINVAL;
  if (good && joins) {
    mc->sequence = s->sequence;
    mc->sequenced = 1;
    return 0;
  }
  if (mc->power == MC_RUNNING) {
    power_trip(mc, MCAUSE_GUARD,
               good ? "PANIC: setpoints were lost"
                    : "PANIC: setpoints changed on"
                      " their way",
               -1, "");
  }
  return good ? -MC_EIO : -MC_EINVAL;
}

static const char *fault_of(const struct mc *mc, struct mc_axis *x, int32_t moved) {
  if (jumps(mc, moved)) return ": its counter jumps";
  if (runs_away(mc, x, moved)) return " runs away";
  return strays(mc, x) ? " does not follow" : NULL;
}

static int trips_on_axes(struct mc *mc) {
  const uint16_t *counter = mc->sample.counter;
  const struct mc_axis *end = mc->axis + mc->joints;
  for (struct mc_axis *x = mc->axis; x < end; x++, counter++) {
    const char *why = fault_of(mc, x, (int16_t)(uint16_t)(*counter - x->counter));
    if (why == NULL) continue;
    int axis = (int)(x - mc->axis);
    x->faulty = 1;
    power_trip(mc, MCAUSE_GUARD, "PANIC: axis", axis, why);
    mc->cause_of = (uint8_t)(axis + 1);
    return 1;
  }
  return 0;
}

/* A sample has been read, and its pass is not yet computed. 1: the machine has been stopped. */
int guard_trips(struct mc *mc) {
  const struct mc_guard *g = &mc->config.guard;
  if (mc->power != MC_RUNNING) {
    mc->is_marked = 0;
    return 0;
  }
  if (trips_on_cards(mc)) return 1;
  if (g->clock && timer_is_off(mc)) {
    power_trip(mc, MCAUSE_GUARD, "PANIC: SCLOCK has another rate than was set", -1, "");
    return 1;
  }
  if (g->missed > 0 && mc->skipped > g->missed) {
    power_trip(mc, MCAUSE_GUARD, "PANIC: SCLOCKs that no pass served", (int)mc->skipped - 1, "");
    return 1;
  }
  if (g->lease > 0 && lapses(mc)) {
    power_trip(mc, MCAUSE_GUARD, "PANIC: SCLOCKs without a setpoint", (int)(mc->unwritten - 1), "");
    return 1;
  }
  return (g->jump > 0 || g->follow > 0 || g->runaway > 0) && trips_on_axes(mc);
}

int guard_locks(const struct mc *mc) {
  return mc->config.guard.lock != 0 && mc->power == MC_RUNNING;
}

int guard_locks_gains(const struct mc *mc, const struct mc_param *from, const struct mc_param *to) {
  const unsigned char *a = (const unsigned char *)from, *b = (const unsigned char *)to;
  unsigned n = 0;
  if (!guard_locks(mc) || from->mode != to->mode || axis_is_off(from)) return 0;
  while (n < sizeof *from && a[n] == b[n]) n++;
  return n < sizeof *from;
}
