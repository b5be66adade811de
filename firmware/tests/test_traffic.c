/* SPDX-License-Identifier: Apache-2.0 */
/* The register traffic of a servo pass, of the scan and of the timers, access by access. §4.3.6 */
#include "traffic.h"

TEST(test_pass_enabled, "DRV-7 SRV-1 DRV-11") {
  struct mc *mc = mock_open(&m, 1);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  mock_run(&m, 500);
  m.logging = 1;
  m.latency_us = 20;
  mock_pass(&m);
  static const struct mock_access want[] = {
      R(0x409),       W(0x409, 0x78), W(0x409, 0xF8), /* take and clear the latches */
      W(0x407, 0x80), R(0x405),       R(0x405),       /* timer 2 at entry */
      R(0x005),       R(0x009),       R(0x00B),       R(0x00D),
      R(0x00F),       R(0x005),                 /* port C, encoders, port C */
      R(0x019),       R(0x01B),       R(0x01D), /* A/D */
      W(0x407, 0x80), R(0x405),       R(0x405), /* timer 2 after the reads */
      W(0x011, 0x00), W(0x013, 0x08), W(0x015, 0x00), W(0x017, 0x08),
      W(0x407, 0x80), R(0x405),       R(0x405)}; /* and after the writes */
  EXPECT(&m, want);
  CHECK_EQ(m.computes, m.passes);
  CHECK_EQ(m.computed_axes, 2);
}

TEST(test_pass_idle_writes_no_dac, "DRV-7 DRV-9") {
  mock_open(&m, 3);
  m.logging = 1;
  mock_run(&m, 10000);
  CHECK_EQ(m.passes, 5);
  for (int i = 0; i < m.used; i++) CHECK(!m.log[i].write || m.log[i].offset >= 0x400);
}

TEST(test_pass_length, "DRV-7") {
  struct mc *mc = mock_open(&m, 3);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  mock_run(&m, 500);
  m.logging = 1;
  m.latency_us = 20;
  mock_pass(&m);
  CHECK_EQ(m.used, 3 + 3 * 3 + 3 * 13);
}

TEST(test_scan, "DRV-2") {
  struct mc *mc = mock_start(&m, 0);
  m.card[3].present = m.card[9].present = 1;
  m.logging = 1;
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
  CHECK_EQ(mc_joints(mc), 4);
  int cards = 0;
  CHECK_EQ(mc_ioctl(mc, 0, MGETNUMCARDS, &cards), 0);
  CHECK_EQ(cards, 2);
  CHECK_EQ(m.card[3].mode_word, 0x89);
  CHECK_EQ(m.card[9].a, 5); /* mode 5 of the encoders */
  CHECK_EQ(m.card[9].b, 5); /* joints' encoders, SCLOCK; D/A looped back */
  CHECK_EQ(m.log[0].offset, MMCS_PCCSR);
  CHECK_EQ(m.log[0].value, 0x18);
  CHECK_EQ(m.vector, 0x40);
  CHECK_EQ(m.pccsr, 0xB8);
  m.used = 0;
  CHECK_EQ(mc_open(mc, MC_O_RDONLY), 1); /* a later open touches nothing */
  CHECK_EQ(m.used, 0);
}

TEST(test_timer_programming, "DRV-3") {
  struct mc *mc = mock_open(&m, 1);
  m.logging = 1;
  call(mc, MSETINTERVAL, 1000);
  static const struct mock_access want[] = {
      W(0x409, 0x38),                                 /* latches held clear */
      W(0x407, 0x70),                                 /* timer 1: SCLOCK low */
      W(0x407, 0xB4), W(0x405, 0x00), W(0x405, 0x00), /* timer 2: mode 2, 65536 */
      W(0x407, 0x34), W(0x401, 0xA0), W(0x401, 0x0F), /* timer 0: 4000 */
      W(0x407, 0x74), W(0x403, 0x02), W(0x403, 0x00), /* timer 1: 2 */
      W(0x409, 0xB8)};
  EXPECT(&m, want);
}

TEST(test_intervals, "DRV-3") {
  struct mc *mc = mock_open(&m, 1);
  static const unsigned good[] = {100,   101,   997,   1000,    2000,
                                  16384, 16385, 50000, 1000003, 500000000};
  for (unsigned i = 0; i < sizeof good / sizeof good[0]; i++) {
    unsigned us = good[i], got = 0;
    CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), 0);
    CHECK_EQ(mc_ioctl(mc, 0, MGETINTERVAL, &got), 0);
    CHECK(got >= us - us / 1000 && got <= us + us / 1000);
  }
  static const unsigned bad[] = {0, 1, 99, 600000000, 0xFFFFFFFF};
  unsigned kept = 0;
  CHECK_EQ(mc_ioctl(mc, 0, MGETINTERVAL, &kept), 0);
  for (unsigned i = 0; i < sizeof bad / sizeof bad[0]; i++) {
    unsigned us = bad[i], got = 0;
    CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), -MC_EINVAL);
    CHECK_EQ(mc_ioctl(mc, 0, MGETINTERVAL, &got), 0);
    CHECK_EQ(got, kept);
  }
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
}

TEST(test_modes_act_on_hardware, "DRV-12") {
  struct mc *mc = mock_open(&m, 2);
  int bad = 4;
  call(mc, MDACMODE, 1);
  CHECK_EQ(m.card[0].b, 0x0D);
  call(mc, MSETLED, 0x102);
  CHECK_EQ(m.card[1].a, 0x0D);
  call(mc, MDIAGMODE, M_ENDIAG);
  CHECK_EQ(m.card[1].b, 0x0C);
  CHECK_EQ(mc_ioctl(mc, 0, MDIAGMODE, &bad), -MC_EINVAL);
  CHECK_EQ(m.card[1].b, 0x0C);
}

TEST(test_set_encoder_traffic, "DRV-10") {
  struct mc *mc = mock_open(&m, 1);
  m.logging = 1;
  call(mc, MSETENC, 0xFF9C01);
  static const struct mock_access want[] = {
      R(0x005), R(0x00D),       R(0x00F),       R(0x005), R(0x00D), R(0x00F), /* where it was */
      R(0x005), W(0x00D, 0xFF), W(0x00F, 0x9C), /* port C: a new pair */
      R(0x005), R(0x00D),       R(0x00F),       R(0x005), R(0x00D), R(0x00F)};
  EXPECT(&m, want);
  mock_run(&m, 4100);
  CHECK_EQ(mc_state_of(mc, 1)->encnow, -100);
  m.card[0].count[1] = (uint16_t)(m.card[0].count[1] - 32700); /* through the wrap */
  mock_run(&m, 2000);
  m.card[0].count[1] = (uint16_t)(m.card[0].count[1] - 32700);
  mock_run(&m, 2000);
  CHECK_EQ(mc_state_of(mc, 1)->encnow, -100 - 65400);
}

TEST(test_new_interval_at_any_phase_misses_nothing, "DRV-7") {
  struct mc *mc = mock_open(&m, 1);
  for (int phase = 0; phase < 2000; phase += 37) {
    mock_run(&m, 20000 + phase);
    call(mc, MSETINTERVAL, 2000);
    mock_run(&m, 8000);
    CHECK_EQ(mc_stats_of(mc)->missed, 0);
  }
}

MAIN
