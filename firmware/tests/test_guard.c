/* SPDX-License-Identifier: Apache-2.0 */
/* The checks of struct mc_guard: each finds what it is for, at its limit, and only when asked. */
#include "mc_priv.h"
#include "hear.h"

static void check_stopped(struct mc *mc, const char *why) {
  CHECK(!mc_is_enabled(mc));
  CHECK_EQ(mc_state_of(mc, 0)->errcode, MERR_PANIC);
  CHECK_EQ(mc_state_of(mc, 1)->errcode, 1 << 8 | MERR_PANIC);
  CHECK_EQ(mock_dac(&m, 0), 0x800);
  CHECK_EQ(mock_dac(&m, 1), 0x800);
  CHECK_EQ(m.signals[0], 1);
  CHECK_EQ(strcmp(said, why), 0);
}

/* Until the machine stops; the pass that stopped it computes and drives nothing. */
static void run_until_stopped(struct mc *mc) {
  int passes = m.passes;
  int64_t from = m.now;
  while (mc_is_enabled(mc)) {
    CHECK(m.now - from < 50000);
    passes = m.passes;
    mock_run(&m, 1000);
    CHECK(m.passes - passes <= 1);
  }
  CHECK_EQ(m.passes, passes);
}

static void check_goes_on(struct mc *mc) {
  mock_run(&m, 20000);
  CHECK(mc_is_enabled(mc));
  CHECK_EQ(mc_state_of(mc, 0)->errcode, 0);
}

TEST(test_counter_that_jumps, "DRV-9") {
  for (int sign = -1; sign <= 1; sign += 2) {
    struct mc *mc = guarded((struct mc_guard){.jump = 100});
    m.card[0].count[1] = (uint16_t)(m.card[0].count[1] + sign * 100);
    check_goes_on(mc);
    mc = guarded((struct mc_guard){.jump = 100});
    m.card[0].count[1] = (uint16_t)(m.card[0].count[1] + sign * 101);
    run_until_stopped(mc);
    check_stopped(mc, "mc: PANIC: axis 1: its counter jumps\n");
  }
}

/* As often as SCLOCKs have passed, so often may it have moved. */
TEST(test_counter_that_nobody_read_for_a_while, "DRV-9") {
  struct mc *mc = guarded((struct mc_guard){.jump = 100});
  m.latency_us = 3300;
  m.card[0].count[0] = (uint16_t)(m.card[0].count[0] + 290);
  mock_run(&m, 4000);
  m.latency_us = 0;
  check_goes_on(mc);
}

TEST(test_axis_that_does_not_follow, "DRV-9") {
  struct mc *mc = guarded((struct mc_guard){.follow = 50, .samples = 5});
  DEMAND(mc, 50, 0);
  check_goes_on(mc);
  mc = guarded((struct mc_guard){.follow = 50, .samples = 5});
  DEMAND(mc, 51, 0);
  mock_run(&m, 5000); /* five samples are allowed */
  CHECK(mc_is_enabled(mc));
  DEMAND(mc, 50, 0); /* and after a good one, five again */
  mock_run(&m, 1000);
  DEMAND(mc, 51, 0);
  mock_run(&m, 5000);
  CHECK(mc_is_enabled(mc));
  run_until_stopped(mc);
  check_stopped(mc, "mc: PANIC: axis 0 does not follow\n");
}

/* To either side, and beyond one count. */
TEST(test_least_error_that_is_too_much, "DRV-9") {
  for (int sign = -1; sign <= 1; sign += 2) {
    struct mc *mc = guarded((struct mc_guard){.follow = 1});
    DEMAND(mc, 0, sign);
    check_goes_on(mc);
    mc = guarded((struct mc_guard){.follow = 1});
    DEMAND(mc, 0, 2 * sign);
    run_until_stopped(mc);
    check_stopped(mc, "mc: PANIC: axis 1 does not follow\n");
  }
}

/* With nothing fed back the error is the demand, as of a digital filter. */
TEST(test_only_position_that_is_fed_back_has_to_be_followed, "DRV-9") {
  static const int modes[] = {MD_TORQ, 0, MD_POS | ZEROFB};
  for (unsigned n = 0; n < sizeof modes / sizeof modes[0]; n++) {
    struct mc *mc = guarded((struct mc_guard){.follow = 50, .samples = 5});
    DEMAND(mc, 5000, 5000);
    mock_run(&m, 6000); /* the next sample would be too much */
    set_modes(mc, modes[n]);
    DEMAND(mc, 5000, 5000);
    mock_run(&m, 20000);
    CHECK(mc_is_enabled(mc));
    CHECK_EQ(m.signals[0], 0);
  }
}

/* An axis whose current is at its limit, at a speed that grows by `more` in four passes. */
static struct mc *fleeing(int32_t to, int speed, int more) {
  struct mc *mc = guarded((struct mc_guard){.runaway = 4});
  DEMAND(mc, to, 0);
  mock_run(&m, 2000);
  for (int n = 0; n <= 4; n++) {
    int moved = speed + (speed < 0 ? -n : n) * more / 4;
    m.card[0].count[0] = (uint16_t)(m.card[0].count[0] + moved);
    mock_run(&m, 1000);
  }
  return mc;
}

