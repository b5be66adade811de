/* SPDX-License-Identifier: Apache-2.0 */
/* Servo passes: what is sampled, published and written, early, late and broken. §4.3.6, §5.3 */
#include "traffic.h"

TEST(test_every_axis_gets_its_own_numbers, "DRV-4 DRV-7 DRV-11") {
  struct mc *mc = listening(3);
  int32_t values[6];
  for (int axis = 0; axis < 6; axis++) {
    set_mode_within_100(mc, axis, MD_TORQ);
    values[axis] = 100 * axis - 250;
    m.card[axis / 2].count[axis & 1] = (uint16_t)(1000 * axis - 2500);
    m.card[axis / 2].adc[axis & 1] = (uint16_t)(0xA51 + 0x111 * axis);
  }
  CHECK_EQ(enable(mc), 0);
  CHECK_EQ(mc_write(mc, 0, values, 24), 24);
  mock_pass(&m);
  mock_pass(&m);
  for (int n = 1; n <= 7; n++) { /* so many are asked for */
    struct mc_state state[7];
    memset(state, 0x5A, sizeof state);
    int got = mc_read(mc, 0, state, (size_t)n * 28);
    CHECK_EQ(got, 28 * (n < 6 ? n : 6));
    for (int axis = 0; 28 * axis < got; axis++) {
      CHECK_EQ(state[axis].encnow, 1000 * axis - 2500);
      CHECK_EQ(state[axis].adcvai, (0xA51 + 0x111 * axis) & 0xFFF);
      CHECK_EQ(state[axis].inow, values[axis]);
      CHECK_EQ(mock_dac(&m, axis), 0x800 + values[axis]);
    }
    CHECK_EQ(state[got / 28].encnow, 0x5A5A5A5A);
  }
  CHECK_EQ(m.computed_axes, 6);
}

TEST(test_late_converters_keep_the_old_values_of_their_card, "DRV-11") {
  struct mc *mc = listening(3);
  for (int axis = 0; axis < 6; axis++) m.card[axis / 2].adc[axis & 1] = (uint16_t)(100 + axis);
  mock_pass(&m);
  mock_pass(&m);
  for (int round = 1; round < 3; round++) {
    m.card[1].adc_until = INT64_MAX;
    for (int axis = 0; axis < 6; axis++) m.card[axis / 2].adc[axis & 1] = (uint16_t)(200 + axis);
    mock_pass(&m);
    mock_pass(&m);
    for (int axis = 0; axis < 6; axis++) {
      CHECK_EQ(mc_state_of(mc, axis)->adcvai, axis / 2 == 1 ? 100 + axis : 200 + axis);
    }
    SAID("mc: A/D time-out: card 1\n"); /* once each time it begins */
    said[0] = 0;
    m.card[1].adc_until = 0;
    mock_pass(&m);
    for (int axis = 0; axis < 6; axis++) CHECK_EQ(mc_state_of(mc, axis)->adcvai, 200 + axis);
    for (int axis = 2; axis < 4; axis++) m.card[1].adc[axis & 1] = (uint16_t)(100 + axis);
    mock_pass(&m);
    CHECK_EQ(said[0], 0);
  }
  CHECK_EQ(mc_close(mc, 0), 0);
  SAID("mc: close, A/D time-outs: 4\n");
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0); /* counted from the open on; no value yet: 0 */
  for (int card = 0; card < 3; card++) m.card[card].adc_until = INT64_MAX;
  mock_pass(&m);
  for (int axis = 0; axis < 6; axis++) CHECK_EQ(mc_state_of(mc, axis)->adcvai, 0);
  CHECK_EQ(mc_close(mc, 0), 0);
  CHECK(strstr(said, "mc: close, A/D time-outs: 3\n") != NULL);
}

/* They are asked for 40 times after the encoders; ready at the last question is ready. */
TEST(test_converters_are_waited_for_40_reads, "DRV-11") {
  for (int late = 38; late < 45; late++) {
    struct mc *mc = listening(1);
    mock_pass(&m);
    m.card[0].adc[0] = 777;
    m.latency_us = 20;
    m.logging = 1;
    int64_t first = m.now - (m.now - m.origin) % 2000 + 2000 + 20 + 11; /* port C after encoders */
    m.card[0].adc_until = first + late;
    mock_pass(&m);
    int polls = 0;
    for (int i = 0; i < m.used; i++) polls += m.log[i].offset == 0x005;
    polls--; /* the one before the encoders */
    int ready = mc_state_of(mc, 0)->adcvai == 777;
    CHECK(polls <= 41);
    CHECK_EQ(ready, said[0] == 0);
    CHECK_EQ(ready || polls == 41, 1);
    CHECK(late < 41 || !ready || polls == 41);
  }
}

