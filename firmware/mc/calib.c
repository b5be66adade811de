/* SPDX-License-Identifier: Apache-2.0 */
/* Calibration: the count at the index, §5.3.4. The level is masked.
 *
 * SCLOCK does not latch a calibrating card, so that only the index can hold a count; both its
 * encoders are read live and its A/Ds stand still meanwhile.
 */
#include "mc_priv.h"

void calib_start(struct mc *mc, int axis) {
  int card = axis / 2;
  if (mc->axis[axis].calib) return;
  mc->calibrates = 1;
  mc->axis[axis].calib = 1;
  mc->card[card].rearm = MC_DROPPED;
  hw_apply_modes(mc); /* index latches clear, SCLOCK off */
  (void)hw_counter(mc, axis & ~1);
  (void)hw_counter(mc, axis | 1); /* what SCLOCK latched last is out of the way */
  mc->card[card].rearm = MC_ARMED;
  hw_apply_modes(mc);
}

/* An axis that needs its A/D value, which stands still while its card calibrates. */
int calib_disturbs(const struct mc_param *par) {
  if ((par->mode & (ADFB | ADDMD | ADOFF)) == 0) return 0;
  return !axis_is_off(par) || (par->mode & POSCHK) != 0;
}

/* Of all axes; the caller applies the modes. */
void calib_cancel(struct mc *mc) {
  for (int axis = 0; axis < mc->axes; axis++) mc->axis[axis].calib = 0;
  for (int card = 0; card < mc->cards; card++) mc->card[card].rearm = MC_ARMED;
  mc->calibrates = 0;
}

/* Of one axis: its index is not waited for any more, its count stays what it is. */
void calib_end(struct mc *mc, int axis) {
  int card = axis / 2;
  if (!mc->axis[axis].calib) return;
  mc->axis[axis].calib = 0;
  if (!axis_calibrates(mc, card)) mc->card[card].rearm = MC_ARMED;
  hw_apply_modes(mc);
  (void)hw_counter(mc, axis); /* what the index latched last is out of the way */
}

static void leave(struct mc *mc, int axis) {
  mc->axis[axis].calib = mc->axis[axis].lost = 0;
  hw_apply_modes(mc);
}

static void arm_again(struct mc *mc, int card) {
  uint8_t *rearm = &mc->card[card].rearm;
  if (*rearm == MC_ARMED) return;
  *rearm = *rearm == MC_DROPPED ? MC_DROPPED_EARLIER : MC_ARMED;
  hw_apply_modes(mc);
}

void calib_serve(struct mc *mc, const struct mc_sample *s) {
  int found = 0;
  if (!mc->calibrates) return;
  mc->calibrates = 0;
  for (int axis = 0; axis < mc->axes; axis++) {
    if (!s->indexed[axis]) continue;
    error_raise_index(mc, axis, s->index[axis]);
    leave(mc, axis);
    found = 1;
  }
  for (int card = 0; card < mc->cards; card++) {
    arm_again(mc, card);
    const struct mc_axis *x = &mc->axis[2 * card];
    if (mc->card[card].rearm != MC_ARMED || x[0].calib || x[1].calib) mc->calibrates = 1;
  }
  if (found) error_signal(mc);
}
