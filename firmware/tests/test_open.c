/* SPDX-License-Identifier: Apache-2.0 */
/* Attach, open, scan, close, read and write: traffic, limits, and what a later one finds. §2.3.1 */
#include "traffic.h"

TEST(test_attach_takes_what_the_adaptor_can_have, "DRV-1") {
  static const uint32_t good[] = {8000000, 4000000, 2000000, 1000000};
  static const uint32_t bad[] = {0,       1,       999999,  1000001,  3000000,
                                 6000000, 7999999, 8000001, 16000000, UINT32_MAX};
  struct mc *mc = mock_start(&m, 1);
  struct mc_config config = {.vector = 0x40};
  m.logging = 1;
  for (unsigned i = 0; i < COUNT(good); i++) {
    config.sysclk_hz = good[i];
    CHECK_EQ(mc_attach(mc, &m.bus, &m.os, &config), 0);
  }
  for (unsigned i = 0; i < COUNT(bad); i++) {
    config.sysclk_hz = bad[i];
    CHECK_EQ(mc_attach(mc, &m.bus, &m.os, &config), -MC_EINVAL);
  }
  config.sysclk_hz = 8000000;
  CHECK_EQ(mc_attach(NULL, &m.bus, &m.os, &config), -MC_EINVAL);
  CHECK_EQ(mc_attach(mc, NULL, &m.os, &config), -MC_EINVAL);
  CHECK_EQ(mc_attach(mc, &m.bus, NULL, &config), -MC_EINVAL);
  CHECK_EQ(mc_attach(mc, &m.bus, &m.os, NULL), -MC_EINVAL);
  CHECK_EQ(m.used, 0); /* the hardware has seen nothing */
  CHECK(mc_size() >= sizeof(struct mc));
}

TEST(test_attach_begins_anew, "DRV-1 DRV-2") {
  struct mc *mc = mock_open(&m, 2);
  struct mc_config config = {.sysclk_hz = 8000000, .vector = 0x77};
  struct mc_state state;
  for (int i = 1; i < MC_MAX_CLIENTS; i++) CHECK_EQ(mc_open(mc, MC_O_RDWR), i);
  CHECK_EQ(mc_open(mc, MC_O_RDONLY), -MC_ENFILE);
  CHECK_EQ(mc_read(mc, MC_MAX_CLIENTS, &state, 28), -MC_EBADF);
  CHECK_EQ(enable(mc), 0);
  CHECK_EQ(mc_attach(mc, &m.bus, &m.os, &config), 0);
  CHECK_EQ(mc_joints(mc), 0);
  CHECK(!mc_is_enabled(mc) && !mc_is_stopped(mc));
  for (int i = 0; i < MC_MAX_CLIENTS; i++) CHECK_EQ(mc_read(mc, i, &state, 28), -MC_EBADF);
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
  CHECK_EQ(m.vector, 0x77);
  CHECK_EQ(mc_joints(mc), 4);
  mock_run(&m, 2100); /* not enabled: only looks */
  CHECK_EQ(m.card[0].b, 5);
  CHECK_EQ(enable(mc), 0);
  CHECK_EQ(mc_halt(mc), 0);
  CHECK_EQ(mc_attach(mc, &m.bus, &m.os, &config), 0);
  CHECK(!mc_is_stopped(mc));
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
  mock_run(&m, 60000);
  CHECK_EQ(mc_stats_of(mc)->panics, 1); /* of the stop before, which nobody knows */
  CHECK_EQ(mc_close(mc, 0), 0);
  CHECK_EQ(m.pccsr, 0x18); /* nobody is left */
}

static int add(struct mock_access *want, int n, int write, unsigned offset, unsigned value) {
  want[n] = (struct mock_access){write, (uint16_t)offset, (uint8_t)value};
  return n + 1;
}