/* These axes, the upper two upward and the others downward. */
static void move_all(unsigned axes, int by) {
  for (unsigned axis = 0; axis < 4; axis++) {
    if (axes >> axis & 1) m.card[axis / 2].count[axis & 1] = (uint16_t)(axis & 2 ? by : -by);
  }
}

/* An event on any axis, in any order, is told once, if anybody wants to hear it, shuts down once,
 * and stays with its axis. */
TEST(test_events_of_any_axis, "DRV-5 DRV-6") {
  for (unsigned crossed = 1; crossed < 16; crossed++) {
    for (int soft = 0; soft < 2; soft++) {
      struct mc *mc = listening(2);
      int lines = 0, say = (int)crossed & 3; /* M_VERBOSE, M_ERRORPRINT */
      int monitor = mc_open(mc, MC_O_RDONLY);
      for (int axis = 0; axis < 4; axis++) {
        set_mode_within_100(mc, axis, MD_POS | POSCHK | (soft ? SOFTERR : 0));
      }
      CHECK_EQ(enable(mc), 0);
      call(mc, MSETVERBOSITY, say);
      said[0] = 0;
      move_all(crossed, 101);
      mock_pass(&m);
      for (int axis = 0; axis < 4; axis++) {
        int flag = axis & 2 ? MERR_PHI : MERR_PLO;
        CHECK_EQ(mc_state_of(mc, axis)->errcode, crossed >> axis & 1 ? axis << 8 | flag : 0);
        char text[40] = "mc: axis 0";
        text[9] = (char)('0' + axis);
        strcat(text, axis & 2 ? ": high position limit\n" : ": low position limit\n");
        CHECK_EQ(strstr(said, text) != NULL, (crossed >> axis & 1) && say != 0);
      }
      move_all(crossed, soft ? 0 : 101); /* within the limits again: no event */
      mock_pass(&m);
      for (const char *at = said; (at = strchr(at, '\n')) != NULL; at++) lines++;
      CHECK_EQ(lines, say != 0 ? __builtin_popcount(crossed) : 0);
      for (int card = 0; card < 2; card++) CHECK_EQ(m.card[card].b, soft ? 7 : 5);
      CHECK_EQ(m.signals[0], 1);
      CHECK_EQ(m.signals[monitor], 0);
      mock_run(&m, 60000);
      CHECK_EQ(mock_panic(&m), !soft);
      CHECK_EQ(m.signals[0], 1);
      if (!soft) { /* an error pending does not forbid MENABLE; still outside is a crossing again */
        CHECK_EQ(enable(mc), -MC_EIO);
        CHECK_EQ(m.signals[0], 2);
        move_all(crossed, 0);
        CHECK_EQ(enable(mc), 0);
      } else { /* from one limit beyond the other */
        move_all(crossed, 101);
        mock_pass(&m);
        move_all(crossed, -101);
        mock_pass(&m);
        CHECK_EQ(m.signals[0], 3);
      }
      for (int axis = 0; axis < 4; axis++) { /* sticky */
        int flags = soft ? MERR_POSLIM : axis & 2 ? MERR_PHI : MERR_PLO;
        CHECK_EQ(errcode_of(&m, axis), crossed >> axis & 1 ? axis << 8 | flags : 0);
      }
    }
  }
}

