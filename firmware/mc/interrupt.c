/* SPDX-License-Identifier: Apache-2.0 */
/* The interrupt handler: one servo pass at every SCLOCK, §4.3.6. */
#include "mc_priv.h"
#include "servo_math.h"

static void measure(struct mc_axis *x, uint16_t counter, uint16_t raw) {
  x->position = servo_extend(x->position, x->counter, counter);
  x->counter = counter;
  x->raw = raw;
  x->state.encnow = x->position;
  x->state.adcvai = SERVO_PHI(&x->par, &x->law, raw);
}

/* A sample of an axis that no demand moves. */
RARE static void rest_axis(struct mc_axis *x) {
  servo_sense(&x->par, &x->servo, &x->state);
}

/* One servo sample of one axis; returns the errors that happened. */
static uint8_t servo_axis(struct mc *mc, struct mc_axis *x) {
  if (x->adopt && (x->par.mode & MD_MASK) == MD_POS) {
    x->setpoint = (x->par.mode & ZEROFB) != 0 ? 0 : servo_feedback(&x->par, &x->state);
  }
  x->adopt = 0;
  int32_t current = SERVO_STEP(&x->par, &x->law, &x->servo, x->setpoint, &x->state);
  if (axis_is_off(&x->par)) {
    x->state.inow = servo_inow(&x->par, &x->servo, x->code - MC_DAC_ZERO);
  } else {
    x->code = (uint16_t)(MC_DAC_ZERO + current);
  }
  if (x->servo.clipped) mc_count(&mc->stats.clips, 1);
  return x->servo.events;
}

static void tell(struct mc *mc, int axis, uint8_t events) {
  if ((mc->verbosity & (M_VERBOSE | M_ERRORPRINT)) == 0) return;
  if ((events & MERR_PLO) != 0) text_log(mc, "axis", axis, ": low position limit");
  if ((events & MERR_PHI) != 0) text_log(mc, "axis", axis, ": high position limit");
  if ((events & MERR_ILIM) != 0) text_log(mc, "axis", axis, ": sustained current overload");
}

/* 1: the errors of an axis without SOFTERR shut the machine down, those of the first one first. */
RARE static int fail(struct mc *mc, struct mc_axis *x, int failed) {
  uint8_t events = x->servo.events;
  int axis = (int)(x - mc->axis);
  error_raise(mc, axis, events);
  tell(mc, axis, events);
  if ((x->par.mode & SOFTERR) != 0) return failed;
  if (!failed) power_blame(mc, MCAUSE_AXIS, axis);
  return 1;
}

/* All axes. */
static void servo_all(struct mc *mc) {
  const struct mc_axis *end = mc->axis + mc->axes, *joints = mc->axis + mc->joints;
  const struct mc_axis *served = mc->power == MC_IDLE ? mc->axis : joints;
  const uint16_t *counter = mc->sample.counter, *raw = mc->sample.raw;
  unsigned due = 0;
  int raised = 0, fatal = 0;
  for (struct mc_axis *x = mc->axis; x < end; x++) {
    measure(x, *counter++, *raw++);
    if (x->wait > 0) {
      x->wait--;
      continue;
    }
    x->wait = x->par.clkdivisor - 1;
    if (x < joints) due++;
    if (x >= served) {
      rest_axis(x);
    } else if (servo_axis(mc, x) != 0) {
      fatal = fail(mc, x, fatal);
      raised = 1;
    }
  }
  mc->os.compute(mc->os.ctx, due);
  if (fatal) power_stop(mc);
  if (raised) error_signal(mc);
}

/* The hardware's own sign of a PANIC whose edge was lost. */
static int heartbeats_live(const struct mc *mc) {
  if (mc->power != MC_RUNNING) return 1;
  const uint8_t both = MMCS_CARD_PPI_C_HEARTBEAT1_bm | MMCS_CARD_PPI_C_HEARTBEAT2_bm;
  for (int card = 0; card < mc->cards; card++) {
    if ((mc->sample.port_c[card] & both) != both) return 0;
  }
  return 1;
}

