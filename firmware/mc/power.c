/* SPDX-License-Identifier: Apache-2.0 */
/* Enable, stop and PANIC, §2.3.4 and §5.3.6.
 *
 * A low byte written to a D/A starts its heartbeat; when all heartbeats live PANIC clears and the
 * brakes open. So nothing but a servo pass that holds the axes writes low bytes first, and after
 * the last zero nobody writes them again.
 */
#include "mc_priv.h"

/* Starts all axes afresh: no history, and no demand but to stay, until a process writes one. */
static void restart_axes(struct mc *mc) {
  for (struct mc_axis *x = mc->axis; x < mc->axis + mc->axes; x++) {
    servo_reset(&x->servo);
    x->wait = 0;
    axis_forget_demand(x);
  }
}

static void forget_currents(struct mc *mc) {
  for (struct mc_axis *x = mc->axis; x < mc->axis + mc->axes; x++) {
    x->code = MC_DAC_ZERO;
    x->state.inow = 0;
  }
}

/* Zero to every D/A; the low byte only where the heartbeat lives anyway (bit of port C): starting
 * a dead one would open the brakes once more. One list, since the level is masked. 1: one lives. */
static int write_zeros(struct mc *mc, const uint8_t *port_c) {
  uint16_t offsets[MC_DRIVE * MC_MAX_CARDS];
  uint8_t values[MC_DRIVE * MC_MAX_CARDS];
  const uint16_t *of = mc->list.drive; /* low byte and high byte of each axis */
  unsigned n = 0, axes = (unsigned)mc->axes;
  for (int axis = 0; axis < mc->axes; axis++, of += 2) {
    if (mc->power == MC_RUNNING && port_c != NULL && (port_c[axis / 2] & HEARTBEAT_BM(axis)) != 0) {
      offsets[n] = of[0];
      values[n++] = MC_DAC_ZERO & 0xFF;
    }
    offsets[n] = of[1];
    values[n++] = MC_DAC_ZERO >> 8;
  }
  hw_put_list(mc, offsets, values, n);
  return n > axes;
}

/* From here on nothing tells of PANIC, which is the stop's own. */
static void deafen(struct mc *mc) {
  hw_set_pccsr(mc, 0, MMCS_PCCSR_PANIC_EN_bm);
}

/* The relay isolates all D/As once they are at zero. The stop is deaf to PANIC by now. */
static void silence(struct mc *mc, const uint8_t *port_c) {
  mc->buffered = 0;
  hw_apply_modes(mc);
  if (write_zeros(mc, port_c)) mc->grace = timer_grace(mc);
  mc->power = MC_IDLE;
  mc->drive = 0;
  hw_apply_modes(mc);
  forget_currents(mc);
}

/* Heartbeats may be dead already: after SYSRESET* no servo pass came and nobody noticed. */
void power_stop(struct mc *mc) {
  uint8_t port_c[MC_MAX_CARDS] = {0};
  if (mc->power == MC_IDLE && !mc->drive) return;
  deafen(mc);
  for (int card = 0; card < mc->cards; card++) {
    port_c[card] = hw_card_get(mc, card, MMCS_CARD_PPI_C);
  }
  silence(mc, port_c);
}

void power_rest(struct mc *mc) {
  calib_cancel(mc);
  power_stop(mc);
  hw_apply_modes(mc);
  for (struct mc_axis *x = mc->axis; x < mc->axis + mc->axes; x++) {
    x->par.mode &= ~MD_MASK;
    x->setpoint = 0;
    x->servo.primed = 0;     /* at rest from now on; all else ends at MENABLE, which has the time */
    x->law.kind = SERVO_OFF; /* as servo_prepare() has it of this mode */
    x->law.top = 0;
  }
}

/* What an operator wants to know first: whose fault it is (§1.3.2). */
static void diagnose(struct mc *mc, uint8_t *port_c, uint8_t *dead) {
  for (int card = 0; card < mc->cards; card++) {
    port_c[card] = hw_card_get(mc, card, MMCS_CARD_PPI_C);
    dead[card] = port_c[card] == 0xFF && hw_card_get(mc, card, MMCS_CARD_PPI_A) != mc->card[card].a;
    if (dead[card]) mc->card[card].silent = mc->silent = 1;
  }
}

