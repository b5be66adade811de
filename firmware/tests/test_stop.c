/* SPDX-License-Identifier: Apache-2.0 */
/* Stops: whose they are, how long they last, and what they leave behind. §2.3.4, Table 2.3 */
#include "traffic.h"

static void at_rest(const struct mc *mc) {
  CHECK(!mc_is_enabled(mc));
  for (int axis = 0; axis < mc_joints(mc); axis++) {
    CHECK_EQ(mock_dac(&m, axis), 0x800);
    CHECK_EQ(mc_param_of(mc, axis)->mode & MD_MASK, MD_OFF);
    CHECK_EQ(mc_setpoint(mc, axis), 0);
    CHECK_EQ(mc_current(mc, axis), 0);
    CHECK_EQ(mc_state_of(mc, axis)->inow, 0);
    CHECK_EQ(m.card[axis / 2].b & 2, 0);
  }
}

TEST(test_a_stop_holds_until_an_enable, "DRV-4 DRV-9") {
  for (int how = 0; how < 2; how++) {
    struct mc *mc = listening(1);
    int32_t set[2] = {300, -300};
    int other = mc_open(mc, MC_O_RDWR);
    set_mode_within_100(mc, 0, MD_TORQ);
    CHECK_EQ(mc_write(mc, 0, set, 8), 8); /* never stopped */
    CHECK_EQ(enable(mc), 0);
    CHECK_EQ(mc_write(mc, other, set, 8), 8);
    mock_run(&m, 4100);
    CHECK_EQ(mc_current(mc, 0), 300);
    CHECK_EQ(mc_demand(mc, 0), 300);
    CHECK(!mc_is_stopped(mc) && mc_is_enabled(mc));
    CHECK_EQ(how == 0 ? mc_halt(mc) : mc_ioctl(mc, other, MSTOP, NULL), 0);
    at_rest(mc);
    CHECK(mc_is_stopped(mc));
    mock_run(&m, 49000);
    CHECK(!mock_panic(&m));
    mock_run(&m, 2000);
    CHECK(mock_panic(&m));
    CHECK_EQ(mc_stats_of(mc)->panics, 0); /* its own */
    CHECK_EQ(errcode_of(&m, 0), 0);
    CHECK_EQ(m.signals[0], 0);
    said[0] = 0;
    for (int i = 0; i < 3; i++) {
      CHECK_EQ(mc_write(mc, i & 1, set, 8), -MC_EIO);
      CHECK_EQ(mc_write(mc, 0, set, 0), 0); /* asks nothing */
      CHECK_EQ(mc_write(mc, 0, set, 7), -MC_EINVAL);
    }
    SAID("mc: write: stopped, MENABLE first\n"); /* told once */
    CHECK_EQ(m.masked, 0);
    CHECK_EQ(mc_setpoint(mc, 0), 0);
    m.card[0].present = 0;
    CHECK_EQ(enable(mc), -MC_EIO);
    CHECK_EQ(mc_write(mc, 0, set, 8), -MC_EIO); /* an enable that failed is none */
    m.card[0].present = 1;
    CHECK_EQ(mc_ioctl(mc, other, MENABLE, NULL), 0);
    CHECK(!mc_is_stopped(mc));
    CHECK_EQ(mc_write(mc, 0, set, 8), 8);
    CHECK_EQ(mc_close(mc, 0), 0);
    CHECK_EQ(mc_close(mc, other), 0);
    CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
    CHECK(!mc_is_stopped(mc));
  }
}

static int stop_at, waits, halts;

static void stop_in_wait(void *ctx, uint32_t us) {
  if (waits++ == stop_at && halts) CHECK_EQ(mc_halt(m.memory), 0);
  if (waits == stop_at + 1 && !halts) CHECK_EQ(mc_ioctl(m.memory, 0, MSTOP, NULL), 0);
  mock_run(ctx, us);
}

/* Between any two steps of an enable: it fails, nothing moves, no brake opens. */
TEST(test_a_stop_ends_an_enable_under_way, "DRV-3 DRV-9") {
  int last = 0;
  for (stop_at = 0; !last; stop_at++) {
    for (int how = 0; how < 2; how++) {
      struct mc *mc = listening(1);
      CHECK_EQ(enable(mc), 0);
      mock_run(&m, 5000);
      CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
      mc->os.delay_us = stop_in_wait; /* the next enable waits for the brakes first */
      waits = 0;
      halts = how;
      int releases = m.releases;
      int result = enable(mc);
      CHECK_EQ(m.masked, 0);
      last = waits <= stop_at; /* it came too late */
      CHECK_EQ(result, last ? 0 : -MC_EIO);
      if (!last) {
        at_rest(mc);
        CHECK(mc_is_stopped(mc));
        CHECK(strstr(said, "mc: enable: stopped by an error, PANIC or MSTOP\n") != NULL);
        CHECK(m.releases - releases <= (waits > 55)); /* but the very last wait: it had opened */
        mc->os.delay_us = m.os.delay_us;
        mock_run(&m, 60000);
        CHECK(mock_panic(&m));
        CHECK_EQ(enable(mc), 0);
      }
    }
  }
  CHECK(stop_at > 50);
}

