/* SPDX-License-Identifier: Apache-2.0 */
/* What struct mc_guard asks for beyond checks of the axes: brakes before power, modes read back,
 * checked setpoints, and PANIC that the adaptor latches. */
#include "mc_priv.h"
#include "hear.h"

#define BRAKES_US 30000

/* Two axes that push against their error of 40 counts each. */
static struct mc *pushing(struct mc_guard guard) {
  struct mc *mc = guarded(guard);
  DEMAND(mc, 40, -40);
  mock_run(&m, 2000);
  CHECK_EQ(mock_dac(&m, 0), 0x800 + 40);
  return mc;
}

static int is_held(int axis, int code) {
  int off = mock_dac(&m, axis) - code;
  return off >= -128 && off <= 128;
}

static int is_connected(void) {
  return (m.card[0].b & MMCS_CARD_PPI_B_DAC_JOINT_bm) != 0;
}

/* Until PANIC, whose brakes then take their time, and a pass more. */
static void check_brakes_before_power(int64_t most_us) {
  int64_t from = m.now;
  while (!m.panic) {
    CHECK(m.now - from <= most_us);
    CHECK(is_connected());
    mock_run(&m, 500);
  }
  for (int64_t closing = m.now + BRAKES_US - 1000; m.now < closing; mock_run(&m, 500)) {
    CHECK(is_connected());
    CHECK(m.panic);
  }
  mock_run(&m, 15000);
  CHECK(!is_connected());
  CHECK(m.panic);
}

TEST(test_stop_holds_until_the_brakes_are_closed, "DRV-9") {
  struct mc *mc = pushing((struct mc_guard){.brakes = BRAKES_US});
  CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
  CHECK(!mc_is_enabled(mc));
  CHECK_EQ(mc_param_of(mc, 0)->mode & MD_MASK, MD_OFF);
  mock_run(&m, 3000);
  CHECK(is_held(0, 0x800 + 40));
  m.card[0].count[0] = (uint16_t)(m.card[0].count[0] - 400); /* what sinks is held against */
  mock_run(&m, 3000);
  CHECK(is_held(0, 0x800 + 440));
  CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0); /* again: no sooner */
  CHECK_EQ(mc_halt(mc), 0);
  check_brakes_before_power(50000);
  CHECK_EQ(mc_stats_of(mc)->panics, 0);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
}

TEST(test_without_brakes_a_stop_is_zero_at_once, "DRV-9") {
  struct mc *mc = pushing((struct mc_guard){0});
  CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
  CHECK_EQ(mock_dac(&m, 0), 0x800);
  CHECK(!is_connected());
}

TEST(test_button_holds_until_the_brakes_are_closed, "DRV-9") {
  struct mc *mc = pushing((struct mc_guard){.brakes = BRAKES_US});
  m.estop_open = 1;
  mock_run(&m, 2000);
  CHECK(!mc_is_enabled(mc));
  m.estop_open = 0; /* a short press: until heartbeats end the brakes are open again */
  mock_run(&m, 10);
  CHECK(!m.panic);
  CHECK(is_held(0, 0x800 + 40));
  check_brakes_before_power(50000);
  CHECK_EQ(mc_stats_of(mc)->panics, 1);
}

/* Its own current is what cannot be trusted. */
TEST(test_faulty_axis_is_let_go_the_other_is_held, "DRV-9") {
  struct mc *mc = pushing((struct mc_guard){.brakes = BRAKES_US, .jump = 100});
  m.card[0].count[0] = (uint16_t)(m.card[0].count[0] + 2000);
  mock_run(&m, 2500);
  CHECK(!mc_is_enabled(mc));
  CHECK(is_held(0, 0x800));
  CHECK(is_held(1, 0x800 - 40));
  CHECK(mock_dac(&m, 1) < 0x800);
}

TEST(test_overloaded_axis_is_let_go, "DRV-9") {
  struct mc *mc = pushing((struct mc_guard){.brakes = BRAKES_US});
  struct mc_param par = param_of(mc, 0);
  par.ilim = 500;
  par.ilimax = 3;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
  DEMAND(mc, 2000, 40);
  mock_run(&m, 8000);
  CHECK(!mc_is_enabled(mc));
  CHECK(is_held(0, 0x800));
  CHECK(is_held(1, 0x800 + 40));
}