/* Counts what was missed. 0: this SCLOCK has been served by a pass that began late. */
static int enter(struct mc *mc) {
  unsigned passed = timer_enter(mc);
  if (passed == 0) {
    mc->overran++; /* no pass: the next one may still follow the last that overran */
    return 0;
  }
  mc_count(&mc->stats.missed, passed - 1);
  mc->grace -= passed < mc->grace ? passed : mc->grace;
  mc->skipped += passed;
  return 1;
}

/* An SCLOCK rose while the cards were read: no sample. 1: an axis was due and gets no current; it
 * stays due. Axes that are off hold what they have. Heartbeats follow the servo: what should have
 * computed and did not keeps none of them alive. */
static int skip_pass(struct mc *mc) {
  int due = 0;
  for (int axis = 0; axis < mc->axes; axis++) {
    struct mc_axis *x = &mc->axis[axis];
    if (x->wait > 0) {
      x->wait--;
    } else if (axis < mc->joints && !axis_is_off(&x->par)) {
      due = 1;
    }
  }
  if (!due || mc->power != MC_RUNNING) return 0;
  if ((uint64_t)mc->skipped * mc->interval_us >= MC_SKIP_US) {
    power_trip(mc, MCAUSE_LATE, "PANIC: passes outlast SCLOCK, no servo sample for 25 ms");
  }
  return 1;
}

/* The next SCLOCK rose before the end of this pass. On a processor of its own nothing but passes
 * runs while that goes on: no program, and no MENABLE comes to its end. Passes that end in time pay
 * nothing for the count. */
static void overran(struct mc *mc) {
  mc_count(&mc->stats.overrun, 1);
  uint32_t total = (uint32_t)mc->stats.total;
  int follows = total - mc->overran == 1;
  mc->overran = total;
  mc->crowded = follows ? mc->crowded + 1 : 1;
  if ((uint64_t)mc->crowded * mc->interval_us < MC_CROWDED_US) return;
  if (!watch_tell(mc, MC_TOLD_CROWDED)) return;
  text_log(mc, "passes outlast SCLOCK, programs get no time: the interval is too short", -1, "");
}

/* What was read is no sample: nor is the first of a card that has been silent, which may have to be
 * initialised again. */
static int refuse_sample(struct mc *mc, int good) {
  if (mc->fault) {
    watch_bus_error(mc);
  } else if (good && heartbeats_live(mc)) {
    revive_cards(mc);
  } else {
    if (!good) revive_note(mc);
    if (mc->power != MC_IDLE) power_panic(mc);
  }
  return 0;
}

/* PANIC first: a pulled cable would make all else read 0xFF. At rest it stops nothing: the sample
 * is read, and judged, as any other. */
static int servo_pass(struct mc *mc, int panic) {
  int begun = enter(mc), idle = mc->power == MC_IDLE;
  if (panic) power_panic(mc);
  if (!begun || (panic && !idle)) return 0;
  int good = sample_read(mc, &mc->sample);
  if (!good || !heartbeats_live(mc) || mc->silent) return refuse_sample(mc, good);
  int straddled = timer_moved(mc);
  calib_serve(mc, &mc->sample);
  if (straddled) {
    overran(mc);
    if (!skip_pass(mc) && mc->power == MC_RUNNING) hw_write_dacs(mc);
    return 0;
  }
  mc->skipped = 0;
  mc->told &= MC_TOLD_CROWDED;
  servo_all(mc);
  if (mc->power != MC_IDLE) {
    hw_write_dacs(mc);
    mc->power = MC_RUNNING;
  }
  if (timer_moved(mc)) overran(mc);
  return 1;
}

int mc_interrupt(struct mc *mc) {
  mc_count(&mc->stats.total, 1);
  mc->fault = 0;
  uint8_t seen = hw_take_latches(mc);
  if (mc->fault) {
    watch_bus_error(mc);
    return 0;
  }
  int panic = (seen & MMCS_PCCSR_PANIC_LATCHED_bm) != 0;
  if ((seen & MMCS_PCCSR_SCLOCK_LATCHED_bm) != 0) return servo_pass(mc, panic);
  if (panic) {
    power_panic(mc);
  } else {
    mc_count(&mc->stats.spurious, 1);
  }
  return 0;
}

void mc_spurious(struct mc *mc) {
  mc_count(&mc->stats.spurious, 1);
}
