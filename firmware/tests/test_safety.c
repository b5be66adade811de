/* SPDX-License-Identifier: Apache-2.0 */
/* Enable, stop, errors, PANIC and calibration on the mock machine. §2.3.4, §5.3.4, §5.3.6 */
#include "traffic.h"

/* Brakes may open only when the servo holds: every D/A is that of a servo pass. */
static void brakes_need_a_servo(struct mock *mock) {
  if (!mock_panic(mock)) CHECK(mock->computes > 0 && (mock->card[0].b & 2) != 0);
}

TEST(test_enable_opens_brakes_with_the_servo, "DRV-9") {
  struct mc *mc = mock_open(&m, 3);
  m.card[1].enabled[0] = 0;
  m.card[0].count[0] = 1234;
  m.computes = 0;
  set_mode_within_100(mc, 0, MD_POS);
  m.on_access = brakes_need_a_servo;
  CHECK(mock_panic(&m));
  call(mc, MENABLE, 0);
  CHECK(!mock_panic(&m));
  CHECK_EQ(m.releases, 1);
  CHECK_EQ(mc_setpoint(mc, 0), 1234); /* holds where it is */
  CHECK_EQ(mock_dac(&m, 0), 0x800);
  CHECK_EQ(m.card[2].b, 7);
  CHECK_EQ(m.pccsr, 0xF8);
}

TEST(test_limit_without_softerr_shuts_down, "DRV-5 DRV-6") {
  struct mc *mc = mock_open(&m, 1);
  set_mode_within_100(mc, 0, MD_POS | POSCHK);
  int monitor = mc_open(mc, MC_O_RDONLY);
  call(mc, MENABLE, 0);
  m.card[0].count[0] = 101;
  mock_run(&m, 2100);
  CHECK_EQ(errcode_of(&m, 0), MERR_PHI);
  CHECK_EQ(m.signals[0], 1);
  CHECK_EQ(m.signals[monitor], 0);
  CHECK_EQ(mock_dac(&m, 0), 0x800);
  mock_run(&m, 60000);
  CHECK(mock_panic(&m));
  CHECK_EQ(m.signals[0], 1);
  CHECK_EQ(errcode_of(&m, 1), 0);
  /* An error pending does not forbid it; but the axis is still outside: a crossing again. */
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), -MC_EIO);
  CHECK_EQ(m.signals[0], 2);
  m.card[0].count[0] = 99;
  call(mc, MENABLE, 0);
  CHECK_EQ(errcode_of(&m, 0), MERR_PHI); /* sticky */
}

TEST(test_softerr_reports_crossings_only, "DRV-5 DRV-6") {
  struct mc *mc = mock_open(&m, 1);
  struct mc_state state[2];
  set_mode_within_100(mc, 1, MD_POS | POSCHK | SOFTERR);
  call(mc, MENABLE, 0);
  m.card[0].count[1] = (uint16_t)-101;
  mock_run(&m, 20000);
  CHECK_EQ(errcode_of(&m, 1), 0x100 | MERR_PLO);
  CHECK_EQ(m.signals[0], 1);
  CHECK(!mock_panic(&m));
  CHECK_EQ(mc_read(mc, 0, state, sizeof state), 56);
  m.card[0].count[1] = 101; /* between read and clear */
  mock_run(&m, 2100);
  CHECK_EQ(m.signals[0], 2);
  CHECK_EQ(mc_ioctl(mc, 0, MCLEARERROR, NULL), 0);
  CHECK_EQ(errcode_of(&m, 1), 0x100 | MERR_PHI);
  CHECK_EQ(m.signals[0], 3);
  CHECK_EQ(mc_read(mc, 0, state, sizeof state), 56);
  CHECK_EQ(mc_ioctl(mc, 0, MCLEARERROR, NULL), 0);
  CHECK_EQ(errcode_of(&m, 1), 0);
}

TEST(test_overload_shuts_down, "SRV-4 DRV-6") {
  struct mc *mc = mock_open(&m, 1);
  struct mc_param par = param_of(mc, 0);
  par.mode = MD_TORQ;
  par.ilimax = 10;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
  call(mc, MENABLE, 0);
  DEMAND(mc, 1025);
  mock_run(&m, 20000);
  CHECK_EQ(errcode_of(&m, 0), 0);
  mock_run(&m, 4000);
  CHECK_EQ(errcode_of(&m, 0), MERR_ILIM);
  CHECK_EQ(mock_dac(&m, 0), 0x800);
}

TEST(test_lost_card, "DRV-7 DRV-12") {
  struct mc *mc = mock_open(&m, 2);
  int32_t before;
  call(mc, MENABLE, 0);
  mock_run(&m, 10000);
  before = mc_state_of(mc, 2)->encnow;
  m.card[1].present = 0;
  mock_run(&m, 2100);
  CHECK_EQ(errcode_of(&m, 0), MERR_PANIC);
  CHECK_EQ(mc_state_of(mc, 2)->encnow, before); /* the sample of 0xFFs is discarded */
  CHECK(strstr(m.last_log, "card 1 does not answer") != NULL);
}

TEST(test_slow_interval_panics, "DRV-9") {
  struct mc *mc = mock_open(&m, 1);
  call(mc, MSETINTERVAL, 80000);
  call(mc, MENABLE, 0);
  mock_run(&m, 80000);
  CHECK_EQ(errcode_of(&m, 0), MERR_PANIC);
}

TEST(test_missed_are_counted_in_a_panic_too, "DRV-7") {
  struct mc *mc = mock_open(&m, 1);
  call(mc, MENABLE, 0);
  mock_run(&m, 2000 - (m.now - m.origin) % 2000 + 1000);
  m.masked = 1; /* the host stands still for 40 SCLOCKs */
  mock_run(&m, 80000);
  m.masked = 0;
  mock_run(&m, 1000);
  CHECK_EQ(errcode_of(&m, 0), MERR_PANIC);
  CHECK_EQ(mc_stats_of(mc)->missed, 39);
}