TEST(test_first_open_traffic, "DRV-2 DRV-3 DIA-2") {
  static const uint8_t pattern[] = {0xA8, 0x50, 0x00}; /* never a counting mode */
  static const unsigned timers[][2] = {{0x409, 0x18}, {0x407, 0x70}, {0x407, 0xB4}, {0x405, 0},
                                       {0x405, 0},    {0x407, 0x34}, {0x401, 0x40}, {0x401, 0x1F},
                                       {0x407, 0x74}, {0x403, 0x02}, {0x403, 0x00}, {0x409, 0xB8}};
  struct mock_access want[260];
  struct mc *mc = mock_start(&m, 0);
  int n = 0;
  m.card[3].present = m.card[15].present = 1;
  n = add(want, n, 1, 0x409, 0x18);
  n = add(want, n, 0, 0x409, 0);
  n = add(want, n, 1, 0x441, 0x40);
  for (unsigned dip = 0; dip < 16; dip++) {
    unsigned base = dip << 6 | 1;
    int there = dip == 3 || dip == 15;
    for (unsigned reg = 0; reg < 3; reg++) n = add(want, n, 0, base + 2 * reg, 0); /* at work? */
    n = add(want, n, 1, base + 6, 0x89);
    for (unsigned i = 0; i < (there ? 3 : 1); i++) { /* port A is written and read back */
      n = add(want, n, 1, base, pattern[i]);
      n = add(want, n, 0, base, 0);
    }
    if (!there) continue;
    n = add(want, n, 1, base + 6, 0x89);
    n = add(want, n, 1, base, 0); /* counting off, joints in, counting on */
    n = add(want, n, 1, base + 2, 5);
    for (unsigned i = 0; i < 4; i++) n = add(want, n, 0, base + 2, 0);
    n = add(want, n, 1, base, 5);
  }
  for (unsigned axis = 0; axis < 4; axis++) {
    unsigned msb = (axis < 2 ? 3u << 6 : 15u << 6) + 1 + (axis % 2 ? 12 : 8);
    for (int i = 0; i < 2; i++) { /* twice: the first may be what was latched before */
      n = add(want, n, 0, (msb & ~0x3Fu) | 5, 0);
      n = add(want, n, 0, msb, 0);
      n = add(want, n, 0, msb + 2, 0);
    }
  }
  for (unsigned i = 0; i < COUNT(timers); i++) {
    n = add(want, n, 1, timers[i][0], timers[i][1]);
  }
  m.logging = 1;
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
  traffic_check(__FILE__, __LINE__, &m, want, n);
  CHECK_EQ(m.masked, 0);
  CHECK_EQ(mc_joints(mc), 4);
  m.used = 0;
  CHECK_EQ(mc_open(mc, MC_O_RDONLY), 1); /* a later open touches nothing */
  CHECK_EQ(m.used, 0);
}

/* By read(), before the first sample: the start of SCLOCK has begun a conversion, and what encoders
 * had latched long ago is out of the way. */
TEST(test_state_is_known_from_the_open_on, "DRV-2 DRV-4 DRV-10") {
  static const int32_t counts[] = {0x1234, -2, 0x7FFF, -0x8000};
  struct mc *mc = mock_start(&m, 2);
  struct mc_state state[4];
  for (int axis = 0; axis < 4; axis++) {
    m.card[axis / 2].count[axis & 1] = (uint16_t)counts[axis];
    m.card[axis / 2].latched[axis & 1] = 99;
    m.card[axis / 2].has_latch[axis & 1] = 1;
    m.card[axis / 2].adc[axis & 1] = (uint16_t)(700 + axis);
  }
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
  int64_t converted = m.card[0].adc_until;
  for (int dead = 0; dead < 2; dead++) { /* no conversion ends, or the adaptor does not answer */
    m.card[0].adc_until = m.card[1].adc_until = dead ? converted : INT64_MAX;
    m.adaptor_dead = dead;
    CHECK_EQ(mc_read(mc, 0, state, sizeof state), (int)sizeof state);
    for (int axis = 0; axis < 4; axis++) CHECK_EQ(state[axis].adcvai, 0);
  }
  m.adaptor_dead = 0;
  CHECK_EQ(mc_read(mc, 0, state, sizeof state), (int)sizeof state);
  CHECK_EQ(mc_stats_of(mc)->total, 0); /* no sample yet */
  for (int axis = 0; axis < 4; axis++) {
    const struct mc_state want = {.encnow = counts[axis], .adcvai = 700 + axis};
    CHECK(memcmp(&state[axis], &want, sizeof want) == 0);
  }
  m.card[0].adc[0] = 5;
  mock_run(&m, 4100);
  for (int axis = 0; axis < 4; axis++) CHECK_EQ(mc_state_of(mc, axis)->encnow, counts[axis]);
  m.card[0].adc[0] = 6; /* from the first sample on, what the last one found */
  CHECK_EQ(mc_read(mc, 0, state, sizeof state), sizeof state);
  CHECK_EQ(state[0].adcvai, 5);
  CHECK_EQ(m.masked, 0);
}

