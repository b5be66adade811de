/* SPDX-License-Identifier: Apache-2.0 */
/* Enable, stop and PANIC in detail: accesses, waits and messages, each in its order. §2.3.4, §5.3.6
 */
#include "traffic.h"

static uint32_t waited[200];
static int waits;
static int (*meanwhile)(struct mc *mc); /* what another process does during a wait */
static int answer;

static void wait_us(void *ctx, uint32_t us) {
  CHECK(!m.masked); /* interrupts may come */
  CHECK(waits < (int)(COUNT(waited)));
  waited[waits++] = us;
  if (meanwhile) answer = meanwhile(m.memory);
  mock_run(ctx, us);
}

static struct mc *opened(int cards) {
  struct mc *mc = listening(cards);
  mc->os.delay_us = wait_us;
  waits = 0;
  meanwhile = NULL;
  answer = 0;
  return mc;
}

TEST(test_enable_traffic, "DRV-9 PAN-2") {
  struct mc *mc = opened(2);
  call(mc, MDACMODE, 1);
  mock_run(&m, 2100);
  m.logging = 1;
  m.on_access = traffic_of_process;
  CHECK_EQ(enable(mc), 0);
  TRAFFIC(R(0x001), R(0x003), W(0x001, 0x1D), R(0x001), W(0x001, 0x05),
          R(0x001), /* card 0 answers */
          R(0x041), R(0x043), W(0x041, 0x1D), R(0x041), W(0x041, 0x05), R(0x041), W(0x003, 0x05),
          W(0x043, 0x05),                                                 /* outputs act at once */
          W(0x013, 0x08), W(0x017, 0x08), W(0x053, 0x08), W(0x057, 0x08), /* 0 V, no heartbeat */
          W(0x003, 0x07), W(0x043, 0x07),                                 /* joints connected */
          W(0x003, 0x0F), W(0x043, 0x0F),         /* double-buffered as asked */
          R(0x005), R(0x005), R(0x045), R(0x045), /* all heartbeats live */
          W(0x409, 0xF8));                        /* PANIC may interrupt */
  CHECK_EQ(waited[0], 2000);                      /* the relay */
  CHECK(waits >= 2 && waits <= 4);
  for (int i = 1; i < waits; i++) CHECK_EQ(waited[i], 1000);
  CHECK_EQ(m.masked, 0);
  SAID("");
  m.used = 0;
  CHECK_EQ(enable(mc), 0); /* once more: looks whether all answer, and starts afresh */
  CHECK_EQ(m.used, 12);
  CHECK_EQ(m.masked, 0);
  CHECK_EQ(m.releases, 1);
}

/* The low byte is written only where the heartbeat lives: a dead one must not start again. */
TEST(test_stop_traffic, "DRV-6 DRV-9 PAN-2") {
  for (unsigned live = 0; live < 16; live++) {
    struct mc *mc = opened(2);
    call(mc, MDACMODE, 1);
    CHECK_EQ(enable(mc), 0);
    mock_run(&m, 2100);
    for (unsigned axis = 0; axis < 4; axis++) {
      if ((live >> axis & 1) == 0) m.card[axis / 2].beat_until[axis & 1] = 0;
    }
    m.logging = 1;
    CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
    struct mock_access want[40];
    int n = 0;
    want[n++] = (struct mock_access)W(0x409, 0xB8);
    want[n++] = (struct mock_access)R(0x005);
    want[n++] = (struct mock_access)R(0x045);
    want[n++] = (struct mock_access)W(0x003, 0x07); /* direct output, or zero would wait */
    want[n++] = (struct mock_access)W(0x043, 0x07);
    for (unsigned axis = 0; axis < 4; axis++) {
      uint16_t low = (uint16_t)((axis / 2) << 6 | (axis & 1 ? 0x15 : 0x11));
      if (live >> axis & 1) want[n++] = (struct mock_access)W(low, 0x00);
      want[n++] = (struct mock_access)W(low + 2, 0x08);
    }
    want[n++] = (struct mock_access)W(0x003, 0x05); /* isolated */
    want[n++] = (struct mock_access)W(0x043, 0x05);
    traffic_check(__FILE__, __LINE__, &m, want, n);
    CHECK_EQ(mc->grace, live ? 31 : 0); /* 60 ms of 2 ms each, and the one under way */
    m.used = 0;
    CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0); /* again: nothing left to do */
    CHECK_EQ(m.used, 0);
    CHECK_EQ(m.masked, 0);
  }
}

static int enable_too(struct mc *mc) {
  meanwhile = NULL;
  return enable(mc);
}

static int enable_at_second_wait(struct mc *mc) {
  return waits == 2 ? enable_too(mc) : 0;
}

TEST(test_enable_while_another_enables, "DRV-3 DRV-9") {
  for (int late = 0; late < 2; late++) {
    struct mc *mc = opened(1);
    meanwhile = late ? enable_at_second_wait : enable_too;
    mock_run(&m, 2000 - (m.now - m.origin) % 2000 + 100);
    CHECK_EQ(enable(mc), 0);
    CHECK_EQ(answer, late && waits < 2 ? 0 : -MC_EBUSY);
    CHECK_EQ(m.releases, 1);
    CHECK_EQ(m.masked, 0);
  }
}

