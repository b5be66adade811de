/* SPDX-License-Identifier: Apache-2.0 */
/* Closes the loop of the first card's two axes without a host: both hold the position in which they
 * are switched on. For a board with rtl/soc, docs/hardware/fpga.md; gains are those of a light
 * motor and are changed by MSETPARAM through the console. */
#include "mailbox.h"
#include "mc_priv.h"

#define INTERVAL_US 1000u
#define GAIN 4    /* D/A steps for each count */
#define LIMIT 512 /* D/A steps: a quarter of the range */

void loop_begin(struct mc *mc);

void loop_begin(struct mc *mc) {
  uint32_t interval = INTERVAL_US;
  int client = mc_open(mc, MC_O_RDWR);
  if (client < 0) return;
  if (mc_ioctl(mc, client, MSETINTERVAL, &interval) < 0) return;
  for (int axis = 0; axis < 2; axis++) {
    struct mc_param param = {.which = axis};
    if (mc_ioctl(mc, client, MGETPARAM, &param) < 0) return;
    param.mode = MD_POS;
    param.a0 = GAIN;
    param.ilim = LIMIT;
    if (mc_ioctl(mc, client, MSETPARAM, &param) < 0) return;
  }
  (void)mc_ioctl(mc, client, MENABLE,
                 NULL); /* the state tells, in the mailbox, if it was refused */
}
