/* SPDX-License-Identifier: Apache-2.0 */
/* Passes that read until the next SCLOCK has risen: what they may keep alive. §2.3.4, §5.3.6 */
#include "traffic.h"

static int64_t slow; /* how long the reads of each pass take longer */

/* A hook: the thirteenth access of a pass reads a card. */
static void read_slowly(struct mock *mock) {
  static int64_t pass, accesses;
  int64_t total = mc_stats_of(mock->memory)->total;
  accesses = total == pass ? accesses + 1 : 1;
  pass = total;
  if (mock->serving && accesses == 13) mock_run(mock, slow);
}

static struct mc *started(int mode0, int mode1, int divisor) {
  struct mc *mc = listening(1);
  for (int axis = 0; axis < 2; axis++) {
    CHANGE(mc, axis, par.mode = axis ? mode1 : mode0, par.clkdivisor = divisor);
  }
  CHECK_EQ(enable(mc), 0);
  DEMAND(mc, 90, 80);
  mock_run(&m, 40000);
  slow = 0;
  m.on_access = read_slowly;
  return mc;
}

/* The servo is dead: so is the heartbeat, and everybody hears why. */
TEST(test_a_servo_that_computes_no_more_stops_the_machine, "DRV-7 DRV-9") {
  static const unsigned intervals[] = {500, 1000, 2000, 10000};
  for (unsigned i = 0; i < 8; i++) {
    struct mc *mc = started(MD_VEL, i & 1 ? MD_OFF : MD_POS, i & 2 ? 3 : 1);
    unsigned us = intervals[i / 2];
    CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), 0);
    mock_run(&m, 3 * (int64_t)us);
    slow = us;
    int64_t from = m.now, beat = m.card[0].beat_until[0];
    while (mc_state_of(mc, 0)->errcode == 0) {
      CHECK(m.now - from < 25000 + 8 * (int64_t)us);
      mock_run(&m, 10);
      /* an SCLOCK before the next instant may write, a due pass that skipped may not */
      if (m.now - from > 5 * (int64_t)us && mc_is_enabled(mc)) {
        CHECK(m.card[0].beat_until[0] <= beat + 5 * (int64_t)us);
      }
    }
    CHECK(m.now - from >= 25000 - (int64_t)us);
    for (int axis = 0; axis < 2; axis++) {
      CHECK_EQ(mc_state_of(mc, axis)->errcode, axis << 8 | MERR_PANIC);
      CHECK_EQ(mock_dac(&m, axis), 0x800);
    }
    SAID("mc: PANIC: passes outlast SCLOCK, no servo sample for 25 ms\n");
    CHECK_EQ(m.signals[0], 1);
    CHECK_EQ(mc_stats_of(mc)->panics, 1);
    CHECK(!mc_is_enabled(mc));
    CHECK_EQ(m.card[0].b & 2, 0);
    mock_run(&m, 60000);
    CHECK(mock_panic(&m));
    slow = 0;
    mock_run(&m, 30000);
    CHECK_EQ(enable(mc), 0); /* and on it goes */
  }
}

/* Nothing is computed for axes that are off: MSETDAC's code is held as ever. */
TEST(test_axes_that_are_off_are_not_due, "DRV-9 DRV-12") {
  for (int one = 0; one < 2; one++) { /* nor are those beyond the joints */
    struct mc *mc = started(MD_OFF, one ? MD_VEL : MD_OFF, 1);
    if (one) call(mc, MSETNUMJOINTS, 1);
    call(mc, MSETDAC, 0xABC << 8);
    int passes = m.passes;
    slow = 2000;
    mock_run(&m, 200000);
    CHECK_EQ(mc_state_of(mc, 0)->errcode, 0);
    CHECK_EQ(mock_dac(&m, 0), 0xABC);
    CHECK(!mock_panic(&m));
    CHECK(mc_stats_of(mc)->overrun > 30);
    CHECK(m.passes <= passes + 1); /* no sample, no pass */
  }
}

static const char crowded[] =
    "mc: passes outlast SCLOCK, programs get no time: the interval is too short\n";

/* A port whose processor is too slow for its interval: MENABLE would not return there, since
 * nothing but passes runs. Every open tells it once. */
TEST(test_a_processor_that_is_too_slow_is_told_at_rest, "DRV-7") {
  struct mc *mc = listening(1);
  for (int n = 0; n < 2; n++) {
    m.compute_us = 1200;
    mock_run(&m, 80000);
    SAID(crowded);
    m.compute_us = 0;
    mock_run(&m, 10000);
    m.adaptor_dead = 1;
    CHECK_EQ(mc_interrupt(mc), 0);
    m.adaptor_dead = 0;
    said[sizeof crowded - 1] = 0; /* the bus error is told, too */
    m.compute_us = 1200;
    mock_run(&m, 200000);
    SAID(crowded);
    m.compute_us = 0;
    CHECK_EQ(mc_close(mc, 0), 0);
    said[0] = 0;
    CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
  }
  for (int n = 0; n < 10; n++) { /* programs had time in between */
    m.compute_us = 1200;
    mock_run(&m, 40000);
    m.compute_us = 0;
    mock_run(&m, 10000);
  }
  CHECK_EQ(said[0], 0);
  CHECK(mc_stats_of(mc)->overrun > 90);
  for (int n = 0; n < 2; n++) { /* a row ends with a close, though the next pass is of its number */
    CHECK_EQ(mc_close(mc, 0), 0);
    CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
    if (n > 0) mock_run(&m, 2000 * (int64_t)mc->overran + 100);
    m.compute_us = 2200;
    for (int passes = 0; passes < 20; passes++) mock_pass(&m);
    m.compute_us = 0;
  }
  CHECK_EQ(mc->crowded, 20);
}

/* A pass without a sample counts for axes that wait, and keeps the heartbeat while none is due. */
TEST(test_waiting_axes_wait_on_in_a_pass_without_a_sample, "DRV-7 DRV-9") {
  struct mc *mc = started(MD_VEL, MD_VEL, 4);
  int passes = 0;
  call(mc, MSETINTERVAL, 1000);
  mock_run(&m, 5000);
  do {
    mock_pass(&m);
    CHECK(++passes < 10);
  } while (m.computed_axes == 0);
  passes = 0;
  int64_t beat = m.card[0].beat_until[0];
  int before = mc_stats_of(mc)->overrun;
  slow = 1100;
  while (mc_stats_of(mc)->overrun == before) {
    CHECK(m.now < m.card[0].beat_until[0]);
    mock_run(&m, 10);
  }
  slow = 0;
  CHECK(m.card[0].beat_until[0] > beat + 500);
  do {
    mock_pass(&m);
    CHECK(++passes < 10);
  } while (m.computed_axes == 0);
  CHECK_EQ(passes, 3);
  CHECK_EQ(m.computed_axes, 2);
  CHECK_EQ(mc_stats_of(mc)->overrun, before + 1);
}
