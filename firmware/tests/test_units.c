/* SPDX-License-Identifier: Apache-2.0 */
/* The driver's own helpers, one by one: registers, timer arithmetic, text, counters. §4.3, §5.3 */
#include "traffic.h"

/* --- registers ------------------------------------------------------------------------------- */

static int bad_reads, bad_writes, lists;

static enum mc_bus_result faulty_read(void *ctx, uint16_t offset, uint8_t *value) {
  const struct mock *mock = ctx;
  if (bad_reads == 0) return mock->bus.read8(ctx, offset, value);
  *value = 0x12; /* unspecified */
  return MC_BUS_ERROR;
}

static enum mc_bus_result faulty_write(void *ctx, uint16_t offset, uint8_t value) {
  const struct mock *mock = ctx;
  return bad_writes ? MC_BUS_TIMEOUT : mock->bus.write8(ctx, offset, value);
}

static enum mc_bus_result read_list(void *ctx, const uint16_t *offsets, uint8_t *values,
                                    unsigned n) {
  lists++;
  for (unsigned i = 0; i < n; i++) {
    if (faulty_read(ctx, offsets[i], &values[i]) != MC_BUS_OK) values[i] = 0xFF;
  }
  return bad_reads ? MC_BUS_ERROR : MC_BUS_OK;
}

static enum mc_bus_result write_list(void *ctx, const uint16_t *offsets, const uint8_t *values,
                                     unsigned n) {
  lists++;
  for (unsigned i = 0; i < n; i++) (void)faulty_write(ctx, offsets[i], values[i]);
  return bad_writes ? MC_BUS_TIMEOUT : MC_BUS_OK;
}

static struct mc *faulty(int with_lists) {
  struct mc *mc = mock_open(&m, 2);
  bad_reads = bad_writes = lists = 0;
  mc->bus.read8 = faulty_read;
  mc->bus.write8 = faulty_write;
  mc->bus.read_list = with_lists ? read_list : NULL;
  mc->bus.write_list = with_lists ? write_list : NULL;
  return mc;
}

TEST(test_failed_accesses_are_noted, "DRV-3 DRV-7") {
  static const uint16_t list[] = {0x049, 0x04B};
  static const uint8_t zero[2] = {0};
  for (int with_lists = 0; with_lists < 2; with_lists++) {
    struct mc *mc = faulty(with_lists);
    uint8_t values[2] = {0};
    mc->fault = 0;
    CHECK_EQ(hw_get(mc, 0x409), 0x98 | m.sclock_latch << 5);
    hw_get_list(mc, list, values, 2);
    hw_put_list(mc, list, zero, 2);
    CHECK_EQ(mc->fault, 0);
    bad_reads = bad_writes = 1;
    CHECK_EQ(hw_get(mc, 0x409), 0xFF);
    CHECK_EQ(mc->fault, 1);
    mc->fault = 0;
    hw_put(mc, 0x409, 0xB8);
    CHECK_EQ(mc->fault, 1);
    mc->fault = 0;
    hw_get_list(mc, list, values, 2);
    CHECK_EQ(mc->fault, 1);
    CHECK(values[0] == 0xFF && values[1] == 0xFF);
    mc->fault = 0;
    hw_put_list(mc, list, zero, 2);
    CHECK_EQ(mc->fault, 1);
  }
}

static int traffic_of_a_pass(int with_lists, struct mock_access *log) {
  struct mc *mc = faulty(with_lists);
  CHECK_EQ(enable(mc), 0);
  m.latency_us = 20;
  m.logging = 1;
  lists = 0;
  mock_run(&m, 2000);
  CHECK_EQ(lists, with_lists ? 3 : 0);
  memcpy(log, m.log, sizeof m.log);
  int used = m.used;
  return used;
}

TEST(test_lists_are_the_same_accesses, "DRV-7 DRV-11") {
  static struct mock_access one[MOCK_LOG], other[MOCK_LOG];
  int n = traffic_of_a_pass(0, one);
  CHECK_EQ(n, traffic_of_a_pass(1, other));
  CHECK(memcmp(one, other, (size_t)n * sizeof one[0]) == 0);
}

TEST(test_requests_report_a_dead_adaptor, "DRV-3 DRV-6") {
  for (int kind = 0; kind < 4; kind++) { /* reads or writes fail, with lists or without */
    struct mc *mc = faulty(kind & 1);
    unsigned us = 1000, where = 1, light = 0x100, on = 1;
    int axis = 0;
    CHECK_EQ(enable(mc), 0);
    bad_reads = kind & 2;
    bad_writes = !bad_reads;
    CHECK_EQ(mc_ioctl(mc, 0, MSETENC, &where), -MC_EIO);
    call(mc, MGETINTERVAL, 0); /* needs no hardware */
    if (bad_writes) {
      CHECK_EQ(mc_ioctl(mc, 0, MSETLED, &light), -MC_EIO);
      CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), -MC_EIO);
      CHECK_EQ(mc_ioctl(mc, 0, MDACMODE, &on), -MC_EIO);
    }
    CHECK_EQ(mc_ioctl(mc, 0, MCALIB, &axis), -MC_EIO);
    CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), -MC_EIO);
    CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0); /* it is stopped, whatever the bus does */
    bad_reads = bad_writes = 0;
    CHECK_EQ(mc_ioctl(mc, 0, MSETENC, &where), 0);
  }
}

static int wrong_at;
static uint8_t wrong;

