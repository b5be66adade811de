/* SPDX-License-Identifier: Apache-2.0 */
/* What each request of Table 2.3 does, and what it leaves alone. §2.3.5 */
#include "traffic.h"

/* --- the call itself ------------------------------------------------------------------------- */

static int masks, ins, outs;

static unsigned count_mask(void *ctx) {
  masks++;
  return m.os.mask(ctx);
}

static int copy_in(void *ctx, void *to, const void *from, size_t len) {
  CHECK(!m.masked); /* a page may have to be fetched */
  ins += (int)len;
  return m.os.copy_in(ctx, to, from, len);
}

static int copy_out(void *ctx, void *to, const void *from, size_t len) {
  CHECK(!m.masked);
  outs += (int)len;
  return m.os.copy_out(ctx, to, from, len);
}

TEST(test_every_request_is_atomic_and_copies_its_argument_only, "DRV-3 DRV-4") {
  static const struct {
    uint32_t code;
    int in, out;
  } cases[] = {{MGETNUMCARDS, 0, 4},  {MSETNUMJOINTS, 4, 0}, {MGETPARAM, 72, 72},
               {MSETPARAM, 72, 0},    {MSTOP, 0, 0},         {MSETVERBOSITY, 4, 0},
               {MGETVERBOSITY, 0, 4}, {MCLEARERROR, 0, 0},   {MSETINTERVAL, 4, 0},
               {MGETINTERVAL, 0, 4},  {MSETENC, 4, 0},       {MSETLED, 4, 0},
               {MDIAGMODE, 4, 0},     {MDACMODE, 4, 0},      {MGETSTATS, 0, 24},
               {MZEROSTATS, 0, 0},    {MCALIB, 4, 0}};
  for (unsigned i = 0; i < COUNT(cases); i++) {
    struct mc *mc = mock_open(&m, 1);
    mc->os.mask = count_mask;
    mc->os.copy_in = copy_in;
    mc->os.copy_out = copy_out;
    struct mc_param par = param_of(mc, 0);
    union {
      uint32_t word;
      struct mc_param par;
      struct mc_stats stats;
    } arg = {0};
    if (cases[i].code == MSETPARAM) arg.par = par;
    if (cases[i].code == MSETINTERVAL) arg.word = 1000;
    masks = ins = outs = 0;
    CHECK_EQ(mc_ioctl(mc, 0, cases[i].code, &arg), 0);
    CHECK_EQ(masks, 1);
    CHECK_EQ(ins, cases[i].in);
    CHECK_EQ(outs, cases[i].out);
    CHECK_EQ(m.masked, 0);
  }
}

/* --- joints ---------------------------------------------------------------------------------- */

TEST(test_joints_that_come_and_go, "DRV-3 DRV-6") {
  struct mc *mc = mock_open(&m, 2);
  int32_t values[4] = {100, 200, 300, 400};
  for (int axis = 0; axis < 4; axis++) {
    CHANGE(mc, axis, par.mode = axis < 3 ? MD_TORQ : MD_POS, par.clkdivisor = axis == 2 ? 25 : 1);
  }
  call(mc, MENABLE, 0);
  CHECK_EQ(mc_write(mc, 0, values, 12), 12);
  call(mc, MSETNUMJOINTS, 4); /* as many as before: nothing happens */
  mock_run(&m, 2000 * 100);
  for (int axis = 0; axis < 3; axis++) CHECK_EQ(mock_dac(&m, axis), 0x800 + values[axis]);
  call(mc, MSETNUMJOINTS, 1);
  CHECK_EQ(mc_joints(mc), 1);
  mock_pass(&m);
  CHECK_EQ(mock_dac(&m, 0), 0x800 + 100);
  for (int axis = 1; axis < 4; axis++) {
    CHECK_EQ(mock_dac(&m, axis), 0x800);
    CHECK_EQ(mc_state_of(mc, axis)->inow, 0);
  }
  CHECK_EQ(m.computed_axes, 1);
  CHECK_EQ(mc_state_of(mc, 0)->inow, 100);
  m.card[1].count[0] = 7; /* it is sampled all the same */
  m.card[1].count[1] = 60;
  mock_run(&m, 4000);
  CHECK_EQ(mc_state_of(mc, 2)->encnow, 7);
  call(mc, MSETNUMJOINTS, 4);
  for (int axis = 1; axis < 3; axis++) CHECK_EQ(mc_setpoint(mc, axis), 0); /* no old demand */
  CHECK_EQ(mc_write(mc, 0, values, 12), 12);
  mock_pass(&m); /* at once, whatever its divisor */
  for (int axis = 0; axis < 3; axis++) CHECK_EQ(mock_dac(&m, axis), 0x800 + values[axis]);
  CHECK_EQ(mc_setpoint(mc, 3), 60); /* position axes hold where they are */
  CHECK_EQ(m.computed_axes, 4);
  call(mc, MSETNUMJOINTS, 0);
  mock_pass(&m);
  for (int axis = 0; axis < 4; axis++) CHECK_EQ(mock_dac(&m, axis), 0x800);
  CHECK(!mock_panic(&m)); /* enabled all the same */
  call(mc, MSETNUMJOINTS, 4);
  set_mode(mc, 3, MD_TEST1);
  for (int i = 0; i < 4; i++) mock_pass(&m);
  CHECK_EQ(mock_dac(&m, 3), 0x800 + 3);
  for (int joints = 3; joints < 5; joints++) call(mc, MSETNUMJOINTS, joints);
  mock_pass(&m);
  CHECK_EQ(mock_dac(&m, 3), 0x800); /* begins anew */
}