TEST(test_a_halt_of_a_closed_or_dead_machine, "DRV-9") {
  struct mc *mc = mock_start(&m, 1);
  m.logging = 1;
  CHECK_EQ(mc_halt(mc), 0);
  CHECK(m.used == 0 && !mc_is_stopped(mc));
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
  m.used = 0;
  CHECK_EQ(mc_halt(mc), 0); /* at rest already */
  CHECK_EQ(m.used, 0);
  CHECK(mc_is_stopped(mc));
  CHECK_EQ(enable(mc), 0);
  m.adaptor_dead = 1;
  CHECK_EQ(mc_halt(mc), -MC_EIO);
  CHECK(!mc_is_enabled(mc));
  CHECK_EQ(m.masked, 0);
  m.adaptor_dead = 0;
  CHECK_EQ(mc_halt(mc), 0); /* what failed is over */
}

/* Monitors keep nothing going, and lose nothing: state goes on. */
TEST(test_the_last_writer_stops_the_machine, "DRV-2 DRV-9") {
  struct mc *mc = listening(1);
  int32_t set = 40;
  struct mc_state state;
  int monitor = mc_open(mc, MC_O_RDONLY), writer = mc_open(mc, MC_O_WRONLY);
  set_mode_within_100(mc, 0, MD_VEL);
  CHECK_EQ(enable(mc), 0);
  CHECK_EQ(mc_write(mc, 0, &set, 4), 4);
  CHECK_EQ(mc_close(mc, 0), 0);
  mock_run(&m, 100000);
  CHECK_EQ(mc_current(mc, 0), 40); /* one writer is left */
  CHECK(!mock_panic(&m));
  CHECK_EQ(mc_close(mc, writer), 0);
  at_rest(mc);
  m.card[0].count[0] = 77;
  mock_run(&m, 60000);
  CHECK(mock_panic(&m));
  CHECK_EQ(mc_stats_of(mc)->panics, 0);
  CHECK_EQ(m.pccsr, 0xB8); /* samples go on */
  CHECK_EQ(mc_read(mc, monitor, &state, 28), 28);
  CHECK_EQ(state.encnow, 77);
  int next = mc_open(mc, MC_O_RDWR); /* nobody stopped it: it may write at once */
  CHECK_EQ(mc_write(mc, next, &set, 4), 4);
  CHECK_EQ(mc_close(mc, next), 0);
  m.logging = 1;
  CHECK_EQ(mc_close(mc, monitor), 0);
  TRAFFIC(W(0x409, 0x18));
}

/* Nothing written before an enable moves anything after it, whatever ended the one before. */
TEST(test_enable_moves_nothing_before_a_new_demand, "DRV-6 DRV-9") {
  static const int modes[] = {MD_POS, MD_VEL, MD_TORQ, MD_POS | ZEROFB, MD_POS | ADFB};
  for (int i = 0; i < 5 * 4; i++) {
    struct mc *mc = listening(1);
    int how = i % 4;
    set_mode_within_100(mc, 0, modes[i / 4]);
    set_mode_within_100(mc, 1, MD_POS | POSCHK);
    DEMAND(mc, 700);
    CHECK_EQ(enable(mc), 0);
    for (int round = 0; round < 2; round++) {
      for (int pass = 0; pass < 10; pass++) {
        CHECK_EQ(mock_dac(&m, 0), 0x800);
        CHECK_EQ(mc_current(mc, 0), 0);
        mock_run(&m, 2000);
      }
      m.card[0].count[0] = (uint16_t)(100 + round);
      DEMAND(mc, 700);
      mock_run(&m, 4000);
      CHECK(mock_dac(&m, 0) != 0x800);
      if (round > 0) break;
      if (how == 0) m.estop_open = 1;         /* PANIC */
      if (how == 1) m.card[0].count[1] = 101; /* a limit */
      if (how == 2) CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
      mock_run(&m, 4000); /* how 3: enabled once more, in full motion */
      m.estop_open = 0;
      m.card[0].count[1] = 0;
      mock_run(&m, 60000);
      CHECK_EQ(mc_is_enabled(mc), how == 3);
      if (how == 2) set_mode_within_100(mc, 0, modes[i / 4]);
      m.card[0].count[0] = 55;
      mock_run(&m, 10000);
      CHECK_EQ(enable(mc), 0);
      mock_run(&m, 2000);
    }
  }
}

/* The PANIC that the end of our own heartbeats makes 50 ms later costs no sample, nor does one of
 * the button while the machine is at rest. */
TEST(test_a_panic_at_rest_costs_no_sample, "DRV-7 DRV-9") {
  struct mc *mc = mock_open(&m, 1);
  CHECK_EQ(enable(mc), 0);
  mock_run(&m, 10000);
  for (int button = 0; button < 2; button++) {
    m.estop_open = button;
    call(mc, MSTOP, 0);
    int passes = m.passes;
    mock_run(&m, 100000);
    CHECK(mock_panic(&m));
    CHECK_EQ(m.passes - passes, 50);
    CHECK_EQ(mc_stats_of(mc)->missed, 0);
    CHECK_EQ(mc_stats_of(mc)->panics, 0);
  }
}
