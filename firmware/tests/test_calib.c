/* SPDX-License-Identifier: Apache-2.0 */
/* Calibration on several cards: what is armed, read, reported and armed again. §5.3.4 */
#include "traffic.h"

TEST(test_arming_traffic, "DRV-8 CAL-1") {
  struct mc *mc = mock_open(&m, 3);
  mock_run(&m, 500);
  m.logging = 1;
  call(mc, MCALIB, 3);
  static const struct mock_access want[] = {
      W(0x043, 0x01),           /* index latches clear, SCLOCK off: that card only */
      PAIR(0x049), PAIR(0x04D), /* what SCLOCK latched is out of the way */
      W(0x043, 0x11)};          /* armed */
  EXPECT(&m, want);
  m.used = 0;
  call(mc, MCALIB, 3); /* it waits already */
  CHECK_EQ(m.used, 0);
  call(mc, MCALIB, 2); /* the other axis of that card: armed afresh */
  EXPECT(&m, want);
  CHECK_EQ(m.card[0].b, 5);
  CHECK_EQ(m.card[2].b, 5);
}

TEST(test_pass_of_a_calibrating_card, "DRV-7 DRV-8") {
  struct mc *mc = mock_open(&m, 2);
  call(mc, MCALIB, 2);
  m.latency_us = 20;
  mock_pass(&m);
  m.logging = 1;
  mock_pass(&m);
  TRAFFIC(R(0x409), W(0x409, 0x38), W(0x409, 0xB8), W(0x407, 0x80), R(0x405), R(0x405), R(0x005),
          R(0x009), R(0x00B), R(0x00D), R(0x00F), R(0x005),           /* card 0 */
          R(0x045), R(0x049), R(0x04B), R(0x04D), R(0x04F), R(0x045), /* card 1 */
          R(0x019), R(0x01B), R(0x01D), R(0x059), R(0x05B), R(0x05D), W(0x407, 0x80), R(0x405),
          R(0x405), W(0x407, 0x80), R(0x405), R(0x405));
}

TEST(test_every_axis_finds_its_own_index, "DRV-5 DRV-8 CAL-1") {
  for (int axis = 0; axis < 6; axis++) {
    struct mc *mc = mock_open(&m, 3);
    int other = axis ^ 1;
    call(mc, MCALIB, axis);
    pass_index(&m, other, 900); /* nobody waits for this one */
    mock_run(&m, 6000);
    for (int i = 0; i < 6; i++) CHECK_EQ(errcode_of(&m, i), 0);
    CHECK_EQ(mc_state_of(mc, other)->encnow, 917);
    CHECK_EQ(m.card[axis / 2].b, 0x11);
    pass_index(&m, axis, (uint16_t)(0xFF00 + axis));
    mock_pass(&m);
    for (int i = 0; i < 6; i++) {
      uint32_t want = (0xFF00u + (unsigned)i) << 16 | (unsigned)i << 8 | MERR_ZINDEX;
      CHECK_EQ(errcode_of(&m, i), i == axis ? (int32_t)want : 0);
    }
    CHECK_EQ(m.signals[0], 1);
    for (int card = 0; card < 3; card++) CHECK_EQ(m.card[card].b, 5);
    pass_index(&m, axis, 4); /* once is enough */
    mock_run(&m, 6000);
    CHECK_EQ(m.signals[0], 1);
    CHECK_EQ(mc_state_of(mc, axis)->encnow, 21);
  }
}