static void tell_all(struct mc *mc) {
  mc_count(&mc->stats.panics, 1);
  for (int axis = 0; axis < mc->axes; axis++) error_raise(mc, axis, MERR_PANIC);
  error_signal(mc);
}

void power_blame(struct mc *mc, int cause, int number) {
  mc->shut = MC_LATCHED;
  mc->cause = (uint8_t)cause;
  mc->cause_of = (uint8_t)(number + 1);
}

void power_trip(struct mc *mc, int cause, const char *what) {
  power_blame(mc, cause, -1);
  power_stop(mc);
  tell_all(mc);
  text_log(mc, what, -1, "");
}

/* Whose fault it is, as far as registers tell; `aloud`: to the console, too. */
static void blame_panic(struct mc *mc, const uint8_t *port_c, const uint8_t *dead, int aloud) {
  int first = -1, gone = -1, silent = 0; /* axis without a heartbeat, card that does not answer */
  for (int axis = 0; axis < mc->axes; axis++) {
    int card = axis / 2;
    if (dead[card]) {
      if ((axis & 1) != 0) continue;
      if (aloud) text_log(mc, "PANIC: card", mc->card[card].dip, " does not answer");
      if (silent++ == 0) gone = mc->card[card].dip;
    } else if ((port_c[card] & HEARTBEAT_BM(axis)) == 0) {
      if (aloud) text_log(mc, "PANIC: axis", axis, " has no heartbeat");
      if (first < 0) first = axis;
    }
  }
  if (silent > 0 && silent == mc->cards) {
    power_blame(mc, MCAUSE_SILENT, -1);
  } else if (silent > 0) {
    power_blame(mc, MCAUSE_CARD, gone);
  } else {
    power_blame(mc, first < 0 ? MCAUSE_PASSED : MCAUSE_HEARTBEAT, first);
  }
  if (aloud && first < 0 && (silent == 0 || silent == mc->cards)) {
    text_log(mc, "PANIC: button, cable or power", -1, "");
  }
}

void power_panic(struct mc *mc) {
  uint8_t port_c[MC_MAX_CARDS] = {0}, dead[MC_MAX_CARDS] = {0};
  if (mc->power == MC_IDLE) {
    if (mc->grace == 0) mc_count(&mc->stats.panics, 1);
    mc->grace = 0;
    return;
  }
  int started = mc->power == MC_RUNNING;
  diagnose(mc, port_c, dead);
  deafen(mc);
  silence(mc, port_c);
  tell_all(mc);
  blame_panic(mc, port_c, dead, started);
}

/* Card by card, so that no pass waits for more than one of them. */
static int check_cards(struct mc *mc) {
  int bad = -1;
  for (int card = 0; card < mc->cards && bad < 0; card++) {
    unsigned level = mc->os.mask(mc->os.ctx);
    mc->fault = 0;
    if (!revive_card(mc, card) || mc->fault) bad = card;
    mc->os.unmask(mc->os.ctx, level);
  }
  if (bad < 0) return 0;
  text_log(mc, "enable: card", mc->card[bad].dip, " does not answer");
  return -MC_EIO;
}

/* 0, or what keeps the axes from being servoed by their counts. */
static int check_counts(struct mc *mc) {
  int axis = axis_with_lost_count(mc);
  if (axis >= 0) {
    text_log(mc, "enable: axis", axis, ": its count was lost: MSETENC or MCALIB first");
    return -MC_EIO;
  }
  if ((mc->diag & M_ENDIAG) == 0) return 0;
  axis = axis_needing_encoder(mc);
  if (axis < 0) return 0;
  text_log(mc, "enable: axis", axis, " needs its encoder, which M_ENDIAG cuts off");
  return -MC_EBUSY;
}

/* Our own stop may still be raising PANIC: wait until all heartbeats are dead, and an SCLOCK has
 * seen it. */
