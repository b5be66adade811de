/* SPDX-License-Identifier: Apache-2.0 */
/* Requests that act on hardware: interval, encoders, lights, diagnostic and buffer modes, stop,
 * statistics. §2.3.5, §5.3 */
#include "traffic.h"

TEST(test_a_new_interval_keeps_the_grace_of_a_stop, "DRV-6 DRV-9") {
  static const unsigned intervals[] = {100, 500, 2000, 9000, 16279, 100000};
  for (unsigned i = 0; i < COUNT(intervals); i++) {
    struct mc *mc = mock_open(&m, 1);
    call(mc, MSETINTERVAL, intervals[i]);
    CHECK_EQ(mc->grace, 0);
    m.card[0].enabled[0] = m.card[0].enabled[1] = 0;
    mock_run(&m, 200000);
    m.estop_open = 1; /* not after a stop: counts */
    mock_run(&m, 200000);
    CHECK_EQ(mc_stats_of(mc)->panics, 1);
    for (uint32_t left = 1; left < 3; left++) {
      mc->grace = left;
      call(mc, MSETINTERVAL, intervals[i]);
      uint32_t longer = 60000 / intervals[i] + (60000 % intervals[i] != 0) + 1;
      uint32_t least = 50000 / intervals[i] + (50000 % intervals[i] != 0) + 2;
      CHECK_EQ(mc->grace, longer > least ? longer : least);
    }
    unsigned bad = 99;
    mc->grace = 1;
    CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &bad), -MC_EINVAL);
    CHECK_EQ(mc->grace, 1);
  }
  struct mc *mc = mock_open(&m, 1);
  unsigned slow = 25001;
  CHANGE(mc, 1, par.clkdivisor = 2);
  CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &slow), -MC_EINVAL);
  CHECK(strstr(m.last_log, "interval: axis 1") != NULL);
}

static int moves, mover;

/* The axis moves while it is being set. */
static void creep(struct mock *mock) {
  if (!mock->logging || mock->used < 10 || moves-- <= 0) return; /* from the write on */
  mock->card[mover / 2].count[mover & 1]++;
}

TEST(test_an_encoder_is_set_anywhere_and_while_it_moves, "DRV-10") {
  static const int values[] = {0, 1, -1, 0x1234, -0x1234, 0x7FFD, -0x8000};
  for (int i = 0; i < 4 * 3 * 7; i++) {
    struct mc *mc = mock_open(&m, 2);
    int value = values[i % 7], moved = i / 7 % 3;
    mover = i / 21;
    moves = moved;
    mock_run(&m, 2100);
    m.logging = 1;
    m.on_access = creep;
    call(mc, MSETENC, (unsigned)(value & 0xFFFF) << 8 | (unsigned)mover | 0xFF000000u);
    m.on_access = NULL;
    for (int axis = 0; axis < 4; axis++) {
      if (axis != mover) CHECK_EQ(m.card[axis / 2].count[axis & 1], 0);
    }
    CHECK_EQ(m.used, 15);
    mock_pass(&m);
    mock_pass(&m);
    CHECK_EQ(mc_state_of(mc, mover)->encnow, value + moved);
  }
}

TEST(test_setting_an_encoder_is_no_movement_and_no_crossing, "DRV-10 SRV-6") {
  struct mc *mc = mock_open(&m, 1);
  set_mode_within_100(mc, 0, MD_VEL | POSCHK | SOFTERR);
  call(mc, MENABLE, 0);
  m.card[0].count[0] = 150;
  mock_run(&m, 8000);
  CHECK_EQ(m.signals[0], 1);
  call(mc, MSETENC, 250 << 8); /* beyond the same limit */
  mock_pass(&m);
  CHECK_EQ(mc_state_of(mc, 0)->fbnow, 250);
  CHECK_EQ(mc_state_of(mc, 0)->vel, 0);
  CHECK_EQ(m.signals[0], 1);
  call(mc, MSETENC, (unsigned)(-250 & 0xFFFF) << 8); /* beyond the other */
  mock_pass(&m);
  CHECK_EQ(mc_state_of(mc, 0)->errcode, MERR_PLO | MERR_PHI);
  CHECK_EQ(m.signals[0], 2);
}

/* Currents, errors and speeds of axis 0 while it is moved; `renumbered` on the way. */
static void move_along(int mode, int renumbered, int32_t seen[][3]) {
  struct mc *mc = mock_open(&m, 1);
  /* proportional, derivative, and an integrator */
  CHANGE(mc, 0, par.mode = mode, par.a0 = 9, par.a1 = -6, par.a2 = 1, par.b0 = 16, par.b1 = -16,
         par.adc_b = -2040);
  call(mc, MENABLE, 0);
  if ((mode & MD_MASK) == MD_POS) DEMAND(mc, 15);
  for (int pass = 0; pass < 20; pass++) {
    m.card[0].count[0] = (uint16_t)(m.card[0].count[0] + pass % 5);
    if (renumbered && pass == 8) call(mc, MSETENC, (unsigned)(-3000 & 0xFFFF) << 8);
    if (renumbered && pass == 12) call(mc, MSETENC, 32000 << 8);
    mock_pass(&m);
    if (pass == 10) CHECK((mc_state_of(mc, 0)->encnow < -2900) == renumbered);
    const struct mc_state *state = mc_state_of(mc, 0);
    seen[pass][0] = mc_current(mc, 0);
    seen[pass][1] =
        mode == MD_TORQ ? 0 : state->error; /* of a place; the servo has no use for it */
    seen[pass][2] = state->vel;
  }
}

