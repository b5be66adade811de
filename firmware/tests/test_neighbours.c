/* SPDX-License-Identifier: Apache-2.0 */
/* What one program leaves to the next and to those beside it. §2.3.1, §2.3.4 */
#include "traffic.h"

/* Everything that a program can change, as far as it outlives the program. */
static void change_all(struct mc *mc, int client) {
  struct mc_param par = {.which = 1};
  int one = 1, diag = M_ANDIAG | M_ENDIAG;
  unsigned us = 700;
  int32_t set[1] = {123};
  CHECK_EQ(mc_ioctl(mc, client, MGETPARAM, &par), 0);
  par.mode = MD_VEL | POSCHK;
  par.a0 = 9;
  par.ilim = 5;
  CHECK_EQ(mc_ioctl(mc, client, MSETPARAM, &par), 0);
  CHECK_EQ(mc_ioctl(mc, client, MDACMODE, &one), 0);
  CHECK_EQ(mc_ioctl(mc, client, MDIAGMODE, &diag), 0);
  CHECK_EQ(mc_ioctl(mc, client, MSETVERBOSITY, &one), 0);
  CHECK_EQ(mc_ioctl(mc, client, MSETINTERVAL, &us), 0);
  CHECK_EQ(mc_ioctl(mc, client, MSETNUMJOINTS, &one), 0);
  CHECK_EQ(mc_write(mc, client, set, 4), 4);
  CHECK_EQ(mc_ioctl(mc, client, MSTOP, NULL), 0);
}

static void expect_defaults(struct mc *mc, int client) {
  const struct mc_param initial = {.a0 = 1,
                                   .b0 = 1,
                                   .clkdivisor = 1,
                                   .ilim = 1024,
                                   .adc_a = 1,
                                   .plo = INT32_MIN,
                                   .phi = INT32_MAX}; /* Table 2.1 */
  static const struct mc_stats none;
  int32_t set[4] = {0};
  CHECK_EQ(mc_joints(mc), 4);
  CHECK_EQ(mc_interval(mc), 2000);
  CHECK_EQ(mc_diag(mc), 0);
  CHECK_EQ(mc_double_buffer(mc), 0);
  CHECK_EQ(mc_is_stopped(mc), 0);
  CHECK_EQ(mc->verbosity, 0);
  CHECK(memcmp(mc_stats_of(mc), &none, sizeof none) == 0);
  for (int axis = 0; axis < 4; axis++) {
    struct mc_param par = initial;
    par.which = axis;
    CHECK(memcmp(mc_param_of(mc, axis), &par, sizeof par) == 0);
    CHECK_EQ(mc_setpoint(mc, axis), 0);
    CHECK_EQ(mc_state_of(mc, axis)->errcode, 0);
  }
  for (int card = 0; card < 2; card++) CHECK_EQ(m.card[card].b, 5);
  CHECK_EQ(mc_write(mc, client, set, 16), 16);
}

TEST(test_an_open_finds_the_defaults, "DRV-2") {
  struct mc *mc = listening(2);
  struct mc_state state[4];
  expect_defaults(mc, 0);
  change_all(mc, 0);
  call(mc, MSETNUMJOINTS, 4);
  call(mc, MCALIB, 2);
  mc_spurious(mc);
  CHECK_EQ(mc_close(mc, 0), 0);
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
  expect_defaults(mc, 0);
  set_mode(mc, 1, MD_POS);
  m.card[0].count[1] = 44;
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  CHECK_EQ(mc_setpoint(mc, 1), 44); /* that it was written belongs to the past */
  CHECK_EQ(mc_read(mc, 0, state, sizeof state), (int)sizeof state);
  CHECK_EQ(state[1].fbnow, 44);
  for (int card = 0; card < 2; card++) CHECK_EQ(m.card[card].b, 7); /* nor is a calibration left */
}

/* The first writer after there was none starts as if it were alone; a second one does not. */
TEST(test_a_monitor_hands_nothing_on, "DRV-2") {
  for (int early = 0; early < 2; early++) { /* the monitor was there before the first program */
    struct mc *mc = mock_start(&m, 2);
    mc->os.log = hear;
    int monitor = early ? mc_open(mc, MC_O_RDONLY) : -1, first = mc_open(mc, MC_O_RDWR);
    if (!early) monitor = mc_open(mc, MC_O_RDONLY);
    for (int i = 1; i <= 5; i++) {
      m.card[1].count[0] = (uint16_t)(20000 * i);
      mock_run(&m, 2000);
    }
    change_all(mc, first);
    int second = mc_open(mc, MC_O_WRONLY); /* beside the first */
    CHECK_EQ(mc_interval(mc), 700);
    CHECK_EQ(mc_is_stopped(mc), 1);
    error_raise(mc, 0, MERR_PLO);
    CHECK_EQ(mc_close(mc, first), 0);
    CHECK_EQ(mc_is_stopped(mc), 1);
    CHECK_EQ(mc_close(mc, second), 0);
    mock_run(&m, 5000);
    CHECK_EQ(mc_diag(mc), 0); /* the joints' encoders count again */
    CHECK_EQ(m.card[0].b, 5);
    m.card[1].count[0] = (uint16_t)(100000 + 30000); /* pushed by hand */
    mock_run(&m, 5000);
    CHECK_EQ(mc_open(mc, MC_O_RDONLY), first); /* who only looks on changes nothing */
    CHECK_EQ(mc_interval(mc), 700);
    int next = mc_open(mc, MC_O_RDWR);
    expect_defaults(mc, next);
    CHECK_EQ(mc_state_of(mc, 2)->encnow, 130000); /* counts go on */
    mock_run(&m, 5000);
    CHECK_EQ(mc_state_of(mc, 2)->encnow, 130000);
    struct mc_state state[4];
    CHECK_EQ(mc_read(mc, monitor, state, sizeof state), (int)sizeof state);
    CHECK_EQ(state[0].errcode, MERR_PLO); /* the monitor had not been told */
    CHECK_EQ(mc_read(mc, next, state, sizeof state), (int)sizeof state);
    CHECK_EQ(state[0].errcode, 0);
  }
}