TEST(test_two_axes_of_a_card_one_after_the_other, "DRV-8 DRV-12") {
  for (int first = 0; first < 2; first++) {
    struct mc *mc = mock_open(&m, 2);
    int second = 1 - first;
    call(mc, MDACMODE, 1);
    call(mc, MCALIB, 2);
    call(mc, MCALIB, 3);
    CHECK_EQ(m.card[0].b, 0x0D);
    CHECK_EQ(m.card[1].b, 0x11);
    pass_index(&m, 2 + first, 50);
    mock_pass(&m);
    CHECK_EQ(errcode_of(&m, 2 + first), 50 << 16 | (2 + first) << 8 | MERR_ZINDEX);
    CHECK_EQ(errcode_of(&m, 2 + second), 0);
    CHECK_EQ(m.card[1].b, 0x11); /* the other still waits */
    mock_run(&m, 10000);
    CHECK_EQ(m.signals[0], 1);
    pass_index(&m, 2 + second, 60);
    mock_pass(&m);
    CHECK_EQ(errcode_of(&m, 2 + second), 60 << 16 | (2 + second) << 8 | MERR_ZINDEX);
    CHECK_EQ(m.card[1].b, 0x0D); /* latched by SCLOCK and double-buffered again */
    CHECK_EQ(m.signals[0], 2);
    for (int i = 0; i < 2; i++) call(mc, MCLEARERROR, 0);
    call(mc, MCALIB, 2 + first);
    mock_run(&m, 10000);
    CHECK_EQ(errcode_of(&m, 2 + second), 0); /* its index was told */
  }
}

/* Port C then reads as an absent card's does, also while a PANIC is looked into. */
TEST(test_both_indexes_of_a_live_card_are_no_absence, "DRV-5 DRV-7 DRV-8 DRV-12") {
  struct mc *mc = listening(2);
  CHECK_EQ(enable(mc), 0);
  call(mc, MCALIB, 0);
  call(mc, MCALIB, 1);
  call(mc, MCALIB, 2);
  mock_run(&m, 200);
  for (int axis = 0; axis < 3; axis++) pass_index(&m, axis, (uint16_t)(11 * (axis + 1)));
  mock_pass(&m);
  CHECK_EQ(errcode_of(&m, 0), 11 << 16 | MERR_ZINDEX);
  CHECK_EQ(errcode_of(&m, 1), 22 << 16 | 1 << 8 | MERR_ZINDEX);
  CHECK_EQ(errcode_of(&m, 2), 33 << 16 | 2 << 8 | MERR_ZINDEX);
  CHECK_EQ(m.signals[0], 1); /* of all of them */
  CHECK_EQ(m.card[0].b, 7);
  CHECK(!mock_panic(&m));
  for (int axis = 0; axis < 2; axis++) call(mc, MCALIB, axis);
  m.card[0].index[0] = m.card[0].index[1] = 1;
  m.estop_open = 1;
  mock_run(&m, 10);
  SAID("mc: PANIC: button, cable or power\n");
}

static int strike_at, struck, struck_axis;

/* The index of an axis of card 1 comes while its card is being read; the axis moves on by one. */
static void strike(struct mock *mock) {
  struct mock_card *c = &mock->card[1];
  int j = struck_axis & 1;
  if (mock->used != strike_at) return;
  c->latched[j] = c->count[j];
  c->has_latch[j] = c->index[j] = 1;
  c->count[j]++;
  struck = 1;
}

