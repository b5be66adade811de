/* SPDX-License-Identifier: Apache-2.0 */
/* Error codes, who is told of them, and what a clear leaves; PANIC and its messages. §2.3.4 */
#include "traffic.h"

static struct mc *enabled(int cards) {
  struct mc *mc = listening(cards);
  CHECK_EQ(enable(mc), 0);
  mock_run(&m, 10000);
  return mc;
}

TEST(test_writers_are_told_readers_and_the_gone_are_not, "DRV-5") {
  struct mc *mc = listening(1);
  for (int i = 1; i < MC_MAX_CLIENTS; i++) CHECK_EQ(mc_open(mc, i % 3), i);
  CHECK_EQ(mc_close(mc, 4), 0);
  CHECK_EQ(mc_close(mc, 5), 0);
  error_signal(mc);
  for (int i = 0; i < MC_MAX_CLIENTS; i++) {
    CHECK_EQ(m.signals[i], i == 0 || (i % 3 != MC_O_RDONLY && i != 4 && i != 5));
  }
  CHECK_EQ(mc_open(mc, MC_O_RDONLY), 4); /* the place of a writer */
  error_signal(mc);
  CHECK_EQ(m.signals[4], 0);
  CHECK_EQ(m.signals[15], 0);
  CHECK_EQ(m.signals[14], 2);
}

/* --- PANIC ----------------------------------------------------------------------------------- */

TEST(test_panic_traffic, "DRV-7 DRV-9 PAN-2") {
  for (int with_sclock = 0; with_sclock < 2; with_sclock++) {
    struct mc *mc = enabled(1);
    mock_run(&m, 2000 - (m.now - m.origin) % 2000 + 500);
    m.masked = with_sclock; /* both wait for the host */
    m.estop_open = 1;
    m.logging = 1;
    if (with_sclock) mock_run(&m, 2000);
    m.masked = 0;
    mock_run(&m, 100);
    static const struct mock_access want[] = {
        R(0x409),       W(0x409, 0x78), W(0x409, 0xF8), W(0x407, 0x80),
        R(0x405),       R(0x405), /* of an SCLOCK only: was one missed? */
        R(0x005),       W(0x409, 0xB8), W(0x011, 0x00), W(0x013, 0x08),
        W(0x015, 0x00), W(0x017, 0x08), W(0x003, 0x05)};
    int n = (int)(COUNT(want));
    if (with_sclock) {
      traffic_check(__FILE__, __LINE__, &m, want, n);
    } else {
      for (int i = 0; i < 3; i++) CHECK_EQ(m.log[i].offset, want[i].offset);
      memmove(m.log, m.log + 3, (size_t)(m.used - 3) * sizeof m.log[0]);
      m.used -= 3;
      traffic_check(__FILE__, __LINE__, &m, want + 6, n - 6);
    }
    CHECK_EQ(mc_stats_of(mc)->missed, 0);
    mock_run(&m, 60000); /* nothing is missed after it either */
    CHECK_EQ(mc_stats_of(mc)->missed, 0);
  }
}

TEST(test_panic_names_who_is_silent, "DRV-9 DRV-12 PAN-2") {
  static const struct {
    unsigned dead, gone; /* axes without heartbeat, cards that do not answer */
    int cause, number;
    const char *text;
  } cases[] = {{0x00, 0, MCAUSE_PASSED, -1, "mc: PANIC: button, cable or power\n"},
               {0x01, 0, MCAUSE_HEARTBEAT, 0, "mc: PANIC: axis 0 has no heartbeat\n"},
               {0x02, 0, MCAUSE_HEARTBEAT, 1, "mc: PANIC: axis 1 has no heartbeat\n"},
               {0x03, 0, MCAUSE_HEARTBEAT, 0,
                "mc: PANIC: axis 0 has no heartbeat\nmc: PANIC: axis 1 has no heartbeat\n"},
               {0x28, 0, MCAUSE_HEARTBEAT, 3,
                "mc: PANIC: axis 3 has no heartbeat\nmc: PANIC: axis 5 has no heartbeat\n"},
               {0x00, 2, MCAUSE_CARD, 1, "mc: PANIC: card 1 does not answer\n"},
               {0x10, 2, MCAUSE_CARD, 1,
                "mc: PANIC: card 1 does not answer\nmc: PANIC: axis 4 has no heartbeat\n"},
               {0x0C, 2, MCAUSE_CARD, 1, "mc: PANIC: card 1 does not answer\n"},
               {0x00, 3, MCAUSE_CARD, 0,
                "mc: PANIC: card 0 does not answer\nmc: PANIC: card 1 does not answer\n"},
               {0x00, 7, MCAUSE_SILENT, -1,
                "mc: PANIC: card 0 does not answer\nmc: PANIC: card 1 does not answer\n"
                "mc: PANIC: card 2 does not answer\nmc: PANIC: button, cable or power\n"}};
  for (unsigned i = 0; i < COUNT(cases); i++) {
    struct mc *mc = enabled(3);
    set_mode(mc, 0, MD_TORQ | SOFTERR); /* which is for other errors */
    for (unsigned axis = 0; axis < 6; axis++) {
      if (cases[i].dead >> axis & 1) m.card[axis / 2].beat_until[axis & 1] = 0;
    }
    for (unsigned card = 0; card < 3; card++) m.card[card].present = !(cases[i].gone >> card & 1);
    m.estop_open = 1;
    mock_run(&m, 100);
    SAID(cases[i].text);
    int number;
    CHECK_EQ(mc_cause(mc, &number), cases[i].cause);
    CHECK_EQ(number, cases[i].number);
    for (int axis = 0; axis < 6; axis++) CHECK_EQ(errcode_of(&m, axis), axis << 8 | MERR_PANIC);
    CHECK_EQ(m.signals[0], 1);
    CHECK_EQ(mc_stats_of(mc)->panics, 1);
    CHECK_EQ(m.pccsr, 0xB8);
    for (unsigned axis = 0; axis < 6; axis++) {
      const struct mock_card *c = &m.card[axis / 2];
      if (!c->present) continue;
      CHECK_EQ(c->b, 5);
      CHECK_EQ(c->dac_high[axis & 1], 8);
      if (cases[i].dead >> axis & 1) CHECK_EQ(c->beat_until[axis & 1], 0);
    }
  }
  struct mc *mc = enabled(1); /* its only card is all of them */
  m.card[0].present = 0;
  mock_run(&m, 3000);
  int number;
  CHECK_EQ(mc_cause(mc, &number), MCAUSE_SILENT);
}

