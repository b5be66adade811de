/* SPDX-License-Identifier: Apache-2.0 */
/* What the driver says and what it leaves unsaid, and which passes count as samples. §2.3.5 */
#include "traffic.h"

static void limits(struct mc *mc, int axis, int mode) {
  struct mc_param par = param_of(mc, axis);
  par.mode = mode;
  par.plo = -100;
  par.phi = 100;
  par.ilim = 50;
  par.ilimax = 3;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
}

/* Drives axis 1 over a limit and back; returns how many lines that made. */
static int cross(struct mc *mc, int count) {
  int before = m.logs;
  m.last_log[0] = 0;
  m.card[0].count[1] = (uint16_t)count;
  mock_run(&m, 2100);
  int lines = m.logs - before;
  m.card[0].count[1] = 0;
  mock_run(&m, 2100);
  CHECK_EQ(m.logs - before, lines);
  CHECK_EQ(mc_ioctl(mc, 0, MCLEARERROR, NULL), 0);
  return lines;
}

TEST(test_limits_are_told_when_asked_for, "DRV-2 DRV-6") {
  struct mc *mc = mock_open(&m, 2);
  limits(mc, 1, MD_POS | POSCHK | SOFTERR);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  for (int say = 0; say < 4; say++) {
    call(mc, MSETVERBOSITY, say);
    CHECK_EQ(cross(mc, 101), say != 0);
    CHECK(strcmp(m.last_log, say ? "mc: axis 1: high position limit" : "") == 0);
    CHECK_EQ(cross(mc, -101), say != 0);
    CHECK(strcmp(m.last_log, say ? "mc: axis 1: low position limit" : "") == 0);
  }
}

TEST(test_overload_is_told, "DRV-2 SRV-4") {
  struct mc *mc = mock_open(&m, 1);
  limits(mc, 1, MD_TORQ | SOFTERR);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  call(mc, MSETVERBOSITY, M_ERRORPRINT);
  int before = m.logs;
  DEMAND(mc, 0, 60);
  mock_run(&m, 7000);
  CHECK_EQ(m.logs, before);
  mock_run(&m, 2100);
  CHECK_EQ(m.logs, before + 1);
  CHECK_EQ(strcmp(m.last_log, "mc: axis 1: sustained current overload"), 0);
}

TEST(test_the_verbose_hear_of_the_normal_course, "DRV-2") {
  for (int say = 0; say < 4; say++) {
    struct mc *mc = mock_open(&m, 2);
    int before = m.logs, lines = (say & M_VERBOSE) != 0;
    call(mc, MSETVERBOSITY, say);
    CHECK_EQ(m.logs - before, lines);
    CHECK(!lines || strcmp(m.last_log, "mc: cards: 2") == 0);
    CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
    CHECK_EQ(m.logs - before, 2 * lines);
    CHECK(!lines || strcmp(m.last_log, "mc: enabled, axes: 4") == 0);
    CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
    CHECK_EQ(m.logs - before, 3 * lines);
    CHECK(!lines || strcmp(m.last_log, "mc: stopped") == 0);
  }
}

TEST(test_every_axis_is_watched_for_its_heartbeat, "DRV-7 DRV-12") {
  for (int axis = 0; axis < 4; axis++) {
    struct mc *mc = mock_open(&m, 2);
    CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
    mock_run(&m, 10000);
    int passes = m.passes;
    m.card[axis / 2].enabled[axis % 2] = 0;
    m.card[axis / 2].beat_until[axis % 2] = 0;
    mock_run(&m, 2100);
    CHECK_EQ(mc_state_of(mc, 0)->errcode, MERR_PANIC);
    CHECK_EQ(m.passes, passes); /* the pass that finds it is no sample */
    CHECK_EQ(m.last_log[(int)strlen("mc: PANIC: axis ")], '0' + axis);
    CHECK_EQ(m.card[axis / 2].beat_until[axis % 2], 0); /* and is not started again */
  }
}

TEST(test_passes_that_are_samples, "DRV-7") {
  struct mc *mc = mock_open(&m, 1);
  mock_run(&m, 2000 - (m.now - m.origin) % 2000 + 1000);
  int passes = m.passes;
  int total = mc_stats_of(mc)->total;
  mock_run(&m, 20000); /* idle too: read() follows the axes */
  CHECK_EQ(m.passes - passes, 10);
  CHECK_EQ(mc_stats_of(mc)->total - total, 10);
  CHECK_EQ(mc_interrupt(mc), 0); /* nobody asked */
  CHECK_EQ(mc_stats_of(mc)->spurious, 1);
}
