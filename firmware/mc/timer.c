/* SPDX-License-Identifier: Apache-2.0 */
/* SCLOCK and the count of its pulses, §4.3.4.
 *
 * Timer 2 decrements when SCLOCK falls; the sample and the interrupt are its rise. With F falls and
 * R rises counted from the same start, R = F while SCLOCK is high and R = F - 1 while it is low.
 * The level is asked for only when the count alone leaves both possible.
 */
#include "mc_priv.h"

#define COUNT_MAX 65536u
#define NEARBY 64u /* counts of timer 1 that are tried for an exact interval */

#define MODE2 (2u << MMCS_PIT_CONTROL_MODE_bp)
#define SELECT(timer) ((unsigned)(timer) << MMCS_PIT_CONTROL_SC_bp)

static uint64_t distance(uint64_t a, uint64_t b) {
  return a > b ? a - b : b - a;
}

/* Timer 0 gets the large count: while it counts nothing else in the adaptor changes. */
int timer_counts(const struct mc *mc, uint32_t us, uint32_t *n0, uint32_t *n1) {
  uint64_t ticks = ((uint64_t)us * mc->config.sysclk_hz + 500000u) / 1000000u;
  uint64_t best = UINT64_MAX;
  uint64_t first = (ticks + COUNT_MAX - 1) / COUNT_MAX;
  if (us < MC_INTERVAL_MIN_US || ticks > (uint64_t)COUNT_MAX * COUNT_MAX) return -MC_EINVAL;
  if (first < 2) first = 2;
  for (uint64_t n = first; n <= COUNT_MAX && n < first + NEARBY && best != 0; n++) {
    uint64_t m = (ticks + n / 2) / n;
    if (m < 2 || m > COUNT_MAX || distance(m * n, ticks) >= best) continue;
    best = distance(m * n, ticks);
    *n0 = (uint32_t)m;
    *n1 = (uint32_t)n;
  }
  return best <= ticks / 1000 ? 0 : -MC_EINVAL;
}

uint32_t timer_interval_us(const struct mc *mc) {
  uint64_t ticks = (uint64_t)mc->n0 * mc->n1;
  return (uint32_t)((ticks * 1000000u + mc->config.sysclk_hz / 2) / mc->config.sysclk_hz);
}

/* SCLOCKs that last at least `us`, and one. */
static uint32_t ticks_of(const struct mc *mc, uint32_t us) {
  return (us + mc->interval_us - 1) / mc->interval_us + 1;
}

/* One is left when the SCLOCK after the end of the heartbeats comes. */
uint32_t timer_grace(const struct mc *mc) {
  uint32_t ticks = ticks_of(mc, MC_HEARTBEAT_US), least = ticks_of(mc, MC_SERVO_US) + 1;
  return ticks > least ? ticks : least;
}

static void program(struct mc *mc, unsigned timer, uint32_t count) {
  uint16_t data = (uint16_t)(MMCS_PIT0 + 2 * timer);
  hw_put(mc, MMCS_PIT_CONTROL, (uint8_t)(SELECT(timer) | MMCS_PIT_CONTROL_RW_BOTH_gc | MODE2));
  hw_put(mc, data, (uint8_t)(count & 0xFF));
  hw_put(mc, data, (uint8_t)(count >> 8 & 0xFF));
}

/* Timer 2 loads its count at the end of a whole pulse of SCLOCK: SCLOCK is pulled low first (mode 0
 * does it at once), rises when timer 1 is programmed, and its first fall loads. Else the first pass
 * may find the old count. No latch may take that rise for a sample. */
void timer_start(struct mc *mc) {
  hw_set_pccsr(mc, 0, MMCS_PCCSR_LATCH_EN_bm);
  hw_put(mc, MMCS_PIT_CONTROL, (uint8_t)(SELECT(1) | MMCS_PIT_CONTROL_RW_BOTH_gc));
  program(mc, 2, 0);
  program(mc, 0, mc->n0);
  program(mc, 1, mc->n1);
  mc->synced = 0;
  mc->interval_us = timer_interval_us(mc);
  hw_set_pccsr(mc, MMCS_PCCSR_LATCH_EN_bm | MMCS_PCCSR_SCLOCK_EN_bm, 0);
}

static uint16_t falls(struct mc *mc) {
  hw_put(mc, MMCS_PIT_CONTROL, (uint8_t)SELECT(2));
  unsigned low = hw_get(mc, MMCS_PIT2);
  unsigned high = hw_get(mc, MMCS_PIT2);
  return (uint16_t)(0u - (high << 8 | low));
}

static int sclock_is_high(struct mc *mc) {
  hw_put(mc, MMCS_PIT_CONTROL,
         (uint8_t)(MMCS_PIT_READBACK_SC_bm | MMCS_PIT_READBACK_COUNT_N_bm |
                   2u << MMCS_PIT_READBACK_TIMERS_bp));
  return (hw_get(mc, MMCS_PIT1) & MMCS_PIT_STATUS_OUT_bm) != 0;
}

/* If SCLOCK is high after the count was taken, no fall came in between and F holds; if it is low,
 * no fall can come until it rose: the count taken then holds. */
static uint16_t rises(struct mc *mc, uint16_t f) {
  if (sclock_is_high(mc)) return f;
  return (uint16_t)(falls(mc) - 1);
}

unsigned timer_enter(struct mc *mc) {
  uint16_t now = falls(mc);
  unsigned passed = (uint16_t)(now - mc->rises);
  if (!mc->synced || passed > 1) {
    now = rises(mc, now);
    passed = (uint16_t)(now - mc->rises);
  }
  if (!mc->synced || mc->fault) passed = 1;
  mc->synced = !mc->fault; /* what could not be read tells nothing */
  mc->rises = now;
  return passed;
}

int timer_moved(struct mc *mc) {
  uint16_t now = falls(mc);
  if (now == mc->rises) return 0;
  if ((uint16_t)(now - mc->rises) > 1) return 1;
  return rises(mc, now) != mc->rises;
}