static void wait_for_silence(struct mc *mc) {
  uint32_t interval = mc->interval_us < MC_SERVO_US ? mc->interval_us : MC_SERVO_US;
  uint32_t most = MC_SERVO_US + interval + 1000;
  if (most < MC_HEARTBEAT_US) most = MC_HEARTBEAT_US;
  for (uint32_t us = 0; us < most && mc->grace > 0; us += 1000) {
    mc->os.delay_us(mc->os.ctx, 1000);
  }
  mc->grace = 0;
}

static void connect_drives(struct mc *mc) {
  unsigned level = mc->os.mask(mc->os.ctx);
  if (mc->stopped == MC_FREE) {
    mc->buffered = 0;
    hw_apply_modes(mc);
    (void)write_zeros(mc, NULL); /* no heartbeat lives */
    mc->drive = 1;
    hw_apply_modes(mc);
  }
  mc->os.unmask(mc->os.ctx, level);
  if (mc->drive) mc->os.delay_us(mc->os.ctx, MC_RELAY_US);
}

static void await_first_pass(struct mc *mc) {
  uint64_t limit = 2 * (uint64_t)mc->interval_us + 5000;
  uint32_t step = mc->interval_us < 1000 ? mc->interval_us : 1000;
  unsigned level = mc->os.mask(mc->os.ctx);
  mc->buffered = mc->double_buffer;
  hw_apply_modes(mc);
  mc->os.unmask(mc->os.ctx, level);
  /* An interrupt that waited is served here: the first pass, the longest, must not begin late. */
  level = mc->os.mask(mc->os.ctx);
  if (mc->drive) { /* no stop came */
    restart_axes(mc);
    mc->power = MC_STARTING;
  }
  mc->os.unmask(mc->os.ctx, level);
  for (uint64_t us = 0; us < limit && mc->power == MC_STARTING; us += step) {
    mc->os.delay_us(mc->os.ctx, step);
  }
}

static int check_first_pass(struct mc *mc) {
  if (mc->power == MC_IDLE) {
    text_log(mc, "enable: stopped by an error, PANIC or MSTOP", -1, "");
    return -MC_EIO;
  }
  if (mc->power == MC_STARTING) {
    text_log(mc, "enable: no servo interrupt", -1, "");
    return -MC_EIO;
  }
  return 0;
}

/* The first pass has written every D/A: every heartbeat must be there now. The level is open: so
 * many reads would make the next pass late. */
static int check_heartbeats(struct mc *mc) {
  for (int axis = 0; axis < mc->axes; axis++) {
    uint8_t c = hw_card_get(mc, axis / 2, MMCS_CARD_PPI_C);
    if ((c & HEARTBEAT_BM(axis)) != 0) continue;
    text_log(mc, "enable: axis", axis, " has no heartbeat");
    return -MC_EIO;
  }
  return 0;
}

/* Of a machine at rest whose cards answer. A stop that comes meanwhile is latched anew. */
static int start(struct mc *mc) {
  int result;
  wait_for_silence(mc);
  connect_drives(mc);
  await_first_pass(mc);
  result = check_first_pass(mc);
  if (result == 0) result = check_heartbeats(mc);
  unsigned level = mc->os.mask(mc->os.ctx);
  if (result == 0) result = check_first_pass(mc); /* a stop may have come meanwhile */
  if (result != 0) {
    power_stop(mc);
  } else {
    hw_set_pccsr(mc, MMCS_PCCSR_PANIC_EN_bm, 0);
  }
  mc->os.unmask(mc->os.ctx, level);
  return result;
}

int power_enable(struct mc *mc) {
  int result = check_cards(mc);
  if (result == 0) result = check_counts(mc);
  if (mc->power == MC_STARTING || (mc->power == MC_IDLE && mc->drive)) return -MC_EBUSY;
  if (mc->power == MC_RUNNING) {
    unsigned level = mc->os.mask(mc->os.ctx);
    if (result == 0) restart_axes(mc);
    mc->os.unmask(mc->os.ctx, level);
    return result;
  }
  if (result != 0) return result;
  uint8_t stopped = mc->stopped;
  mc->stopped = MC_FREE;
  result = start(mc);
  if (result == 0) {
    mc->shut = MC_FREE;
    mc->cause = MCAUSE_NONE;
  }
  if (result != 0 && mc->stopped == MC_FREE) mc->stopped = stopped;
  return result;
}