TEST(test_own_panic_is_forgiven_for_60_ms, "DRV-6 DRV-9") {
  for (int after = 40; after < 80; after += 2) {
    struct mc *mc = enabled(1);
    m.card[0].enabled[0] = m.card[0].enabled[1] = 0; /* no heartbeat counts in PANIC */
    mock_run(&m, 2000 - (m.now - m.origin) % 2000 + 1000);
    CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
    mock_run(&m, after * 1000);
    m.estop_open = 1;
    mock_run(&m, 4000);
    CHECK_EQ(mc_stats_of(mc)->panics, after >= 60);
    CHECK_EQ(m.signals[0], 0);
    CHECK_EQ(errcode_of(&m, 0), 0);
    m.estop_open = 0;
    mock_run(&m, 4000);
    m.estop_open = 1; /* one only */
    mock_run(&m, 4000);
    CHECK_EQ(mc_stats_of(mc)->panics, 1 + (after >= 60));
  }
}

TEST(test_overload_is_told_and_shuts_down, "DRV-2 DRV-6 SRV-4") {
  for (int soft = 0; soft < 2; soft++) {
    struct mc *mc = listening(1);
    CHANGE(mc, 1, par.mode = MD_TORQ | (soft ? SOFTERR : 0), par.ilim = 50, par.ilimax = 3);
    CHECK_EQ(enable(mc), 0);
    call(mc, MSETVERBOSITY, M_ERRORPRINT);
    DEMAND(mc, 0, 60);
    mock_run(&m, 7000);
    SAID("");
    CHECK_EQ(errcode_of(&m, 1), 0);
    mock_run(&m, 2100);
    SAID("mc: axis 1: sustained current overload\n");
    CHECK_EQ(errcode_of(&m, 1), 0x100 | MERR_ILIM);
    CHECK_EQ(mock_dac(&m, 1), soft ? 0x800 + 60 : 0x800);
  }
}

TEST(test_the_verbose_hear_of_the_normal_course, "DRV-2") {
  for (int say = 0; say < 4; say++) {
    struct mc *mc = mock_open(&m, 2);
    int before = m.logs, lines = (say & M_VERBOSE) != 0;
    call(mc, MSETVERBOSITY, say);
    CHECK_EQ(m.logs - before, lines);
    CHECK(!lines || strcmp(m.last_log, "mc: cards: 2") == 0);
    CHECK_EQ(enable(mc), 0);
    CHECK_EQ(m.logs - before, 2 * lines);
    CHECK(!lines || strcmp(m.last_log, "mc: enabled, axes: 4") == 0);
    CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
    CHECK_EQ(m.logs - before, 3 * lines);
    CHECK(!lines || strcmp(m.last_log, "mc: stopped") == 0);
  }
}

/* And every card for its answer: the sample of 0xFFs is discarded. */
TEST(test_every_axis_is_watched_for_its_heartbeat, "DRV-7 DRV-12") {
  for (int what = 0; what < 4 + 2; what++) {
    struct mc *mc = enabled(2);
    struct mock_card *c = &m.card[what < 4 ? what / 2 : what - 4];
    int passes = m.passes;
    c->count[0] = 70;
    mock_run(&m, 2000);
    CHECK_EQ(m.passes, passes + 1);
    if (what < 4) {
      c->enabled[what % 2] = 0;
      c->beat_until[what % 2] = 0;
    } else {
      c->present = 0;
    }
    said[0] = 0;
    mock_run(&m, 2100);
    CHECK_EQ(errcode_of(&m, 0), MERR_PANIC);
    CHECK_EQ(m.passes, passes + 1); /* the pass that finds it is no sample */
    CHECK_EQ(mc_state_of(mc, 2 * (int)(c - m.card))->encnow, 70);
    char text[] = "mc: PANIC: axis 0 has no heartbeat\n",
         card[] = "mc: PANIC: card 0 does not answer\n";
    text[16] = (char)('0' + what);
    card[16] = (char)('0' + what - 4);
    SAID(what < 4 ? text : card);
    if (what < 4) CHECK_EQ(c->beat_until[what % 2], 0); /* and is not started again */
  }
}