static uint8_t hole;

static enum mc_bus_result read_holes(void *ctx, uint16_t offset, uint8_t *value) {
  (void)ctx;
  (void)offset;
  *value = hole; /* answers, but is no adaptor */
  return MC_BUS_OK;
}

TEST(test_an_open_that_failed_leaves_nothing_behind, "DRV-2") {
  struct mc *mc = mock_start(&m, 1);
  struct mc_bus good = mc->bus;
  for (int way = 0; way < 3; way++) {
    m.adaptor_dead = way == 0;
    hole = way == 1 ? 0xFF : 0x00;
    if (way > 0) mc->bus.read8 = read_holes;
    m.logging = 1;
    m.used = 0;
    CHECK_EQ(mc_open(mc, MC_O_RDWR), -MC_ENXIO);
    CHECK_EQ(m.used, way > 0); /* nothing but PCCSR was tried */
    CHECK_EQ(m.masked, 0);
    CHECK_EQ(mc_close(mc, 0), -MC_EBADF);
  }
  mc->bus = good;
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0); /* the first open all the same */
  CHECK_EQ(mc_joints(mc), 2);
}

TEST(test_last_close_is_silent_and_says_no_more_than_it_must, "DRV-2 DRV-6") {
  struct mc *mc = mock_open(&m, 1);
  m.logging = 1;
  CHECK_EQ(mc_close(mc, 0), 0);
  TRAFFIC(W(0x409, 0x18));
  CHECK_EQ(m.logs, 0); /* no A/D was late */
  CHECK_EQ(m.masked, 0);
  CHECK_EQ(mc_close(mc, 0), -MC_EBADF);
  for (int flags = MC_O_RDONLY; flags <= MC_O_RDWR; flags++) { /* any way of opening starts */
    CHECK_EQ(mc_open(mc, flags), 0);
    CHECK_EQ(m.pccsr, 0xB8);
    CHECK_EQ(mc_close(mc, 0), 0);
    CHECK_EQ(m.pccsr, 0x18);
  }
  CHECK_EQ(mc_open(mc, -1), -MC_EINVAL);
}

/* Which signals an encoder gives, and which the switch of the cards gives before and after, must
 * make no difference: whatever is opened, stopped, switched or closed, the counts stay. */
TEST(test_nothing_but_motion_moves_a_count, "DRV-2 DRV-9 DRV-10 DIA-2") {
  for (int joint = 0; joint < 16; joint++) {
    struct mc *mc = mock_start(&m, 1);
    int modes[] = {M_ENDIAG, 0, M_ANDIAG | M_ENDIAG, M_ANDIAG, 0, M_ENDIAG};
    struct mc_state state[2];
    for (int j = 0; j < 2; j++) {
      m.card[0].joint[j] = joint >> 2 * j & 3;
      m.card[0].count[j] = (uint16_t)(0x7FFE + j);
    }
    for (int round = 0; round < 4; round++) {
      if (round == 2) m.card[0].a = m.card[0].b = 0; /* as after RESET DRV, but for the counts */
      CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
      for (unsigned i = 0; i < COUNT(modes); i++) {
        CHECK_EQ(mc_ioctl(mc, 0, MDIAGMODE, &modes[i]), 0);
        mock_run(&m, 3000);
        if (i == 1 || i == 3) CHECK_EQ(enable(mc), 0);
        if (i == 4) CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
        CHECK_EQ(mc_read(mc, 0, state, sizeof state), (int)sizeof state);
        for (int j = 0; j < 2; j++) CHECK_EQ(state[j].encnow, 0x7FFE + j);
      }
      CHECK_EQ(mc_close(mc, 0), 0); /* with the artificial signals on */
      for (int j = 0; j < 2; j++) CHECK_EQ(m.card[0].count[j], 0x7FFE + j);
    }
  }
}

/* While nobody has the device open the counters go on; so do positions beyond 16 bits, here of
 * either sign, as long as the card keeps its power. */