TEST(test_a_doubtful_index_is_dropped_and_the_next_one_taken, "DRV-8 CAL-1") {
  int doubts = 0, found = 0;
  for (strike_at = 1; strike_at < 26; strike_at++) {
    struct mc *mc = mock_open(&m, 2);
    call(mc, MCALIB, 2);
    call(mc, MCALIB, 3);
    m.card[1].count[1] = 70;
    m.latency_us = 20;
    mock_pass(&m);
    m.logging = 1;
    struck = 0;
    struck_axis = 3;
    m.on_access = strike;
    mock_pass(&m);
    m.on_access = NULL;
    CHECK(struck);
    if (m.card[1].b == 0x01) { /* in doubt: dropped */
      doubts++;
      CHECK_EQ(errcode_of(&m, 3), 0);
      CHECK_EQ(m.card[1].index[1], 0);
      m.card[1].index[1] = strike_at & 1; /* a latch that is not armed is not believed */
      mock_pass(&m);
      CHECK_EQ(errcode_of(&m, 3), 0);
      CHECK_EQ(m.card[1].b, 0x11); /* armed again, one SCLOCK later */
      pass_index(&m, 3, 1070);
      mock_pass(&m);
      CHECK_EQ(errcode_of(&m, 3), 1070 << 16 | 3 << 8 | MERR_ZINDEX);
    } else {
      found += errcode_of(&m, 3) != 0;
      mock_pass(&m);
      CHECK_EQ(errcode_of(&m, 3), 70 << 16 | 3 << 8 | MERR_ZINDEX);
    }
    CHECK_EQ(errcode_of(&m, 2), 0);
    CHECK_EQ(m.card[1].b, 0x11); /* axis 2 still waits */
    pass_index(&m, 2, 5);
    mock_pass(&m);
    CHECK_EQ(errcode_of(&m, 2), 5 << 16 | 2 << 8 | MERR_ZINDEX);
    CHECK_EQ(m.card[1].b, 5);
    CHECK_EQ(m.signals[0], 2);
  }
  CHECK_EQ(doubts, 3); /* after the first read of port C, before its own pair */
  CHECK(found >= 10);
}

/* Axis 2 in doubt drops the latches of its card; what is sure of axis 3 is told before. */
TEST(test_the_doubt_of_one_axis_is_not_the_others, "DRV-8 CAL-1") {
  int doubts = 0;
  for (strike_at = 1; strike_at < 26; strike_at++) {
    for (int sure = 2; sure < 4; sure++) {
      struct mc *mc = mock_open(&m, 2);
      int other = sure ^ 1;
      call(mc, MCALIB, 2);
      call(mc, MCALIB, 3);
      m.latency_us = 20;
      mock_pass(&m);
      pass_index(&m, sure, 300);
      m.card[1].count[other & 1] = 70;
      m.logging = 1;
      struck_axis = other;
      m.on_access = strike;
      mock_pass(&m);
      m.on_access = NULL;
      CHECK_EQ(errcode_of(&m, sure), 300 << 16 | sure << 8 | MERR_ZINDEX);
      if (m.card[1].b == 0x01) {
        doubts++;
        CHECK_EQ(errcode_of(&m, other), 0);
      } else {
        mock_pass(&m);
        CHECK_EQ(errcode_of(&m, other), 70 << 16 | other << 8 | MERR_ZINDEX);
      }
    }
  }
  CHECK_EQ(doubts, 3 + 1);
}

/* What the index latched is up to an interval old: the servo wants to know where the axis is. */
TEST(test_the_servo_sees_where_the_axis_is, "DRV-8 SRV-1") {
  for (int axis = 2; axis < 4; axis++) {
    for (int waits = 0; waits < 2; waits++) {
      struct mc *mc = mock_open(&m, 2);
      int passing = waits ? axis : axis ^ 1; /* or its neighbour, whose index nobody waits for */
      for (int i = 2; i < 4; i++) {
        CHANGE(mc, i, par.mode = MD_POS, par.a0 = 2);
      }
      CHECK_EQ(enable(mc), 0);
      call(mc, MCALIB, axis);
      for (int pass = 0; pass < 5; pass++) {
        uint16_t now = (uint16_t)(100 * pass);
        pass_index(&m, passing, now); /* goes on by 17 counts since */
        mock_pass(&m);
        CHECK_EQ(mc_state_of(mc, passing)->encnow, now + 17);
        CHECK_EQ(mock_dac(&m, passing), 0x800 - 2 * (now + 17));
        if (waits) {
          CHECK_EQ(errcode_of(&m, axis), axis << 8 | MERR_ZINDEX);
          break;
        }
        CHECK_EQ(errcode_of(&m, axis), 0);
      }
    }
  }
}

static int try_mode(struct mc *mc, int axis, int mode) {
  struct mc_param par = param_of(mc, axis);
  par.mode = mode;
  return mc_ioctl(mc, 0, MSETPARAM, &par);
}

