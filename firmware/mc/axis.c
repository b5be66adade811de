/* SPDX-License-Identifier: Apache-2.0 */
/* What the parameters and the demand of an axis mean for the rest of the driver. */
#include "mc_priv.h"

int axis_is_off(const struct mc_param *par) {
  int mode = par->mode & MD_MASK;
  return mode < MD_POS || mode > MD_TEST1;
}

/* It would run away from artificial signals. */
int axis_needs_encoder(const struct mc_param *par) {
  int mode = par->mode & MD_MASK, fed_back = mode <= MD_VEL && (par->mode & ZEROFB) == 0;
  if (axis_is_off(par) || (par->mode & ADFB) != 0) return 0;
  return fed_back || (par->mode & POSCHK) != 0;
}

int axis_needing_encoder(const struct mc *mc) {
  for (int axis = 0; axis < mc->joints; axis++) {
    if (axis_needs_encoder(&mc->axis[axis].par)) return axis;
  }
  return -1;
}

int axis_calibrates(const struct mc *mc, int card) {
  return mc->axis[2 * card].calib || mc->axis[2 * card + 1].calib;
}

void axis_forget_demand(struct mc_axis *x) {
  x->setpoint = 0;
  x->adopt = 1;
}

int axis_demand(struct mc *mc, int axis, int n, const int32_t *values) {
  if (mc->stopped != MC_FREE || mc->shut != MC_FREE) {
    if (mc->stopped == MC_LATCHED) text_log(mc, "write: stopped, MENABLE first", -1, "");
    if (mc->shut == MC_LATCHED) text_log(mc, "write: shut down by an error, MENABLE first", -1, "");
    if (mc->stopped != MC_FREE) mc->stopped = MC_LATCHED_TOLD;
    if (mc->shut != MC_FREE) mc->shut = MC_LATCHED_TOLD;
    return -MC_EIO;
  }
  for (int i = 0; i < n; i++) {
    mc->axis[axis + i].setpoint = values[i];
    mc->axis[axis + i].adopt = 0;
  }
  return 0;
}

/* The axis that cannot be held where it is, as nobody knows where that is; or -1. */
int axis_with_lost_count(const struct mc *mc) {
  for (int axis = 0; axis < mc->joints; axis++) {
    const struct mc_axis *x = &mc->axis[axis];
    if (x->lost && (x->par.mode & MD_MASK) == MD_POS && (x->par.mode & (ADFB | ZEROFB)) == 0) {
      return axis;
    }
  }
  return -1;
}
