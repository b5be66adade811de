/* SPDX-License-Identifier: Apache-2.0 */
/* Cards that are silent for a while, resets and bus errors: counts and who is told. §2.3.4 */
#include "traffic.h"

static struct mc *at(struct mc *mc, int axis, int32_t place) {
  for (int32_t count = 20000; count < place; count += 20000) {
    m.card[axis / 2].count[axis & 1] = (uint16_t)count;
    mock_run(&m, 2000);
  }
  m.card[axis / 2].count[axis & 1] = (uint16_t)place;
  mock_run(&m, 4000);
  CHECK_EQ(mc_state_of(mc, axis)->encnow, place);
  return mc;
}

static int enable_anew(struct mc *mc) {
  said[0] = 0;
  return enable(mc);
}

/* The ribbon cable: no card answers, nor takes what is written. */
static void cable(int plugged) {
  m.card[0].present = m.card[1].present = plugged;
  m.estop_open = !plugged;
}

static int cause(const struct mc *mc) {
  int number, cause = mc_cause(mc, &number);
  CHECK_EQ(number, -1); /* no axis's, no card's */
  return cause;
}

TEST(test_a_short_silence_leaves_the_count_whole, "DRV-13 DRV-10") {
  for (int enabled = 0; enabled < 2; enabled++) {
    for (int us = 500; us <= 6000; us += 500) {
      struct mc *mc = at(listening(2), 2, 171586);
      set_mode(mc, 2, MD_POS);
      if (enabled) CHECK_EQ(enable_anew(mc), 0);
      mock_run(&m, 10000);
      cable(0);
      mock_run(&m, us);
      cable(1);
      m.card[1].count[0] = (uint16_t)(171586 + 30000);
      mock_run(&m, 100000);
      CHECK_EQ(mc_state_of(mc, 2)->encnow, 201586);
      CHECK_EQ(m.card[1].b & 2, 0); /* what the silence swallowed was written again */
      CHECK_EQ(enable_anew(mc), 0);
      CHECK_EQ(mc_setpoint(mc, 2), 201586);
      CHECK_EQ(said[0], 0);
    }
  }
}

/* 32768 counts at 4 million a second. A slower robot has more time. */
TEST(test_a_long_silence_loses_the_count, "DRV-13") {
  static const struct {
    uint32_t speed;
    int us, lost;
  } cases[] = {{0, 6000, 0},        {0, 12000, 1},       {4000000, 12000, 1}, {100000, 12000, 0},
               {100000, 320000, 0}, {100000, 335000, 1}, {8000000, 6000, 1}};
  for (unsigned i = 0; i < COUNT(cases); i++) {
    for (int cure = 0; cure < 5; cure++) {
      int axis = cure & 1;
      struct mc *mc = at(listening(2), axis, 100000);
      cable(0); /* all is well again after a short silence */
      mock_run(&m, 3000);
      cable(1);
      mock_run(&m, 5000);
      int alone = cure == 3; /* card 0 answers all the time: its counts are whole */
      mc->config.speed = cases[i].speed;
      set_mode(mc, axis, MD_POS);
      cable(0);
      m.card[0].present = alone;
      mock_run(&m, cases[i].us);
      cable(1);
      mock_run(&m, 5000);
      const char *last = alone ? said : strstr(said, "mc: card 1");
      const char *line = "mc: card 1 was silent for too long: its counts are lost\n";
      CHECK_EQ(last && strcmp(last, line) == 0, cases[i].lost);
      CHECK_EQ(strstr(said, "mc: card 0 was silent") == said, cases[i].lost && !alone);
      CHECK_EQ(enable_anew(mc), cases[i].lost && !alone ? -MC_EIO : 0);
      if (cases[i].lost && !alone) {
        char why[] = "mc: enable: axis 0: its count was lost: MSETENC or MCALIB first\n";
        *strchr(why, '0') = (char)('0' + axis);
        SAID(why);
        CHECK_EQ(m.card[0].b & 2, 0);
        if (cure == 0) call(mc, MSETENC, 5 << 8);
        if (cure == 1) set_mode(mc, 1, MD_VEL); /* which needs no place */
        if (cure == 2) {
          call(mc, MCALIB, 0);
          m.card[0].index[0] = 1;
          mock_run(&m, 4000);
          CHECK_EQ(errcode_of(&m, 0) & MERR_ZINDEX, MERR_ZINDEX);
        }
        if (cure == 4) call(mc, MSETNUMJOINTS, 0); /* without that axis */
        CHECK_EQ(enable_anew(mc), 0);
      }
    }
  }
}