/* The A/Ds of a calibrating card stand still: nobody may be led by them meanwhile. */
TEST(test_an_axis_led_by_its_converter_and_a_calibration_exclude_each_other, "DRV-3 DRV-8") {
  static const int led[] = {MD_POS | ADFB, MD_VEL | ADDMD, MD_TORQ | ADOFF, MD_OFF | ADFB | POSCHK};
  static const int free_[] = {MD_POS, MD_VEL | ZEROFB, MD_TEST1 | COULCOMP, MD_OFF | ADFB,
                              MD_OFF | POSCHK};
  for (int axis = 2; axis < 4; axis++) {
    struct mc *mc = mock_open(&m, 2);
    for (int i = 0; i < 8; i++) {
      int user = 2 + (i & 1), other = axis;
      CHECK_EQ(try_mode(mc, user, led[i / 2]), 0);
      m.logging = 1;
      m.used = 0;
      CHECK_EQ(mc_ioctl(mc, 0, MCALIB, &other), -MC_EBUSY);
      CHECK_EQ(m.used, 0);
      CHECK(strstr(m.last_log, "needs its A/D") != NULL);
      CHECK_EQ(try_mode(mc, user, MD_OFF), 0);
    }
    CHECK_EQ(try_mode(mc, 0, MD_POS | ADFB), 0); /* of another card */
    call(mc, MCALIB, axis);
    for (int i = 0; i < 8; i++) {
      CHECK_EQ(try_mode(mc, 2 + (i & 1), led[i / 2]), -MC_EBUSY);
      struct mc_param par = {.which = 2 + (i & 1)};
      CHECK_EQ(mc_ioctl(mc, 0, MGETPARAM, &par), 0);
      CHECK_EQ(par.mode, MD_OFF);
    }
    for (int i = 0; i < 10; i++) CHECK_EQ(try_mode(mc, 2 + (i & 1), free_[i / 2]), 0);
    pass_index(&m, axis, 3);
    mock_pass(&m);
    CHECK_EQ(try_mode(mc, axis, MD_POS | ADFB), 0); /* it is over */
  }
}

TEST(test_a_stop_gives_calibrations_up_an_error_does_not, "DRV-6 DRV-8 DRV-9") {
  for (int how = 0; how < 4; how++) {
    for (int enabled = 0; enabled < 2; enabled++) {
      struct mc *mc = mock_open(&m, 2);
      int monitor = mc_open(mc, MC_O_RDONLY), error = how == 3 && enabled;
      set_mode_within_100(mc, 3, MD_POS | POSCHK);
      if (enabled) CHECK_EQ(enable(mc), 0);
      call(mc, MCALIB, 1);
      call(mc, MCALIB, 2);
      mock_run(&m, 5000);
      CHECK(m.card[0].b & 0x10);
      if (how == 0) call(mc, MSTOP, 0);
      if (how == 1) CHECK_EQ(mc_halt(mc), 0);
      if (how == 2) CHECK_EQ(mc_close(mc, 0), 0);
      if (how == 3) m.card[1].count[1] = 101;
      mock_run(&m, 10000);
      CHECK_EQ(mc_is_enabled(mc), 0);
      for (int card = 0; card < 2; card++) CHECK_EQ(m.card[card].b, how == 3 ? 0x11 : 5);
      pass_index(&m, 1, 50);
      pass_index(&m, 2, 60);
      mock_run(&m, 10000);
      CHECK_EQ(errcode_of(&m, 0), 0);
      CHECK_EQ(errcode_of(&m, 1), how == 3 ? 50 << 16 | 1 << 8 | MERR_ZINDEX : 0);
      CHECK_EQ(errcode_of(&m, 2), how == 3 ? 60 << 16 | 2 << 8 | MERR_ZINDEX : 0);
      CHECK_EQ(errcode_of(&m, 3), error ? 3 << 8 | MERR_PHI : 0);
      struct mc_state state;
      CHECK_EQ(mc_read(mc, monitor, &state, 28), 28);
    }
  }
}