TEST(test_positions_survive_a_close, "DRV-2 DRV-10") {
  struct mc *mc = mock_open(&m, 2);
  for (int axis = 0; axis < 4; axis++) {
    for (int i = 1; i <= 5; i++) {
      m.card[axis / 2].count[axis & 1] = (uint16_t)((axis < 2 ? -20000 : 20000) * i + axis);
      mock_run(&m, 2000);
    }
  }
  CHECK_EQ(mc_state_of(mc, 1)->encnow, -99999);
  CHECK_EQ(mc_close(mc, 0), 0);
  m.card[1].count[0] = (uint16_t)(100002 + 30000); /* pushed by hand */
  m.card[0].b = 0x0D;                              /* double-buffered: as another program left it */
  m.logging = 1;
  CHECK_EQ(mc_open(mc, MC_O_RDONLY), 0);
  CHECK_EQ(m.card[0].b, 5);
  for (int i = 0; i < m.used; i++) { /* counting was never off: an axis may be in motion */
    if (!m.log[i].write || m.log[i].offset > 0x047) continue;
    if ((m.log[i].offset & 0x3F) == 0x01) CHECK_EQ(m.log[i].value & 7, 5);
    if ((m.log[i].offset & 0x3F) == 0x03) CHECK_EQ(m.log[i].value & 1, 1);
    CHECK((m.log[i].offset & 0x3F) != 0x07);
  }
  m.logging = 0;
  for (int axis = 0; axis < 4; axis++) {
    const int places[] = {-100000, -99999, 130002, 100003};
    CHECK_EQ(mc_state_of(mc, axis)->encnow, places[axis]);
  }
  CHECK_EQ(mc_close(mc, 0), 0);
  m.card[0].present = 0; /* the other one keeps its axes' positions at their new numbers */
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
  CHECK_EQ(mc_joints(mc), 2);
  for (int axis = 0; axis < 2; axis++) {
    CHECK_EQ(mc_state_of(mc, axis)->encnow, 100002 + axis + (axis == 0 ? 30000 : 0));
  }
  m.card[0].present = 1;
  for (int reset = 0; reset < 2; reset++) { /* its encoders were cut off, or all: nobody knows */
    CHECK_EQ(mc_close(mc, 0), 0);
    if (reset) m.card[1].a = 0;
    m.card[1].b = 0;
    m.card[1].count[0] = 7;
    CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
    CHECK_EQ(mc_state_of(mc, 2)->encnow, 7);
    for (int axis = 0; axis < 2; axis++) { /* of the other card: new, then known */
      CHECK_EQ(mc_state_of(mc, axis)->encnow, reset ? 80000 : (int16_t)m.card[0].count[axis]);
    }
    for (int i = 1; i <= 4; i++) {
      for (int axis = 0; axis < 3; axis++) {
        m.card[axis / 2].count[axis & 1] = (uint16_t)(20000 * i);
      }
      mock_run(&m, 2000);
    }
  }
}

/* The first writer after there was none starts afresh; counts go on. */
TEST(test_a_new_writer_starts_as_if_it_were_alone, "DRV-2") {
  for (int watched = 0; watched < 2; watched++) { /* by a monitor, meanwhile */
    struct mc *mc = listening(2);
    static const struct mc_stats none;
    if (watched) CHECK_EQ(mc_open(mc, MC_O_RDONLY), 1);
    for (int i = 1; i <= 5; i++) {
      m.card[1].count[0] = (uint16_t)(20000 * i);
      mock_run(&m, 2000);
    }
    call(mc, MDACMODE, 1);
    call(mc, MCALIB, 0);
    call(mc, MDIAGMODE, M_ANDIAG | M_ENDIAG);
    mc_spurious(mc);
    CHECK_EQ(mc_close(mc, 0), 0);
    mock_run(&m, 5000);
    CHECK_EQ(m.card[0].b, 5);                        /* the joints' encoders count again */
    m.card[1].count[0] = (uint16_t)(100000 + 30000); /* pushed by hand */
    mock_run(&m, 5000);
    CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
    CHECK(memcmp(mc_stats_of(mc), &none, sizeof none) == 0);
    CHECK_EQ(mc_state_of(mc, 2)->encnow, 130000);
    set_mode(mc, 1, MD_POS);
    m.card[0].count[1] = 44;
    call(mc, MENABLE, 0);
    CHECK_EQ(mc_setpoint(mc, 1), 44);
    for (int card = 0; card < 2; card++) CHECK_EQ(m.card[card].b, 7); /* no calibration is left */
  }
}

