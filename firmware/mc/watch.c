/* SPDX-License-Identifier: Apache-2.0 */
/* What stops the machine beside PANIC: bus errors, resets, interrupts that do not come, §2.3.4. */
#include "mc_priv.h"

/* Once, until a sample comes. */
void watch_bus_error(struct mc *mc) {
  revive_note(mc);
  if (mc->told_fault) return;
  mc->told_fault = 1;
  power_trip(mc, MCAUSE_BUS, "PANIC: bus error in a servo pass", -1, "");
}

/* SYSRESET* has cleared PCCSR, and with it the interrupts; cards may have been reset, too. For so
 * long their counters went on alone. */
static void restart(struct mc *mc, uint64_t us) {
  hw_put(mc, MMCS_PCCSR, (uint8_t)(mc->pccsr & ~MMCS_PCCSR_LATCH_EN_bm));
  hw_put(mc, MMCS_PCCSR, mc->pccsr);
  mc->skipped += (uint32_t)(us / mc->interval_us) + 1;
  for (int card = 0; card < mc->cards; card++) {
    mc->card[card].silent = 1;
    (void)revive_card(mc, card);
  }
}

int mc_watch(struct mc *mc, uint64_t us) {
  const uint8_t kept = MMCS_PCCSR_BASE_bm | MMCS_PCCSR_LATCH_EN_bm;
  int told = 1;
  if (mc->opens == 0 || us < MC_QUIET_US + 2 * (uint64_t)mc->interval_us) return 0;
  if (mc->told_at == (uint32_t)mc->stats.total) return 0;
  unsigned level = mc->os.mask(mc->os.ctx);
  mc->told_at = (uint32_t)mc->stats.total;
  mc->fault = 0;
  int reset = ((hw_get(mc, MMCS_PCCSR) ^ mc->pccsr) & kept) != 0;
  if (mc->fault) {
    power_trip(mc, MCAUSE_BUS, "PANIC: no interrupts, the adaptor does not answer", -1, "");
  } else if (reset) {
    power_trip(mc, MCAUSE_RESET, "PANIC: SYSRESET*, the adaptor was reset", -1, "");
    restart(mc, us);
  } else if (mc->power != MC_IDLE) {
    power_trip(mc, MCAUSE_LATE, "PANIC: no interrupts", -1, "");
  } else {
    told = 0;
  }
  mc->os.unmask(mc->os.ctx, level);
  return told;
}
