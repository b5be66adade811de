/* SPDX-License-Identifier: Apache-2.0 */
/* Requests of <sys/mmcs.h>, which the report does not have: the setpoint of one axis, the end of
 * one axis' calibration. */
#include "traffic.h"

static int set(struct mc *mc, int axis, int value) {
  struct mmcs_setpoint one = {.axis = axis, .value = value};
  return mc_ioctl(mc, 0, MSETPOINT, &one);
}

static int end(struct mc *mc, int axis) {
  return mc_ioctl(mc, 0, MCALIBEND, &axis);
}

/* It takes no axis but its own out of where a new mode holds it. */
TEST(test_the_others_keep_where_they_are, "DRV-4 DRV-3") {
  struct mc *mc = mock_open(&m, 1);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  m.card[0].count[0] = m.card[0].count[1] = 500;
  mock_run(&m, 5000);
  for (int axis = 0; axis < 2; axis++) {
    set_mode(mc, axis, MD_POS);
  }
  CHECK_EQ(set(mc, 1, 510), 0);
  mock_run(&m, 5000);
  CHECK_EQ(mc_setpoint(mc, 0), 500);
  CHECK_EQ(mc_setpoint(mc, 1), 510);
}

TEST(test_after_a_stop_it_is_refused_as_a_write_is, "DRV-6") {
  struct mc *mc = mock_open(&m, 1);
  CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
  CHECK_EQ(set(mc, 0, 5), -MC_EIO);
  CHECK_EQ(mc_setpoint(mc, 0), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  CHECK_EQ(set(mc, 0, 5), 0);
}

TEST(test_the_end_of_one_calibration, "DRV-8 CAL-1") {
  struct mc *mc = mock_open(&m, 2);
  call(mc, MCALIB, 2);
  call(mc, MCALIB, 3);
  CHECK_EQ(end(mc, 2), 0);
  CHECK_EQ(m.card[1].b, 0x11); /* the other still waits */
  pass_index(&m, 2, 40);
  mock_run(&m, 5000);
  CHECK_EQ(errcode_of(&m, 2), 0);
  pass_index(&m, 3, 60);
  mock_pass(&m);
  CHECK_EQ(errcode_of(&m, 3), 60 << 16 | 3 << 8 | MERR_ZINDEX);
  CHECK_EQ(m.card[1].b, 5);
}

/* What the index has latched meanwhile is nobody's position. */
TEST(test_the_end_leaves_the_position, "DRV-8 DRV-11") {
  struct mc *mc = mock_open(&m, 1);
  call(mc, MCALIB, 0);
  mock_run(&m, 5000);
  pass_index(&m, 0, 300);
  m.logging = 1;
  CHECK_EQ(end(mc, 0), 0);
  TRAFFIC(W(0x003, 5), PAIR(0x009));
  m.logging = 0;
  mock_run(&m, 5000);
  CHECK_EQ(errcode_of(&m, 0), 0);
  CHECK_EQ(mc_state_of(mc, 0)->encnow, 317);
  call(mc, MCALIB, 0); /* and it can be asked for again */
  pass_index(&m, 0, 320);
  mock_run(&m, 5000);
  CHECK_EQ(errcode_of(&m, 0), 320 << 16 | MERR_ZINDEX);
}

TEST(test_an_end_of_nothing, "DRV-3") {
  struct mc *mc = mock_open(&m, 1);
  m.logging = 1;
  CHECK_EQ(end(mc, 1), 0);
  CHECK_EQ(m.used, 0);
  CHECK_EQ(end(mc, 2), -MC_EINVAL);
  CHECK_EQ(end(mc, -1), -MC_EINVAL);
}