/* The open for writing fails; the monitor goes on. */
TEST(test_a_writer_that_cannot_open_leaves_the_monitor_alone, "DRV-2") {
  for (int dead = 0; dead < 2; dead++) { /* or answers as no adaptor does */
    struct mc *mc = mock_start(&m, 1);
    struct mc_bus good = mc->bus;
    CHECK_EQ(mc_open(mc, MC_O_RDONLY), 0);
    mock_run(&m, 5000);
    m.adaptor_dead = dead;
    hole = 0;
    mc->bus.read8 = read_holes;
    CHECK_EQ(mc_open(mc, MC_O_RDWR), -MC_ENXIO);
    m.adaptor_dead = 0;
    mc->bus = good;
    CHECK_EQ(mc->pccsr, 0xB8);
    m.card[0].count[0] = 99;
    mock_run(&m, 5000);
    CHECK_EQ(mc_state_of(mc, 0)->encnow, 99);
    CHECK_EQ(mc_open(mc, MC_O_RDWR), 1);
  }
}

TEST(test_a_write_after_a_shutdown_is_refused, "DRV-6") {
  for (int panic = 0; panic < 2; panic++) {
    struct mc *mc = listening(1);
    int32_t set[2] = {10, 10};
    CHECK_EQ(mc_write(mc, 0, set, 8), 8); /* before the first MENABLE, too */
    set_mode_within_100(mc, 0, MD_POS | POSCHK);
    CHECK_EQ(enable(mc), 0);
    m.estop_open = panic;
    m.card[0].count[0] = 200;
    mock_run(&m, 4000);
    CHECK_EQ(mc_is_enabled(mc), 0);
    int number;
    CHECK_EQ(mc_cause(mc, &number), panic ? MCAUSE_PASSED : MCAUSE_AXIS);
    CHECK_EQ(number, panic ? -1 : 0);
    said[0] = 0;
    for (int i = 0; i < 3; i++) CHECK_EQ(mc_write(mc, 0, set, 8), -MC_EIO);
    SAID("mc: write: shut down by an error, MENABLE first\n");
    m.estop_open = 0;
    mock_run(&m, 100000);
    set_mode_within_100(mc, 0, MD_POS);
    CHECK_EQ(enable(mc), 0);
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
  for (unsigned i = 0; i < COUNT(cases); i++) {
    int on = M_ENDIAG, off = 0, want = cases[i].needs ? -MC_EBUSY : 0;
    struct mc *mc = listening(1);
    int axis = i & 1;
    set_mode_within_100(mc, axis, cases[i].mode);
    CHECK_EQ(mc_ioctl(mc, 0, MDIAGMODE, &on), 0); /* at rest */
    CHECK_EQ(enable(mc), want);
    CHECK_EQ(mc_is_enabled(mc), !want);
    char line[] = "mc: enable: axis 0 needs its encoder, which M_ENDIAG cuts off\n";
    *strchr(line, '0') = (char)('0' + axis);
    SAID(want ? line : "");
    set_mode_within_100(mc, axis, MD_OFF);
    CHECK_EQ(enable(mc), 0);
    struct mc_param par = *mc_param_of(mc, axis);
    par.mode = cases[i].mode;
    CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), want);
    CHECK_EQ(mc_param_of(mc, axis)->mode, want ? MD_OFF : cases[i].mode);
    CHECK_EQ(mc_ioctl(mc, 0, MDIAGMODE, &off), 0);
    set_mode_within_100(mc, axis, cases[i].mode);
    CHECK_EQ(mc_ioctl(mc, 0, MDIAGMODE, &on), want);
    CHECK_EQ(mc_diag(mc), want ? 0 : M_ENDIAG);
    CHECK_EQ(m.card[0].b & 1, want != 0);
  }
  struct mc *mc = listening(1);
  set_mode(mc, 1, MD_POS);
  call(mc, MSETNUMJOINTS, 1); /* without that axis */
  call(mc, MDIAGMODE, M_ENDIAG);
  CHECK_EQ(enable(mc), 0);
}