/* However late the handler is: every rise of SCLOCK is either served or counted as missed. */
TEST(test_every_sclock_is_served_or_missed, "DRV-7") {
  for (int64_t latency = 1; latency < 2300; latency += latency > 960 && latency < 1060 ? 1 : 97) {
    struct mc *mc = listening(1);
    call(mc, MSETINTERVAL, 1000);
    CHECK_EQ(enable(mc), 0);
    mock_run(&m, 1000 - (m.now - m.origin) % 1000 + 500);
    CHECK_EQ(mc_ioctl(mc, 0, MZEROSTATS, NULL), 0);
    int passes = m.passes;
    m.latency_us = latency;
    mock_run(&m, 40000);
    m.latency_us = 0;
    mock_run(&m, 1500);
    const struct mc_stats *stats = mc_stats_of(mc);
    int served = m.passes - passes, discarded = stats->overrun;
    CHECK(served + stats->missed <= 42);
    CHECK(served + stats->missed + discarded >= 41);
    CHECK(stats->missed <= (latency < 990 ? 0 : 41));
    CHECK_EQ(mc_state_of(mc, 0)->errcode, 0);
    CHECK_EQ(stats->spurious, 0);
  }
}

TEST(test_pass_enabled, "DRV-7 SRV-1 DRV-11") {
  struct mc *mc = mock_open(&m, 1);
  CHECK_EQ(enable(mc), 0);
  mock_run(&m, 500);
  m.logging = 1;
  m.latency_us = 20;
  mock_pass(&m);
  TRAFFIC(R(0x409), W(0x409, 0x78), W(0x409, 0xF8), /* take and clear the latches */
          W(0x407, 0x80), R(0x405), R(0x405),       /* timer 2 at entry */
          R(0x005), R(0x009), R(0x00B), R(0x00D), R(0x00F), R(0x005), /* port C, encoders, port C */
          R(0x019), R(0x01B), R(0x01D),                               /* A/D */
          W(0x407, 0x80), R(0x405), R(0x405),                         /* timer 2 after the reads */
          W(0x011, 0x00), W(0x013, 0x08), W(0x015, 0x00), W(0x017, 0x08), W(0x407, 0x80), R(0x405),
          R(0x405)); /* and after the writes */
  CHECK_EQ(m.computes, m.passes);
  CHECK_EQ(m.computed_axes, 2);
}

TEST(test_pass_idle_writes_no_dac, "DRV-7 DRV-9") {
  struct mc *mc = mock_open(&m, 3);
  set_mode(mc, 0, MD_POS);
  DEMAND(mc, 40);
  m.logging = 1;
  mock_run(&m, 10000);
  CHECK_EQ(m.passes, 5);
  CHECK_EQ(mc_stats_of(mc)->total, 5);
  CHECK_EQ(mc_state_of(mc, 0)->error, 0); /* an axis at rest is not servoed */
  for (int i = 0; i < m.used; i++) CHECK(!m.log[i].write || m.log[i].offset >= 0x400);
  CHECK_EQ(mc_interrupt(mc), 0); /* nobody asked */
  CHECK_EQ(mc_stats_of(mc)->spurious, 1);
}

TEST(test_missed_are_counted_exactly, "DRV-7") {
  struct mc *mc = mock_open(&m, 1);
  call(mc, MSETINTERVAL, 1000);
  mock_run(&m, 5500);
  const struct mc_stats *stats = mc_stats_of(mc);
  CHECK_EQ(stats->missed, 0);
  int passes = m.passes;
  for (int late = 100; late < 3000; late += 100) { /* in both halves of the period */
    int missed = stats->missed;
    m.masked = 1;
    mock_run(&m, 1000 - (m.now - m.origin) % 1000 + late);
    m.masked = 0;
    mock_run(&m, 1000 - (m.now - m.origin) % 1000 - 1);
    CHECK_EQ(stats->missed - missed, late / 1000);
  }
  CHECK(m.passes > passes);
  CHECK_EQ(stats->overrun, 0);
  for (int late = 100; late < 1000; late += 100) { /* the first of a new SCLOCK */
    call(mc, MSETINTERVAL, 1000);
    m.latency_us = late;
    mock_pass(&m);
    m.latency_us = 0;
    passes = m.passes;
    mock_run(&m, 1000 - (m.now - m.origin) % 1000 + 100);
    CHECK_EQ(m.passes, passes + 1);
  }
  call(mc, MENABLE, 0); /* and in the PANIC that comes of it */
  int missed = stats->missed;
  m.masked = 1;
  mock_run(&m, 1000 - (m.now - m.origin) % 1000 + 79500);
  m.masked = 0;
  mock_run(&m, 1000);
  CHECK_EQ(errcode_of(&m, 0), MERR_PANIC);
  CHECK_EQ(stats->missed - missed, 79);
}
