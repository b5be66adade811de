/* SPDX-License-Identifier: Apache-2.0 */
/* The first open: which cards are there, and their state of rest, §2.3.1 and Table 2.1. */
#include "mc_priv.h"

#define OPEN_INPUTS 0xE0 /* of port C: read 1 */
#define PORT_B_REST (MMCS_CARD_PPI_B_ENC_JOINT_bm | MMCS_CARD_PPI_B_SCLOCK_EN_bm)

/* An absent card reads 0xFF; a card reads back what was written to port A. That port also holds the
 * counting mode and the artificial encoder signals: only bits that move no count are tried. The
 * mode stays 0, counting off, in which the signals have no effect. */
static int is_there(struct mc *mc, int card) {
  static const uint8_t pattern[] = {0xA8, 0x50, 0x00};
  hw_card_put(mc, card, MMCS_CARD_PPI_CONTROL, MMCS_PPI_MODE_BOARD);
  for (unsigned i = 0; i < sizeof pattern; i++) {
    hw_card_put(mc, card, MMCS_CARD_PPI_A, pattern[i]);
    if (hw_card_get(mc, card, MMCS_CARD_PPI_A) != pattern[i]) return 0;
  }
  return 1;
}

/* A card that counts as we want it needs no initialisation, which would stop its counting. */
static int counts_already(struct mc *mc, int card) {
  unsigned a = hw_card_get(mc, card, MMCS_CARD_PPI_A);
  unsigned b = hw_card_get(mc, card, MMCS_CARD_PPI_B);
  unsigned c = hw_card_get(mc, card, MMCS_CARD_PPI_C);
  if ((a & ~MC_LIGHTS) != MC_ENC_MODE || (c & OPEN_INPUTS) != OPEN_INPUTS) return 0;
  if ((b & MMCS_CARD_PPI_B_ENC_JOINT_bm) == 0 || !hw_answers(mc, card)) return 0;
  hw_card_put(mc, card, MMCS_CARD_PPI_B, mc->card[card].b);
  return hw_card_get(mc, card, MMCS_CARD_PPI_B) == mc->card[card].b;
}

static void set_default(struct mc_axis *x, int which) {
  static const struct mc_param initial = MC_PARAM_INITIAL;
  *x = (struct mc_axis){.par = initial, .code = MC_DAC_ZERO, .index = x->index};
  x->par.which = which;
  servo_prepare(&x->law, &x->par);
}

/* The values of Table 2.1 for every axis. */
static void set_defaults(struct mc *mc) {
  for (int axis = 0; axis < MC_MAX_AXES; axis++) set_default(&mc->axis[axis], axis);
  mc->joints = mc->axes;
  mc->verbosity = 0;
  mc->double_buffer = mc->buffered = mc->drive = mc->diag = 0;
}

/* What was known at the last close. */
struct memory {
  int cards;
  uint8_t dip[MC_MAX_CARDS];
  int32_t position[MC_MAX_AXES];
  uint16_t counter[MC_MAX_AXES];
  uint8_t lost[MC_MAX_AXES];
};

static void remember(const struct mc *mc, struct memory *old) {
  old->cards = mc->cards;
  for (int axis = 0; axis < 2 * mc->cards; axis++) {
    old->dip[axis / 2] = mc->card[axis / 2].dip;
    old->position[axis] = mc->axis[axis].position;
    old->counter[axis] = mc->axis[axis].counter;
    old->lost[axis] = mc->axis[axis].lost;
  }
}

/* Where an axis is. If its card went on counting since the last close, so does the position. */
static void find_position(struct mc *mc, int axis, const struct memory *old, int kept) {
  struct mc_axis *x = &mc->axis[axis];
  (void)hw_counter(mc, axis); /* what a latch before us left behind */
  x->counter = hw_counter(mc, axis);
  x->position = (int16_t)x->counter;
  for (int card = 0; kept && card < old->cards; card++) {
    int was = 2 * card + (axis & 1);
    if (old->dip[card] != mc->card[axis / 2].dip) continue;
    x->position = servo_extend(old->position[was], old->counter[was], x->counter);
    x->lost = old->lost[was];
  }
  x->state.encnow = x->position;
}

void mc_scan(struct mc *mc) {
  struct memory old;
  uint8_t kept[MC_MAX_CARDS];
  remember(mc, &old);
  mc->cards = 0;
  for (uint8_t dip = 0; dip < MMCS_CARDS_MAX; dip++) {
    struct mc_card *card = &mc->card[mc->cards];
    card->dip = dip;
    card->base = MMCS_CARD_OFFSET(dip, 0);
    card->a = MC_ENC_MODE;
    card->b = PORT_B_REST;
    card->rearm = MC_ARMED;
    card->silent = 0;
    kept[mc->cards] = (uint8_t)counts_already(mc, mc->cards);
    if (!kept[mc->cards]) {
      if (!is_there(mc, mc->cards)) continue;
      hw_init_ppi(mc, mc->cards);
    }
    mc->cards++;
  }
  mc->axes = 2 * mc->cards;
  hw_make_lists(mc);
  set_defaults(mc);
  for (int axis = 0; axis < mc->axes; axis++) find_position(mc, axis, &old, kept[axis / 2]);
}
