/* SPDX-License-Identifier: Apache-2.0 */
/* What stops the machine beside PANIC: bus errors, resets, interrupts that do not come, §2.3.4. */
#include "mc_priv.h"

int watch_tell(struct mc *mc, uint8_t what) {
  if ((mc->told & what) != 0) return 0;
  mc->told |= what;
  return 1;
}

static int trip(struct mc *mc, uint8_t told, int cause, const char *what) {
  if (!watch_tell(mc, told)) return 0;
  power_trip(mc, cause, what);
  return 1;
}

void watch_bus_error(struct mc *mc) {
  revive_note(mc);
  (void)trip(mc, MC_TOLD_FAULT, MCAUSE_BUS, "PANIC: bus error in a servo pass");
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

/* Looks at every call, since an adaptor that does not answer may do so later; a changed vector
 * shows in nothing but the missing interrupts. */
int mc_watch(struct mc *mc, uint64_t us) {
  const uint8_t kept = MMCS_PCCSR_BASE_bm | MMCS_PCCSR_LATCH_EN_bm;
  int told = 0;
  if (mc->opens == 0 || us < MC_QUIET_US + 2 * (uint64_t)mc->interval_us) return 0;
  unsigned level = mc->os.mask(mc->os.ctx);
  mc->fault = 0;
  int reset = ((hw_get(mc, MMCS_PCCSR) ^ mc->pccsr) & kept) != 0;
  if (!mc->fault) hw_put(mc, MMCS_VECTOR, mc->config.vector);
  if (mc->fault) {
    told = trip(mc, MC_TOLD_QUIET, MCAUSE_BUS, "PANIC: no interrupts, the adaptor does not answer");
  } else if (reset) {
    told = trip(mc, MC_TOLD_QUIET, MCAUSE_RESET, "PANIC: PCCSR changed, by SYSRESET* or a program");
    restart(mc, us);
  } else if (mc->power != MC_IDLE) {
    told = trip(mc, MC_TOLD_QUIET, MCAUSE_LATE, "PANIC: no interrupts");
  }
  mc->os.unmask(mc->os.ctx, level);
  return told;
}