/* What cannot be relied upon holds nothing. */
TEST(test_bus_error_is_zero_at_once, "DRV-9") {
  struct mc *mc = pushing((struct mc_guard){.brakes = BRAKES_US});
  m.card[0].present = 0;
  mock_run(&m, 2000);
  CHECK(!mc_is_enabled(mc));
  CHECK_EQ(mc->power, MC_IDLE);
}

TEST(test_close_and_enable_wait_for_the_brakes, "DRV-9") {
  struct mc *mc = pushing((struct mc_guard){.brakes = BRAKES_US});
  CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
  int64_t from = m.now;
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  CHECK(m.now - from > BRAKES_US + 50000);
  mock_run(&m, 5000);
  CHECK_EQ(mc_close(mc, 0), 0);
  CHECK(!is_connected());
  CHECK(m.panic);
  CHECK_EQ(mc->power, MC_IDLE);
}

/* One card a pass. */
TEST(test_modes_that_changed_stop_the_machine, "DRV-9") {
  static const uint8_t bits[] = {MMCS_CARD_PPI_B_DAC_JOINT_bm, MMCS_CARD_PPI_B_SCLOCK_EN_bm,
                                 MMCS_CARD_PPI_B_INDEX_EN_bm};
  for (unsigned n = 0; n <= sizeof bits; n++) {
    struct mc *mc = guarded((struct mc_guard){.readback = 1});
    mock_run(&m, 5000);
    CHECK(mc_is_enabled(mc));
    if (n < sizeof bits) {
      m.card[0].b ^= bits[n];
    } else {
      m.card[0].a ^= 1;
    }
    mock_run(&m, 2000);
    CHECK(!mc_is_enabled(mc));
    CHECK_EQ(strcmp(said, "mc: PANIC: card 0: its modes changed\n"), 0);
  }
  struct mc *mc = guarded((struct mc_guard){.jump = 100});
  m.card[0].a ^= MMCS_CARD_PPI_A_LED1_bm; /* nobody asked */
  mock_run(&m, 5000);
  CHECK(mc_is_enabled(mc));
}

static struct mmcs_setpoints message(unsigned sequence, int value) {
  struct mmcs_setpoints s = {.sequence = sequence, .axes = 2, .value = {value, -value}};
  s.check = mmcs_check(&s);
  return s;
}

TEST(test_checked_setpoints, "DRV-9") {
  int32_t plain[2] = {1, 2};
  struct mmcs_setpoint one = {0, 1};
  struct mc *mc = guarded((struct mc_guard){.checked = 1});
  CHECK_EQ(mc_write(mc, 0, plain, 8), -MC_EINVAL);
  CHECK_EQ(mc_ioctl(mc, 0, MSETPOINT, &one), -MC_EINVAL);
  struct mmcs_setpoints s = message(0xFFFFFFFF, 7);
  CHECK_EQ(mc_ioctl(mc, 0, MSETPOINTS, &s), 0);
  CHECK_EQ(mc_setpoint(mc, 0), 7);
  CHECK_EQ(mc_setpoint(mc, 1), -7);
  s = message(0, 8);
  CHECK_EQ(mc_ioctl(mc, 0, MSETPOINTS, &s), 0);
  s = message(1, 8);
  s.axes = 3;
  s.check = mmcs_check(&s);
  CHECK_EQ(mc_ioctl(mc, 0, MSETPOINTS, &s), -MC_EINVAL);
  CHECK(mc_is_enabled(mc));
  s = message(2, 9); /* message 1 was lost */
  CHECK_EQ(mc_ioctl(mc, 0, MSETPOINTS, &s), -MC_EIO);
  CHECK(!mc_is_enabled(mc));
  CHECK_EQ(mc_setpoint(mc, 0), 8);
  CHECK_EQ(strcmp(said, "mc: PANIC: setpoints were lost\n"), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSETPOINTS, &s), -MC_EIO);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSETPOINTS, &s), 0); /* the first one has any number */
}