/* A reset card has forgotten modes and counts. */
TEST(test_a_reset_card_needs_calibration, "DRV-13 PAN-2") {
  for (int mode = MD_POS; mode <= MD_TORQ; mode++) {
    for (int seen = 0; seen < 2; seen++) { /* by a pass: it may come back between two */
      struct mc *mc = at(listening(2), 3, 171586);
      set_mode(mc, 3, mode);
      if (seen) cable(0);
      mock_run(&m, 2500);
      m.card[1].a = m.card[1].b = 0;
      m.card[1].count[1] = 77;
      cable(1);
      mock_run(&m, seen ? 5000 : 0);
      if (seen) CHECK_EQ(mc_state_of(mc, 3)->encnow, 77);
      CHECK_EQ(enable_anew(mc), mode == MD_POS ? -MC_EIO : 0);
      CHECK_EQ(mc_state_of(mc, 3)->encnow, seen || mode != MD_POS ? 77 : 171586);
    }
  }
}

/* What was not known at the last close is not known at the next open, which forgets a silence that
 * had no end before. */
TEST(test_an_open_does_not_find_a_lost_count_again, "DRV-13 DRV-2") {
  for (int seen = 0; seen < 2; seen++) {
    struct mc *mc = at(listening(2), 1, 100000);
    cable(0);
    mock_run(&m, 20000);
    if (seen) cable(1);
    mock_run(&m, 5000);
    CHECK_EQ(mc_close(mc, 0), 0);
    cable(1);
    CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
    set_mode(mc, 1, MD_POS);
    CHECK_EQ(enable_anew(mc), seen ? -MC_EIO : 0);
  }
}

TEST(test_a_bus_error_is_told_once, "DRV-13") {
  for (int enabled = 0; enabled < 2; enabled++) {
    struct mc *mc = listening(1);
    CHECK_EQ(mc_open(mc, MC_O_RDWR), 1);
    CHECK_EQ(mc_open(mc, MC_O_RDONLY), 2);
    if (enabled) CHECK_EQ(enable_anew(mc), 0);
    for (int round = 1; round < 3; round++) {
      said[0] = 0;
      m.adaptor_dead = 1;
      for (int i = 0; i < 5; i++) CHECK_EQ(mc_interrupt(mc), 0);
      SAID("mc: PANIC: bus error in a servo pass\n");
      for (int client = 0; client < 3; client++)
        CHECK_EQ(m.signals[client], client < 2 ? round : 0);
      CHECK_EQ(errcode_of(&m, 1), 0x100 | MERR_PANIC);
      CHECK_EQ(mc_stats_of(mc)->panics, round);
      CHECK_EQ(cause(mc), MCAUSE_BUS);
      m.adaptor_dead = 0;
      mock_run(&m, 100000);
      CHECK_EQ(mc_ioctl(mc, 0, MCLEARERROR, NULL), 0);
    }
  }
}

TEST(test_sysreset_is_told_and_the_state_goes_on, "DRV-13 PAN-2") {
  for (int enabled = 0; enabled < 2; enabled++) {
    struct mc *mc = at(listening(2), 1, 100000);
    CHECK_EQ(mc_open(mc, MC_O_RDONLY), 1);
    set_mode(mc, 1, MD_POS);
    if (enabled) CHECK_EQ(enable_anew(mc), 0);
    mock_run(&m, 10000);
    CHECK_EQ(mc_watch(mc, 0), 0);
    CHECK_EQ(mc_watch(mc, 53999), 0); /* two intervals and 50 ms */
    m.pccsr = 0;
    for (int card = 0; card < 2; card++) {
      m.card[card].a = m.card[card].b = 0;
      m.card[card].count[0] = m.card[card].count[1] = 0;
    }
    mock_run(&m, 54000);
    CHECK_EQ(m.signals[0], 0);
    CHECK_EQ(mc_watch(mc, 54000), 1);
    CHECK_EQ(cause(mc), MCAUSE_RESET);
    CHECK_EQ(m.signals[0], 1);
    CHECK_EQ(m.signals[1], 0);
    for (int axis = 0; axis < 4; axis++) CHECK_EQ(errcode_of(&m, axis), axis << 8 | MERR_PANIC);
    CHECK_EQ(strstr(said, "mc: PANIC: PCCSR changed, by SYSRESET* or a program\n") != NULL, 1);
    CHECK_EQ(mc_watch(mc, 100000), 0);
    CHECK_EQ(m.signals[0], 1);
    m.card[0].count[1] = 12;
    mock_run(&m, 5000);
    CHECK_EQ(mc_state_of(mc, 1)->encnow, 12);
    CHECK_EQ(enable_anew(mc), -MC_EIO); /* in MD_POS, with a count that was cleared */
    set_mode(mc, 1, MD_OFF);
    CHECK_EQ(cause(mc), MCAUSE_RESET); /* until an MENABLE succeeds */
    CHECK_EQ(enable_anew(mc), 0);
    CHECK_EQ(cause(mc), MCAUSE_NONE);
  }
}