TEST(test_axis_that_runs_away, "DRV-9") {
  for (int sign = -1; sign <= 1; sign += 2) {
    check_goes_on(fleeing(2000 * sign, -10 * sign, 4));
    check_goes_on(fleeing(2000 * sign, 10 * sign, 8));   /* on its way */
    check_goes_on(fleeing(2000 * sign, -20 * sign, -8)); /* braked */
    check_goes_on(fleeing(900 * sign, -10 * sign, 8));   /* more current would be there */
    struct mc *mc = fleeing(2000 * sign, -10 * sign, 8);
    check_stopped(mc, "mc: PANIC: axis 0 runs away\n");
  }
}

/* What is asked for alone is watched, of the axes that there are for programs; the driver of the
 * report watches nothing. */
TEST(test_one_check_is_not_another, "DRV-9") {
  static const struct mc_guard alone[] = {{.jump = 32767}, {.follow = 30000}, {.runaway = 32767},
                                          {.missed = 30},  {.lease = 100},    {.lock = 1},
                                          {.jump = 0}};
  for (unsigned n = 0; n < sizeof alone / sizeof alone[0]; n++) {
    struct mc *mc = guarded(alone[n]);
    DEMAND(mc, 20000, -20000);
    m.card[0].count[1] = (uint16_t)(m.card[0].count[1] + 9000);
    m.latency_us = 20300;
    mock_run(&m, 30000);
    m.latency_us = 0;
    check_goes_on(mc);
  }
  struct mc *mc = guarded((struct mc_guard){.jump = 100});
  call(mc, MSETNUMJOINTS, 1);
  m.card[0].count[1] = (uint16_t)(m.card[0].count[1] + 9000);
  check_goes_on(mc);
}

/* SCLOCK's counters may hold another count than was written, and no register of the 8254 tells. */
TEST(test_sclock_of_another_rate, "DRV-9") {
  for (int us = 500; us <= 2000; us += 1500) {
    struct mc *mc = guarded((struct mc_guard){.clock = 1});
    call(mc, MSETINTERVAL, us);
    for (int n = 0; n < 900; n++) { /* late passes, and one that comes after others were missed */
      m.latency_us = n % 300 == 299 ? 3 * us + us / 2 : n % 7 * us / 10;
      mock_run(&m, us);
    }
    m.latency_us = 0;
    check_goes_on(mc);
    for (int more = -us / 10; more <= us / 10; more += us / 5) {
      mc = guarded((struct mc_guard){.clock = 1});
      call(mc, MSETINTERVAL, us);
      mock_run(&m, 300 * us);
      m.phase = 0;
      m.period += more;
      mock_run(&m, 12 * us);
      check_stopped(mc, "mc: PANIC: SCLOCK has another rate than was set\n");
    }
  }
}

TEST(test_clock_that_is_not_there, "DRV-9") {
  static struct mock other;
  struct mc *mc = mock_start(&other, 1);
  struct mc_config config = {.sysclk_hz = 8000000, .guard = {.clock = 1}};
  CHECK_EQ(mc_attach(mc, &other.bus, &other.os, &config), 0);
  other.os.clock_us = NULL;
  CHECK_EQ(mc_attach(mc, &other.bus, &other.os, &config), -MC_EINVAL);
  config.guard.clock = 0;
  CHECK_EQ(mc_attach(mc, &other.bus, &other.os, &config), 0);
}

TEST(test_no_limit_is_negative, "DRV-9") {
  static struct mock other;
  struct mc *mc = mock_start(&other, 1);
  struct mc_config config = {.sysclk_hz = 8000000, .guard = {.jump = -1}};
  CHECK_EQ(mc_attach(mc, &other.bus, &other.os, &config), -MC_EINVAL);
  config.guard = (struct mc_guard){.follow = -1};
  CHECK_EQ(mc_attach(mc, &other.bus, &other.os, &config), -MC_EINVAL);
  config.guard = (struct mc_guard){.runaway = -1};
  CHECK_EQ(mc_attach(mc, &other.bus, &other.os, &config), -MC_EINVAL);
}

TEST(test_sclocks_that_nobody_served, "DRV-9") {
  struct mc *mc = guarded((struct mc_guard){.missed = 3});
  m.latency_us = 2300; /* every third is served */
  mock_run(&m, 3000);
  m.latency_us = 0;
  check_goes_on(mc);
  mc = guarded((struct mc_guard){.missed = 3});
  m.latency_us = 4300;
  run_until_stopped(mc);
  check_stopped(mc, "mc: PANIC: SCLOCKs that no pass served 4\n");
  mc = guarded((struct mc_guard){.missed = 1});
  m.latency_us = 1300;
  run_until_stopped(mc);
  check_stopped(mc, "mc: PANIC: SCLOCKs that no pass served 1\n");
}

