/* SPDX-License-Identifier: Apache-2.0 */
/* What a process sees of /dev/mc: every call with its errors. §2.3, Table 2.3 */
#include "traffic.h"

/* Several SCLOCKs last 50 ms at most; a single one may last longer, and panics by design. */
TEST(test_a_servo_is_no_slower_than_its_heartbeats, "DRV-3 HB-2") {
  struct mc *mc = mock_open(&m, 1);
  struct mc_param par = param_of(mc, 1);
  unsigned us = 2500, got;
  par.clkdivisor = 25;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), -MC_EINVAL);
  CHECK(strstr(m.last_log, "axis 1") != NULL);
  CHECK_EQ(mc_ioctl(mc, 0, MGETINTERVAL, &got), 0);
  CHECK_EQ(got, 2000);
  us = 100;
  CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), 0);
  par.clkdivisor = 501;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), -MC_EINVAL);
  par.clkdivisor = 500;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
  par.clkdivisor = 1;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
  us = 60000;
  CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
}

TEST(test_state_follows_the_axis_while_off, "DRV-11 SRV-1") {
  struct mc *mc = mock_open(&m, 1);
  mock_run(&m, 5000);
  m.card[0].count[1] = 30;
  m.card[0].adc[1] = 100;
  mock_run(&m, 2000);
  const struct mc_state *state = mc_state_of(mc, 1);
  CHECK_EQ(state->encnow, 30);
  CHECK_EQ(state->fbnow, 30);
  CHECK_EQ(state->vel, 45);
  CHECK_EQ(state->adcvai, 100);
  CHECK_EQ(state->inow, 0);
}

TEST(test_set_dac, "DRV-12") {
  struct mc *mc = mock_open(&m, 1);
  int arg = 0xABC << 8 | 1, position;
  struct mc_param par = param_of(mc, 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSETDAC, &arg), -MC_EIO);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSETDAC, &arg), 0);
  mock_run(&m, 2100);
  CHECK_EQ(mock_dac(&m, 1), 0xABC);
  CHECK_EQ(mc_state_of(mc, 1)->inow, 0xABC - 2048);
  par.mode = MD_TORQ;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
  position = 0x123 << 8;
  CHECK_EQ(mc_ioctl(mc, 0, MSETDAC, &position), -MC_EINVAL);
  CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
  CHECK_EQ(mock_dac(&m, 1), 0x800);
}
