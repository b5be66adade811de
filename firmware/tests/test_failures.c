/* SPDX-License-Identifier: Apache-2.0 */
/* Hardware that fails behind the driver's back, on the mock machine. §2.3.4, §5.3.6 */
#include "traffic.h"

static struct mc *enabled(int mode) {
  struct mc *mc = mock_open(&m, 1);
  set_mode(mc, 0, mode);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  return mc;
}

TEST(test_stop_after_sysreset_starts_no_heartbeat, "DRV-9 PAN-2") {
  struct mc *mc = enabled(MD_OFF);
  mock_run(&m, 10000);
  m.pccsr = 0; /* interrupts are off: no pass comes, heartbeats end */
  mock_run(&m, 60000);
  CHECK(mock_panic(&m));
  CHECK_EQ(m.releases, 1);
  CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
  CHECK(mock_panic(&m));
  CHECK_EQ(m.releases, 1); /* the brakes did not open once more */
  CHECK_EQ(m.card[0].b & 2, 0);
  CHECK_EQ(m.card[0].dac_high[0], 8);
}

TEST(test_failed_dac_write_is_repaired_or_ends_in_panic, "DRV-7 DRV-9") {
  struct mc *mc = enabled(MD_TORQ);
  DEMAND(mc, 300);
  m.dac_errors = 2;
  mock_run(&m, 2100);
  CHECK_EQ(m.dac_errors, 0);
  CHECK_EQ(mock_dac(&m, 0), 0x800);
  mock_run(&m, 2000);
  CHECK_EQ(mock_dac(&m, 0), 0x800 + 300);
  CHECK_EQ(mc_state_of(mc, 0)->errcode, 0);
  m.dac_errors = 1000000; /* for good: the heartbeats die, the next pass finds that */
  mock_run(&m, 54000);
  CHECK_EQ(mc_state_of(mc, 0)->errcode, MERR_PANIC);
  CHECK(mock_panic(&m));
  CHECK_EQ(m.card[0].b & 2, 0); /* and isolates the joints */
}

/* Of several cards the first that does not answer is named, and the others are left alone. */
TEST(test_enable_stops_at_the_first_card_that_is_silent, "DRV-9 DRV-12") {
  struct mc *mc = mock_open(&m, 3);
  for (int first = 0; first < 3; first++) {
    for (int card = 0; card < 3; card++) m.card[card].present = card < first;
    m.logging = 1;
    m.used = 0;
    CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), -MC_EIO);
    CHECK_EQ(m.last_log[(int)strlen("mc: enable: card ")], '0' + first);
    for (int i = 0; i < m.used; i++) CHECK(m.log[i].offset < (first + 1) << 6);
  }
}

static enum mc_bus_result (*good_read)(void *ctx, uint16_t offset, uint8_t *value);
static int countdown;

static enum mc_bus_result fail_once(void *ctx, uint16_t offset, uint8_t *value) {
  enum mc_bus_result result = good_read(ctx, offset, value);
  if (countdown-- != 0) return result;
  *value = 0xFF;
  return MC_BUS_ERROR;
}

/* Whichever read of a pass fails: one PANIC, no SCLOCK that was not. */
TEST(test_a_read_that_failed_is_one_panic, "DRV-7 DRV-9") {
  for (int which = 0; which < 15; which++) {
    struct mc *mc = enabled(MD_POS);
    mock_run(&m, 2000 - (m.now - m.origin) % 2000 + 1000);
    good_read = mc->bus.read8;
    mc->bus.read8 = fail_once;
    countdown = which;
    mock_run(&m, 2000);
    CHECK(countdown < 0);
    CHECK_EQ(mc_stats_of(mc)->panics, 1);
    mock_run(&m, 100000);
    CHECK_EQ(mc_stats_of(mc)->panics, 1);
    CHECK_EQ(mc_stats_of(mc)->missed, which == 0); /* PCCSR: nobody knows of the SCLOCK */
  }
}