/* --- parameters ------------------------------------------------------------------------------ */

TEST(test_a_change_of_mode_forgets_the_setpoint_under_power_only, "DRV-9 SRV-6") {
  struct mc *mc = mock_open(&m, 1);
  DEMAND(mc, 70, 80);
  set_mode(mc, 0, MD_TORQ);
  set_mode(mc, 1, MD_POS);
  CHECK_EQ(mc_setpoint(mc, 0), 70); /* not under power: written is written */
  call(mc, MENABLE, 0);
  for (int axis = 0; axis < 2; axis++) CHECK_EQ(mc_setpoint(mc, axis), 0); /* but of no force */
  DEMAND(mc, 70, 80);
  mock_pass(&m);
  CHECK_EQ(mock_dac(&m, 0), 0x800 + 70);
  set_mode(mc, 0, MD_VEL);
  mock_pass(&m);
  CHECK_EQ(mc_setpoint(mc, 0), 0);
  m.card[0].count[0] = 400;
  mock_run(&m, 8000);
  set_mode(mc, 0, MD_POS);
  mock_pass(&m);
  CHECK_EQ(mc_setpoint(mc, 0), 400);
  CHECK_EQ(mock_dac(&m, 0), 0x800);
  m.card[0].count[0] = 500; /* pushed: it comes back, a second time it is not asked */
  mock_run(&m, 4000);
  CHECK_EQ(mc_setpoint(mc, 0), 400);
  call(mc, MENABLE, 0); /* a new start: all of them stay where they are */
  mock_pass(&m);
  CHECK_EQ(mc_setpoint(mc, 0), 500);
  CHECK_EQ(mc_setpoint(mc, 1), 0);
  set_mode(mc, 0, MD_VEL);
  set_mode(mc, 0, MD_POS);
  DEMAND(mc, -3, 80); /* before the next sample */
  mock_pass(&m);
  CHECK_EQ(mc_setpoint(mc, 0), -3);
}

/* Which way the feedback comes is a part of what a demand means. Torque is not fed back. */
TEST(test_a_change_of_feedback_does_not_jump, "DRV-9 SRV-6") {
  static const int changes[][2] = {{MD_POS, MD_POS | ADFB},   {MD_POS | ADFB, MD_POS},
                                   {MD_POS, MD_POS | ZEROFB}, {MD_POS | ZEROFB, MD_POS},
                                   {MD_VEL, MD_VEL | ADFB},   {MD_VEL | ZEROFB, MD_VEL},
                                   {MD_POS | ADDMD, MD_POS},  {MD_VEL | ADDMD, MD_VEL}};
  for (unsigned i = 0; i < COUNT(changes); i++) {
    struct mc *mc = mock_open(&m, 1);
    set_mode(mc, 0, changes[i][0]);
    set_mode(mc, 1, MD_TORQ);
    call(mc, MENABLE, 0);
    DEMAND(mc, 300, 20);
    m.card[0].count[0] = 250;
    m.card[0].adc[0] = 2222;
    mock_run(&m, 20000);
    set_mode(mc, 0, changes[i][1]);
    set_mode(mc, 1, MD_TORQ | ADFB | ZEROFB);
    for (int pass = 0; pass < 5; pass++) {
      mock_pass(&m);
      CHECK_EQ(mock_dac(&m, 0), 0x800);
      CHECK_EQ(mc_state_of(mc, 0)->error, 0);
      CHECK_EQ(mock_dac(&m, 1), 0x800 + 20);
    }
    DEMAND(mc, 10, 20);
    mock_pass(&m);
    CHECK(mock_dac(&m, 0) != 0x800);
  }
}

TEST(test_a_shorter_divisor_acts_at_once_a_longer_one_after_its_sample, "SRV-1") {
  for (int to = 1; to <= 12; to++) {
    for (int passed = 0; passed < 8; passed++) {
      struct mc *mc = mock_open(&m, 1);
      CHANGE(mc, 0, par.clkdivisor = 8);
      while (mc_state_of(mc, 0)->fbnow == mc_state_of(mc, 0)->encnow) { /* right after a sample */
        m.card[0].count[0]++;
        mock_pass(&m);
      }
      while (mc_state_of(mc, 0)->fbnow != mc_state_of(mc, 0)->encnow) mock_pass(&m);
      for (int i = 0; i < passed; i++) mock_pass(&m);
      CHANGE(mc, 0, par.clkdivisor = to);
      m.card[0].count[0] = 999;
      int due = 7 - passed < to - 1 ? 7 - passed : to - 1;
      for (int i = 0; i < due; i++) {
        mock_pass(&m);
        CHECK(mc_state_of(mc, 0)->fbnow != 999);
      }
      mock_pass(&m);
      CHECK_EQ(mc_state_of(mc, 0)->fbnow, 999);
    }
  }
}