/* Each bit of each word that is sent. */
TEST(test_setpoints_that_change_on_their_way, "DRV-9") {
  for (unsigned bit = 0; bit < 5 * 32; bit++) {
    struct mc *mc = guarded((struct mc_guard){.checked = 1});
    struct mmcs_setpoints s = message(5, 1234);
    unsigned *words[] = {&s.sequence, &s.axes, (unsigned *)&s.value[0], (unsigned *)&s.value[1],
                         &s.check};
    *words[bit / 32] ^= 1u << bit % 32;
    CHECK_EQ(mc_ioctl(mc, 0, MSETPOINTS, &s), -MC_EINVAL);
    CHECK(!mc_is_enabled(mc));
    CHECK_EQ(strcmp(said, "mc: PANIC: setpoints changed on their way\n"), 0);
    CHECK_EQ(mc_setpoint(mc, 0), 0);
  }
}

TEST(test_latched_panic, "DRV-9") {
  struct mc *mc = listening(1);
  mc->config.guard = (struct mc_guard){.latched = 1, .brakes = BRAKES_US};
  m.safety = m.latched = 1;
  set_modes(mc, MD_POS);
  m.estop_open = 1;
  mock_run(&m, 5000);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), -MC_EIO);
  CHECK(m.panic);
  CHECK_EQ(strcmp(said, "mc: enable: PANIC stands: button, cable, power or an encoder\n"), 0);
  m.estop_open = 0;
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  CHECK(!m.panic);
  mock_run(&m, 5000);
  CHECK(mc_is_enabled(mc));
  CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
  CHECK(m.latched); /* brakes at once */
  check_brakes_before_power(0);
}

TEST(test_counts_of_an_axis_that_is_on_are_locked, "DRV-9") {
  unsigned on = 7 << 8, off = 7 << 8 | 1;
  struct mc *mc = guarded((struct mc_guard){.lock = 1});
  set_mode_within_100(mc, 1, MD_OFF);
  CHECK_EQ(mc_ioctl(mc, 0, MSETENC, &on), -MC_EBUSY);
  CHECK_EQ(mc_ioctl(mc, 0, MSETENC, &off), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSETENC, &on), 0);
}

static void turn(int axis, int by, int samples) {
  for (int n = 0; n < samples; n++) {
    m.card[0].count[axis] = (uint16_t)(m.card[0].count[axis] + by);
    mock_pass(&m);
  }
}

/* At 20 counts a sample, of which a quarter may be lost, and two. */
TEST(test_speed_that_is_not_followed, "DRV-9") {
  for (int jammed = 0; jammed < 2; jammed++) {
    struct mc *mc = guarded((struct mc_guard){.follow = 100});
    set_modes(mc, MD_VEL);
    DEMAND(mc, 20, 0);
    for (int speed = 0; speed < 18 && !jammed; speed++) turn(0, speed, 1);
    turn(0, jammed ? 0 : 13, 40);
    CHECK_EQ(mc_is_enabled(mc), !jammed);
    if (jammed) CHECK_EQ(strcmp(said, "mc: PANIC: axis 0 does not follow\n"), 0);
  }
}

TEST(test_axis_that_is_off_stays_where_it_is, "DRV-9") {
  struct mc *mc = guarded((struct mc_guard){.follow = 100});
  set_mode_within_100(mc, 1, MD_OFF);
  call(mc, MSETENC, 3000 << 8 | 1);
  turn(1, 10, 10);
  CHECK(mc_is_enabled(mc));
  call(mc, MSETDAC, 0x8FF << 8 | 1); /* moved on purpose */
  turn(1, 50, 10);
  CHECK(mc_is_enabled(mc));
  mock_pass(&m);
  call(mc, MSETDAC, 0x800 << 8 | 1);
  turn(1, 10, 9);
  CHECK(mc_is_enabled(mc));
  turn(1, 10, 4);
  CHECK(!mc_is_enabled(mc));
  CHECK_EQ(strcmp(said, "mc: PANIC: axis 1 does not follow\n"), 0);
}

MAIN
