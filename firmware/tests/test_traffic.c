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

TEST(test_set_encoder_traffic, "DRV-10") {
  struct mc *mc = mock_open(&m, 1);
  m.logging = 1;
  call(mc, MSETENC, 0xFF9C01);
  TRAFFIC(R(0x005), R(0x00D), R(0x00F), R(0x005), R(0x00D), R(0x00F), /* where it was */
          R(0x005), W(0x00D, 0xFF), W(0x00F, 0x9C),                   /* port C: a new pair */
          R(0x005), R(0x00D), R(0x00F), R(0x005), R(0x00D), R(0x00F));
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