/* The open for writing fails; the monitor goes on. */
TEST(test_a_writer_that_cannot_open_leaves_the_monitor_alone, "DRV-2") {
  struct mc *mc = mock_start(&m, 1);
  CHECK_EQ(mc_open(mc, MC_O_RDONLY), 0);
  mock_run(&m, 5000);
  m.adaptor_dead = 1;
  CHECK_EQ(mc_open(mc, MC_O_RDWR), -MC_ENXIO);
  m.adaptor_dead = 0;
  CHECK_EQ(mc->pccsr, 0xB8);
  m.card[0].count[0] = 99;
  mock_run(&m, 5000);
  CHECK_EQ(mc_state_of(mc, 0)->encnow, 99);
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 1);
}

TEST(test_a_write_after_a_shutdown_is_refused, "DRV-6") {
  for (int panic = 0; panic < 2; panic++) {
    struct mc *mc = listening(1);
    int32_t set[2] = {10, 10};
    CHECK_EQ(mc_write(mc, 0, set, 8), 8); /* before the first MENABLE, too */
    set_mode_within_100(mc, 0, MD_POS | POSCHK);
    CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
    m.estop_open = panic;
    m.card[0].count[0] = 200;
    mock_run(&m, 4000);
    CHECK_EQ(mc_is_enabled(mc), 0);
    int number;
    CHECK_EQ(mc_cause(mc, &number), panic ? MCAUSE_PASSED : MCAUSE_AXIS);
    CHECK_EQ(number, panic ? -1 : 0);
    said[0] = 0;
    for (int i = 0; i < 3; i++) CHECK_EQ(mc_write(mc, 0, set, 8), -MC_EIO);
    CHECK_EQ(strcmp(said, "mc: write: shut down by an error, MENABLE first\n"), 0);
    m.estop_open = 0;
    mock_run(&m, 100000);
    set_mode_within_100(mc, 0, MD_POS);
    CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
    CHECK_EQ(mc_write(mc, 0, set, 8), 8);
  }
}

/* Artificial signals and an axis that is servoed by its encoder exclude each other under power. */
TEST(test_no_axis_is_servoed_blind, "DRV-12 DIA-2") {
  static const struct {
    int mode, needs;
  } cases[] = {{MD_OFF, 0},         {MD_POS, 1},          {MD_VEL, 1},
               {MD_TORQ, 0},        {MD_TEST1, 0},        {MD_TORQ | POSCHK, 1},
               {MD_POS | ADFB, 0},  {MD_VEL | ZEROFB, 0}, {MD_VEL | ZEROFB | POSCHK, 1},
               {MD_OFF | POSCHK, 0}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
    int on = M_ENDIAG, off = 0, want = cases[i].needs ? -MC_EBUSY : 0;
    struct mc *mc = listening(1);
    set_mode_within_100(mc, 1, cases[i].mode);
    CHECK_EQ(mc_ioctl(mc, 0, MDIAGMODE, &on), 0); /* at rest */
    CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), want);
    CHECK_EQ(mc_is_enabled(mc), !want);
    CHECK_EQ(
        strcmp(said, want ? "mc: enable: axis 1 needs its encoder, which M_ENDIAG cuts off\n" : ""),
        0);
    set_mode_within_100(mc, 1, MD_OFF);
    CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
    struct mc_param par = *mc_param_of(mc, 1);
    par.mode = cases[i].mode;
    CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), want);
    CHECK_EQ(mc_param_of(mc, 1)->mode, want ? MD_OFF : cases[i].mode);
    CHECK_EQ(mc_ioctl(mc, 0, MDIAGMODE, &off), 0);
    set_mode_within_100(mc, 1, cases[i].mode);
    CHECK_EQ(mc_ioctl(mc, 0, MDIAGMODE, &on), want);
    CHECK_EQ(mc_diag(mc), want ? 0 : M_ENDIAG);
    CHECK_EQ(m.card[0].b & 1, want != 0);
  }
}