/* Not by a single D/A unit: neither does the axis jump nor the servo forget what it holds. */
TEST(test_another_number_for_the_place_moves_no_axis, "DRV-10 DRV-9 SRV-1") {
  static const int modes[] = {MD_POS, MD_VEL, MD_POS | ADFB, MD_POS | ZEROFB | COULCOMP, MD_TORQ};
  int32_t plain[20][3], renumbered[20][3];
  for (unsigned i = 0; i < COUNT(modes); i++) {
    move_along(modes[i], 0, plain);
    move_along(modes[i], 1, renumbered);
    CHECK(memcmp(plain, renumbered, sizeof plain) == 0);
  }
}

TEST(test_each_axis_has_its_light, "DRV-12") {
  struct mc *mc = mock_open(&m, 2);
  m.logging = 1;
  for (unsigned axis = 0; axis < 4; axis++) call(mc, MSETLED, axis | 0x100);
  call(mc, MSETLED, 0xFFFFFE00u); /* other bits: nothing */
  call(mc, MSETLED, 0xFFFFFF00u | 3);
  call(mc, MSETLED, 3);
  TRAFFIC(W(0x001, 0x0D), W(0x001, 0x1D), W(0x041, 0x0D), W(0x041, 0x1D), W(0x001, 0x15),
          W(0x041, 0x1D), W(0x041, 0x0D));
}

static int relays;
static uint32_t relay_us;

static void count_relay(void *ctx, uint32_t us) {
  CHECK(!m.masked);
  relays++;
  relay_us = us;
  m.os.delay_us(ctx, us);
}

TEST(test_diagnostic_modes, "DIA-2 DRV-12") {
  for (int live = 0; live < 2; live++) {
    struct mc *mc = mock_open(&m, 2);
    if (live) call(mc, MENABLE, 0);
    mc->os.delay_us = count_relay;
    relays = 0;
    int before = 0;
    static const int modes[] = {0, 1, 1, 3, 2, 2, 0, 2, 3, 1, 0};
    for (unsigned i = 0; i < COUNT(modes); i++) {
      int expected = relays + (live && ((modes[i] ^ before) & M_ANDIAG));
      call(mc, MDIAGMODE, (unsigned)modes[i]);
      uint8_t b =
          (uint8_t)(4 | (modes[i] & M_ENDIAG ? 0 : 1) | (live && !(modes[i] & M_ANDIAG) ? 2 : 0));
      CHECK_EQ(m.card[0].b, b);
      CHECK_EQ(m.card[1].b, b);
      CHECK_EQ(relays, expected);
      CHECK_EQ(m.masked, 0);
      before = modes[i];
    }
    CHECK(!live || relay_us == 2000);
    static const int bad[] = {4, 5, 8, -1, INT32_MIN};
    m.logging = 1;
    for (unsigned i = 0; i < COUNT(bad); i++) {
      int arg = bad[i];
      CHECK_EQ(mc_ioctl(mc, 0, MDIAGMODE, &arg), -MC_EINVAL);
    }
    CHECK_EQ(m.used, 0);
  }
}

TEST(test_every_counter_of_the_statistics, "DRV-3") {
  struct mc *mc = mock_open(&m, 2);
  struct mc_stats stats;
  static const struct mc_stats none;
  set_mode_within_100(mc, 0, MD_TORQ);
  set_mode_within_100(mc, 1, MD_TORQ);
  call(mc, MENABLE, 0);
  DEMAND(mc, 1024, 1025); /* ilim is 1024: one of four is clipped */
  mock_pass(&m);
  CHECK_EQ(mc_ioctl(mc, 0, MZEROSTATS, NULL), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MGETSTATS, &stats), 0);
  CHECK(memcmp(&stats, &none, sizeof none) == 0);
  for (int i = 0; i < 5; i++) mock_pass(&m);
  mc_spurious(mc);
  m.estop_open = 1;
  mock_run(&m, 10);
  static const struct mc_stats want = {.total = 6, .panics = 1, .spurious = 1, .clips = 5};
  CHECK_EQ(mc_ioctl(mc, 0, MGETSTATS, &stats), 0);
  CHECK(memcmp(&stats, &want, sizeof want) == 0);
  CHECK_EQ(mc_ioctl(mc, 0, MZEROSTATS, NULL), 0);
  CHECK(memcmp(mc_stats_of(mc), &none, sizeof none) == 0);
}