TEST(test_axes_wait_each_by_itself, "SRV-1 DRV-7") {
  struct mc *mc = mock_open(&m, 2);
  static const int divisors[] = {3, 1, 2, 5};
  int samples[4] = {0};
  for (int axis = 0; axis < 4; axis++) {
    CHANGE(mc, axis, par.clkdivisor = divisors[axis], par.mode = MD_TEST1);
  }
  call(mc, MENABLE, 0);
  for (int axis = 0; axis < 4; axis++) samples[axis] = mc_state_of(mc, axis)->inow;
  for (int pass = 1; pass <= 60; pass++) {
    mock_pass(&m);
    int due = 0;
    for (int axis = 0; axis < 4; axis++) due += pass % divisors[axis] == 0;
    CHECK_EQ(m.computed_axes, due);
  }
  for (int axis = 0; axis < 4; axis++) {
    CHECK_EQ(mc_state_of(mc, axis)->inow - samples[axis], 60 / divisors[axis]);
  }
}

TEST(test_a_code_is_for_axes_that_are_off, "DRV-12 SRV-6") {
  struct mc *mc = mock_open(&m, 1);
  call(mc, MENABLE, 0);
  for (int mode = 0; mode < 16; mode++) {
    int off = mode < MD_POS || mode > MD_TEST1;
    int arg = (int)0xFFF92301u; /* what is above the code does not matter */
    set_mode(mc, 1, MD_OFF);
    set_mode(mc, 1, mode | ZEROFB);
    CHECK_EQ(mc_ioctl(mc, 0, MSETDAC, &arg), off ? 0 : -MC_EINVAL);
    mock_pass(&m);
    CHECK_EQ(mock_dac(&m, 1), off ? 0x923 : 0x800);
    CHECK_EQ(mc_state_of(mc, 1)->inow, off ? 0x923 - 0x800 : 0);
    CHECK_EQ(mock_dac(&m, 0), 0x800);
    set_mode(mc, 1, mode | ZEROFB | POSCHK); /* the same mode: held */
    mock_pass(&m);
    if (off) CHECK_EQ(mock_dac(&m, 1), 0x923);
    set_mode(mc, 1, mode ^ 15); /* another one: let go */
    set_mode(mc, 1, MD_OFF);
    mock_pass(&m);
    CHECK_EQ(mock_dac(&m, 1), 0x800);
  }
  int none = 128; /* the axis has eight bits: this is not axis 0 */
  CHECK_EQ(mc_ioctl(mc, 0, MSETLED, &none), -MC_EINVAL);
}

static int end(struct mc *mc, int axis) {
  return mc_ioctl(mc, 0, MCALIBEND, &axis);
}

TEST(test_the_end_of_one_calibration, "DRV-8 CAL-1") {
  struct mc *mc = mock_open(&m, 2);
  call(mc, MCALIB, 2);
  call(mc, MCALIB, 3);
  CHECK_EQ(end(mc, 2), 0);
  CHECK_EQ(m.card[1].b, 0x11); /* the other still waits */
  pass_index(&m, 2, 40);
  mock_run(&m, 5000);
  CHECK_EQ(errcode_of(&m, 2), 0);
  pass_index(&m, 3, 60);
  mock_pass(&m);
  CHECK_EQ(errcode_of(&m, 3), 60 << 16 | 3 << 8 | MERR_ZINDEX);
  CHECK_EQ(m.card[1].b, 5);
}

/* What the index has latched meanwhile is nobody's position. */
TEST(test_the_end_leaves_the_position, "DRV-8 DRV-11") {
  struct mc *mc = mock_open(&m, 1);
  call(mc, MCALIB, 0);
  mock_run(&m, 5000);
  pass_index(&m, 0, 300);
  m.logging = 1;
  CHECK_EQ(end(mc, 0), 0);
  TRAFFIC(W(0x003, 5), PAIR(0x009));
  m.logging = 0;
  mock_run(&m, 5000);
  CHECK_EQ(errcode_of(&m, 0), 0);
  CHECK_EQ(mc_state_of(mc, 0)->encnow, 317);
  call(mc, MCALIB, 0); /* and it can be asked for again */
  pass_index(&m, 0, 320);
  mock_run(&m, 5000);
  CHECK_EQ(errcode_of(&m, 0), 320 << 16 | MERR_ZINDEX);
}