/* Port A of card 1 reads wrong once. */
static enum mc_bus_result doubtful_read(void *ctx, uint16_t offset, uint8_t *value) {
  enum mc_bus_result result = m.bus.read8(ctx, offset, value);
  if (offset == 0x041 && --wrong_at == 0) *value ^= wrong;
  return result;
}

TEST(test_a_card_answers_if_both_patterns_come_back, "DRV-9 DRV-12") {
  struct mc *mc = mock_open(&m, 2);
  mc->bus.read8 = doubtful_read;
  for (int at = 1; at < 4; at++) {
    for (unsigned bit = 0; bit < 8; bit++) {
      wrong_at = at;
      wrong = (uint8_t)(1u << bit);
      CHECK_EQ(hw_answers(mc, 1), at > 2);
      CHECK_EQ(m.card[1].a, 5); /* the lights are as they were */
    }
  }
  wrong_at = 2; /* behind the first look of MENABLE */
  CHECK_EQ(enable(mc), -MC_EIO);
  wrong_at = 0;
  CHECK_EQ(hw_answers(mc, 0), 1);
}

/* --- timers ---------------------------------------------------------------------------------- */

TEST(test_interval_arithmetic, "DRV-3") {
  struct mc *mc = mock_open(&m, 1);
  static const uint32_t clocks[] = {8000000, 4000000, 2000000, 1000000};
  for (unsigned c = 0; c < 4; c++) {
    uint32_t per_us = clocks[c] / 1000000;
    mc->config.sysclk_hz = clocks[c];
    for (uint32_t us = 90; us < 4000000; us += us < 3000 ? 1 : us / 997) {
      uint64_t want = (uint64_t)us * per_us, best = UINT64_MAX, of_best = 0;
      uint64_t first = (want + 65535) / 65536 < 2 ? 2 : (want + 65535) / 65536;
      for (uint64_t n = first; n < first + 64; n++) { /* the nearest of 64, and the first such */
        uint64_t k = (want + n / 2) / n, off = k * n > want ? k * n - want : want - k * n;
        if (k < 2 || k > 65536 || off >= best) continue;
        best = off;
        of_best = n;
      }
      uint32_t n0 = 0, n1 = 0;
      int good = us >= 100 && best <= want / 1000; /* a thousandth off, no more */
      CHECK_EQ(timer_counts(mc, us, &n0, &n1), good ? 0 : -MC_EINVAL);
      if (!good) continue;
      uint64_t made = (uint64_t)n0 * n1;
      CHECK_EQ(n1, of_best);
      CHECK_EQ(made > want ? made - want : want - made, best);
      mc->n0 = n0;
      mc->n1 = n1;
      CHECK_EQ(timer_interval_us(mc), (made * 2 + per_us) / (2 * per_us));
    }
    uint64_t most = (uint64_t)65536 * 65536;
    uint32_t n0 = 0, n1 = 0, us = (uint32_t)(most / per_us);
    if (per_us == 1) continue; /* more than an unsigned says */
    CHECK_EQ(timer_counts(mc, us, &n0, &n1), 0);
    CHECK(n0 == 65536 && n1 == 65536);
    CHECK_EQ(timer_counts(mc, us + 1, &n0, &n1), -MC_EINVAL);
    CHECK_EQ(timer_counts(mc, UINT32_MAX, &n0, &n1), -MC_EINVAL);
  }
}

/* --- text, counters -------------------------------------------------------------------------- */

TEST(test_lines_for_the_console, "DRV-2") {
  struct mc *mc = mock_open(&m, 1);
  static const struct {
    int number;
    const char *line;
  } cases[] = {{-1, "mc: a b"},          {0, "mc: a 0 b"},
               {1, "mc: a 1 b"},         {9, "mc: a 9 b"},
               {10, "mc: a 10 b"},       {11, "mc: a 11 b"},
               {19, "mc: a 19 b"},       {100, "mc: a 100 b"},
               {98765, "mc: a 98765 b"}, {INT32_MAX, "mc: a 2147483647 b"}};
  for (unsigned i = 0; i < COUNT(cases); i++) {
    text_log(mc, "a", cases[i].number, " b");
    CHECK_EQ(strcmp(m.last_log, cases[i].line), 0);
  }
  char longer[120];
  for (unsigned n = 60; n < sizeof longer; n++) { /* 79 characters fit */
    memset(longer, 'x', n);
    longer[n] = 0;
    for (int number = -1; number < 2; number += 2) {
      memset(m.last_log, 0, sizeof m.last_log);
      text_log(mc, longer, number, "yz");
      char want[200] = "mc: ";
      strcat(want, longer);
      strcat(want, number < 0 ? "yz" : " 1yz");
      want[79] = 0;
      CHECK_EQ(strcmp(m.last_log, want), 0);
    }
  }
  text_log(mc, "\x81\xFF", -1, ""); /* any byte but the last is text */
  CHECK_EQ(strcmp(m.last_log, "mc: \x81\xFF"), 0);
}

TEST(test_counters_stop_at_the_largest, "DRV-3") {
  static const unsigned from[] = {0, 1, 3, 5, INT32_MAX - 2, INT32_MAX - 1, INT32_MAX};
  static const unsigned by[] = {0, 1, 7, INT32_MAX, 0x80000000u, UINT32_MAX};
  for (unsigned i = 0; i < COUNT(from) * COUNT(by); i++) {
    unsigned begun = from[i / COUNT(by)], more = by[i % COUNT(by)];
    int counter = (int)begun;
    mc_count(&counter, more);
    CHECK_EQ(counter, begun < INT32_MAX - more && more < INT32_MAX ? begun + more : INT32_MAX);
  }
}