/* Interrupts are off while SYSRESET* is low, and the adaptor does not answer; the host's clock
 * looks again until it does. Within 50 ms nobody sees it low. */
TEST(test_sysreset_of_any_length_is_told_once_and_samples_come_back, "DRV-13 PAN-2") {
  static const int ms[] = {1, 30, 55, 70, 100, 300, 1000};
  for (unsigned i = 0; i < 2 * COUNT(ms); i++) {
    struct mc *mc = listening(2);
    if (i % 2) CHECK_EQ(enable_anew(mc), 0);
    mock_run(&m, 10000);
    said[0] = 0;
    int64_t now = m.now, end = now + 1000 * ms[i / 2];
    int told = 0;
    m.pccsr = 0;
    for (int passes = m.passes; m.passes < passes + 3; mock_run(&m, 10000)) {
      m.adaptor_dead = m.now < end;
      if (passes == m.passes) told += mc_watch(mc, (uint64_t)(m.now - now));
      CHECK(m.now < end + 100000);
    }
    CHECK_EQ(told, 1);
    CHECK_EQ(m.signals[0], 1);
    CHECK_EQ(mc_stats_of(mc)->panics, 1);
    CHECK_EQ(cause(mc), ms[i / 2] < 60 ? MCAUSE_RESET : MCAUSE_BUS);
    const char *panic = strstr(said, "PANIC"); /* then cards, whose counts may be lost */
    CHECK(panic != NULL && strstr(panic + 1, "PANIC") == NULL);
    CHECK_EQ(enable_anew(mc), 0);
  }
}

/* Cards whose counters went on alone: too long for any axis, but not for a slow one. */
TEST(test_sysreset_may_leave_the_counts, "DRV-13") {
  for (int slow = 0; slow < 2; slow++) {
    struct mc *mc = at(listening(2), 1, 100000);
    mc->config.speed = slow ? 500000 : 0;
    set_mode(mc, 1, MD_POS);
    m.pccsr = slow ? 0 : MMCS_PCCSR_LATCH_EN_bm; /* by a program */
    m.card[0].count[1] = (uint16_t)(100000 + 20000);
    mock_run(&m, 54000);
    m.panic_latch = 1;
    CHECK_EQ(mc_watch(mc, 54000), 1);
    CHECK_EQ(m.panic_latch, 0);
    mock_run(&m, 5000);
    CHECK_EQ(mc_state_of(mc, 1)->encnow, 120000);
    CHECK_EQ(enable_anew(mc), slow ? 0 : -MC_EIO);
  }
}

/* The adaptor is as it was, or gone. */
TEST(test_the_end_of_interrupts_is_told, "DRV-13") {
  for (int dead = 0; dead < 2; dead++) {
    for (int enabled = 0; enabled < 2; enabled++) {
      struct mc *mc = listening(1);
      if (enabled) CHECK_EQ(enable_anew(mc), 0);
      said[0] = 0;
      m.adaptor_dead = dead;
      m.vector = 0x13; /* by whatever ended them */
      int told = dead || enabled;
      for (int i = 0; i < 3; i++) CHECK_EQ(mc_watch(mc, 60000), told && i == 0);
      CHECK_EQ(m.signals[0], told);
      CHECK_EQ(mc_stats_of(mc)->panics, told);
      CHECK_EQ(cause(mc), dead ? MCAUSE_BUS : told ? MCAUSE_LATE : MCAUSE_NONE);
      SAID(dead   ? "mc: PANIC: no interrupts, the adaptor does not answer\n"
           : told ? "mc: PANIC: no interrupts\n"
                  : "");
      CHECK_EQ(m.vector, dead ? 0x13 : 0x40);
      m.adaptor_dead = 0;
      CHECK_EQ(mc_close(mc, 0), 0);
      CHECK_EQ(mc_watch(mc, 60000), 0); /* nobody has it open */
      CHECK_EQ(m.signals[0], told);
    }
  }
}