TEST(test_program_that_falls_silent, "DRV-9") {
  int32_t here[2] = {0, 0};
  struct mc *mc = guarded((struct mc_guard){.lease = 5});
  for (int n = 0; n < 3; n++) {
    CHECK_EQ(mc_write(mc, 0, here, 8), 8);
    mock_run(&m, 5000); /* five passes are allowed */
    CHECK(mc_is_enabled(mc));
  }
  CHECK_EQ(mc_write(mc, 0, here, 3), -MC_EINVAL); /* and what is refused is no setpoint */
  run_until_stopped(mc);
  check_stopped(mc, "mc: PANIC: SCLOCKs without a setpoint 5\n");
  mc = guarded((struct mc_guard){.lease = 1});
  CHECK_EQ(mc_write(mc, 0, here, 8), 8);
  mock_run(&m, 1000);
  CHECK(mc_is_enabled(mc));
  run_until_stopped(mc);
  check_stopped(mc, "mc: PANIC: SCLOCKs without a setpoint 1\n");
  mc = guarded((struct mc_guard){.lease = 5});
  CHECK_EQ(mc_write(mc, 0, here, 4), 4);
  m.latency_us = 7300; /* a late pass cannot blame the program for its own delay, */
  mock_run(&m, 8000);
  CHECK(mc_is_enabled(mc));
  m.latency_us = 0;
  mock_run(&m, 1000); /* but the next one counts all SCLOCKs */
  CHECK(!mc_is_enabled(mc));
}

TEST(test_program_that_owes_no_setpoint, "DRV-9") {
  struct mc *mc = guarded((struct mc_guard){.lease = 5});
  check_goes_on(mc); /* it never wrote any */
  mc = guarded((struct mc_guard){.lease = 5});
  DEMAND(mc, 0, 0);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0); /* begins anew */
  check_goes_on(mc);
  mc = guarded((struct mc_guard){.lease = 5});
  DEMAND(mc, 0, 0);
  set_modes(mc, 0);
  mock_run(&m, 1000); /* a single pass, and it owes none any more */
  CHECK(mc_is_enabled(mc));
  set_modes(mc, MD_POS);
  check_goes_on(mc);
  mc = guarded((struct mc_guard){.lease = 5});
  DEMAND(mc, 0, 0);
  set_mode(mc, 1, 0);
  mock_run(&m, 7000); /* the other is on */
  CHECK(!mc_is_enabled(mc));
}

/* The first finding ends the pass; the machine is stopped once, and the reason is one line. */
TEST(test_one_finding_stops_the_machine, "DRV-9") {
  struct mc *mc = guarded((struct mc_guard){.jump = 1});
  m.card[0].count[0]++;
  m.card[0].count[1]++;
  mock_run(&m, 2000);
  CHECK(mc_is_enabled(mc));
  m.card[0].count[0] = (uint16_t)(m.card[0].count[0] + 2);
  m.card[0].count[1] = (uint16_t)(m.card[0].count[1] + 2);
  mock_run(&m, 2000);
  check_stopped(mc, "mc: PANIC: axis 0: its counter jumps\n");
  mc = guarded((struct mc_guard){.follow = 50, .samples = 5});
  DEMAND(mc, 51, 51);
  mock_run(&m, 8000);
  check_stopped(mc, "mc: PANIC: axis 0 does not follow\n");
}

TEST(test_a_machine_at_rest_may_be_moved, "DRV-9") {
  struct mc *mc = guarded((struct mc_guard){.jump = 100, .follow = 50, .missed = 3});
  CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
  m.card[0].count[0] = (uint16_t)(m.card[0].count[0] + 9000);
  mock_run(&m, 5000);
  CHECK_EQ(mc_state_of(mc, 0)->errcode, 0);
  CHECK_EQ(m.signals[0], 0);
}

TEST(test_requests_that_wait_until_the_servo_rests, "DRV-9") {
  unsigned us = 2000, one = 1;
  for (int lock = 0; lock < 2; lock++) {
    struct mc *mc = guarded((struct mc_guard){.lock = (uint8_t)lock});
    int refused = lock ? -MC_EBUSY : 0;
    CHECK_EQ(mc_ioctl(mc, 0, MDACMODE, &one), refused);
    CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), refused);
    CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), refused);
    CHECK_EQ(mc_ioctl(mc, 0, MSETNUMJOINTS, &one), refused);
    CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
    CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), 0);
    CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  }
}

/* A mode brings parameters of its own; an axis that is off takes any. */
TEST(test_parameters_of_an_axis_that_is_on, "DRV-9") {
  for (int lock = 0; lock < 2; lock++) {
    struct mc *mc = guarded((struct mc_guard){.lock = (uint8_t)lock});
    struct mc_param par = {.which = 1};
    CHECK_EQ(mc_ioctl(mc, 0, MGETPARAM, &par), 0);
    CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0); /* nothing new */
    par.ipole = 1;                                 /* the last one */
    CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), lock ? -MC_EBUSY : 0);
    CHECK_EQ(mc_param_of(mc, 1)->ipole, !lock);
    par.mode = MD_VEL;
    CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
    CHECK_EQ(mc_param_of(mc, 1)->ipole, 1);
    set_modes(mc, 0);
    par.mode = 0;
    par.ipole = 2;
    CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
    CHECK_EQ(mc_param_of(mc, 1)->ipole, 2);
  }
}

MAIN