TEST(test_enable_waits_for_two_passes_at_most, "DRV-9") {
  static const unsigned intervals[] = {100, 400, 999, 1000, 2000, 40000};
  for (unsigned i = 0; i < COUNT(intervals); i++) {
    struct mc *mc = opened(1);
    unsigned us = intervals[i];
    CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), 0);
    m.pccsr = 0x18; /* SYSRESET*: no interrupt comes */
    int64_t before = m.now, limit = 2 * us + 5000, step = us < 1000 ? us : 1000;
    CHECK_EQ(enable(mc), -MC_EIO);
    SAID("mc: enable: no servo interrupt\n");
    CHECK_EQ(waited[0], 2000);
    for (int k = 1; k < waits; k++) CHECK_EQ(waited[k], step);
    CHECK_EQ(waits - 1, (limit + step - 1) / step);
    CHECK(m.now - before < 2000 + limit + step + 100);
    CHECK_EQ(m.card[0].b, 5); /* isolated again, no heartbeat started */
    CHECK_EQ(m.card[0].beat_until[0], 0);
    CHECK_EQ(m.releases, 0);
  }
}

TEST(test_enable_after_a_stop_waits_for_the_brakes, "DRV-6 DRV-9") {
  struct mc *mc = opened(1);
  for (int pause = 0; pause < 70000; pause += 10000) {
    CHECK_EQ(enable(mc), 0);
    mock_run(&m, 5000);
    CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
    int64_t stopped = m.now;
    mock_run(&m, pause);
    waits = 0;
    CHECK_EQ(enable(mc), 0);
    int64_t quiet = 0;
    int k = 0;
    while (waited[k] != 2000) quiet += waited[k++];
    CHECK(quiet <= 60000 && pause + quiet >= 50000);
    CHECK(pause < 60000 || quiet <= 2000);
    CHECK(m.now - stopped < pause + quiet + 7000);
    CHECK_EQ(mc_stats_of(mc)->panics, 0);
    CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
    mock_run(&m, 70000);
  }
  CHECK_EQ(m.releases, 14);
  m.pccsr = 0x18; /* SCLOCKs come no more: it does not wait for ever */
  mc->grace = 31;
  waits = 0;
  CHECK_EQ(enable(mc), -MC_EIO);
  int quiet = 0;
  while (waited[quiet] == 1000) quiet++;
  CHECK_EQ(quiet, 60);
}

TEST(test_a_card_that_lost_power_is_revived, "DRV-9 DRV-10") {
  for (int lost = 0; lost < 3; lost++) {
    for (int part = 1; part < 4; part++) { /* of its ports, A or B or both */
      struct mc *mc = opened(3);
      uint16_t base = (uint16_t)(lost << 6);
      for (int axis = 0; axis < 6; axis++) m.card[axis / 2].count[axis & 1] = 30000;
      mock_run(&m, 2100);
      for (int axis = 0; axis < 6; axis++) m.card[axis / 2].count[axis & 1] = 60000;
      mock_run(&m, 2100);
      struct mock_card *c = &m.card[lost];
      if (part & 1) c->a = 0;
      if (part & 2) c->b = 0;
      c->count[0] = 0xFFF0;
      c->count[1] = 0x0020;
      c->latched[0] = c->latched[1] = 1234; /* of before */
      c->has_latch[0] = c->has_latch[1] = 1;
      m.logging = 1;
      m.on_access = traffic_of_process;
      CHECK_EQ(enable(mc), 0);
      m.logging = 0;
      const struct mock_access want[] = {
          W(base | 0x07, 0x89), W(base | 0x01, 0x00), W(base | 0x03, 0x05), R(base | 0x03),
          R(base | 0x03),       R(base | 0x03),       R(base | 0x03),       W(base | 0x01, 0x05),
          PAIR(base | 0x09),    PAIR(base | 0x09),    PAIR(base | 0x0D),    PAIR(base | 0x0D)};
      int at = 6 * lost + (part == 2 ? 2 : 1); /* B is asked if A is right */
      if (part != 2) CHECK_EQ(m.log[at].write, 1);
      memmove(m.log, m.log + at, sizeof want);
      m.used = (int)(COUNT(want));
      EXPECT(&m, want);
      char text[] = "mc: card 0 was reset: initialised again\n";
      text[9] = (char)('0' + lost);
      SAID(text);
      CHECK_EQ(c->b, 7);
      mock_run(&m, 4100);
      for (int axis = 0; axis < 6; axis++) {
        int32_t where = axis / 2 != lost ? 60000 : axis & 1 ? 0x20 : -16;
        CHECK_EQ(mc_state_of(mc, axis)->encnow, where);
      }
    }
  }
}

static int mute;

/* The one-shot of an axis never starts. */
static void keep_mute(struct mock *mock) {
  mock->card[mute / 2].beat_until[mute & 1] = 0;
}

TEST(test_enable_names_the_axis_without_a_heartbeat, "DRV-9 PAN-2") {
  for (mute = 0; mute < 4; mute++) {
    struct mc *mc = opened(2);
    m.card[mute / 2].enabled[mute & 1] = 0; /* PANIC does not look at it */
    m.on_access = keep_mute;
    CHECK_EQ(enable(mc), -MC_EIO);
    char text[] = "mc: enable: axis 0 has no heartbeat\n";
    text[17] = (char)('0' + mute);
    SAID(text);
    CHECK_EQ(m.pccsr, 0xB8);
    CHECK_EQ(m.card[0].b, 5);
    CHECK_EQ(m.masked, 0);
    mock_run(&m, 60000);
    CHECK(mock_panic(&m));
    CHECK_EQ(mc_stats_of(mc)->panics, 0); /* its own */
  }
}