static struct mc *enabled(int mode) {
  struct mc *mc = mock_open(&m, 1);
  set_mode(mc, 0, mode);
  CHECK_EQ(enable_anew(mc), 0);
  return mc;
}

TEST(test_failed_dac_write_is_repaired_or_ends_in_panic, "DRV-7 DRV-9") {
  struct mc *mc = enabled(MD_TORQ);
  DEMAND(mc, 300);
  m.dac_errors = 2;
  mock_run(&m, 2100);
  CHECK_EQ(m.dac_errors, 0);
  CHECK_EQ(mock_dac(&m, 0), 0x800);
  mock_run(&m, 2000);
  CHECK_EQ(mock_dac(&m, 0), 0x800 + 300);
  CHECK_EQ(mc_state_of(mc, 0)->errcode, 0);
  m.dac_errors = 1000000; /* for good: the heartbeats die, the next pass finds that */
  mock_run(&m, 54000);
  CHECK_EQ(mc_state_of(mc, 0)->errcode, MERR_PANIC);
  CHECK(mock_panic(&m));
  CHECK_EQ(m.card[0].b & 2, 0); /* and isolates the joints */
}

/* Of several cards the first that does not answer is named, and the others are left alone. */
TEST(test_enable_stops_at_the_first_card_that_is_silent, "DRV-9 DRV-12") {
  struct mc *mc = mock_open(&m, 3);
  for (int first = 0; first < 3; first++) {
    for (int card = 0; card < 3; card++) m.card[card].present = card < first;
    m.logging = 1;
    m.used = 0;
    CHECK_EQ(enable_anew(mc), -MC_EIO);
    CHECK_EQ(m.last_log[(int)strlen("mc: enable: card ")], '0' + first);
    for (int i = 0; i < m.used; i++) CHECK(m.log[i].offset < (first + 1) << 6);
  }
}

static enum mc_bus_result (*good_read)(void *ctx, uint16_t offset, uint8_t *value);
static int countdown;

static enum mc_bus_result fail_once(void *ctx, uint16_t offset, uint8_t *value) {
  enum mc_bus_result result = good_read(ctx, offset, value);
  if (!m.serving || countdown-- != 0) return result;
  *value = 0xFF;
  return MC_BUS_ERROR;
}

/* Whichever read of a pass fails: one PANIC, no SCLOCK that was not. */
TEST(test_a_read_that_failed_is_one_panic, "DRV-7 DRV-9") {
  for (int which = 0; which < 15; which++) {
    struct mc *mc = enabled(MD_POS);
    mock_run(&m, 2000 - (m.now - m.origin) % 2000 + 1000);
    good_read = mc->bus.read8;
    mc->bus.read8 = fail_once;
    countdown = which;
    mock_run(&m, 2000);
    CHECK(countdown < 0);
    CHECK_EQ(mc_stats_of(mc)->panics, 1);
    mock_run(&m, 100000);
    CHECK_EQ(mc_stats_of(mc)->panics, 1);
    CHECK_EQ(mc_stats_of(mc)->missed, which == 0); /* PCCSR: nobody knows of the SCLOCK */
  }
}

/* A pass between the checks of two cards meets a bus error: MENABLE blames no card for it. */
TEST(test_enable_is_not_refused_for_the_bus_error_of_a_pass, "DRV-9") {
  struct mc *mc = listening(2);
  mock_run(&m, 2000 - (m.now - m.origin) % 2000 - 3);
  good_read = mc->bus.read8;
  mc->bus.read8 = fail_once;
  countdown = 0;
  CHECK_EQ(enable(mc), 0);
  CHECK(countdown < 0);
}
