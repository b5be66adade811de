/* SPDX-License-Identifier: Apache-2.0 */
/* The first open: which cards are there, and their state of rest, §2.3.1 and Table 2.1. */
#include "mc_priv.h"

#define PORT_B_REST (MMCS_CARD_PPI_B_ENC_JOINT_bm | MMCS_CARD_PPI_B_SCLOCK_EN_bm)

/* An absent card reads 0xFF; a card reads back what was written to port A. */
static int is_there(struct mc *mc, int card) {
  static const uint8_t pattern[] = {0x55, 0xAA, 0x00};
  hw_card_put(mc, card, MMCS_CARD_PPI_CONTROL, MMCS_PPI_MODE_BOARD);
  for (unsigned i = 0; i < sizeof pattern; i++) {
    hw_card_put(mc, card, MMCS_CARD_PPI_A, pattern[i]);
    if (hw_card_get(mc, card, MMCS_CARD_PPI_A) != pattern[i]) return 0;
  }
  return 1;
}

static void set_default(struct mc_axis *x, int which) {
  static const struct mc_param initial = MC_PARAM_INITIAL;
  x->par = initial;
  x->par.which = which;
  servo_reset(&x->servo);
  servo_prepare(&x->servo, &x->par);
  x->state = (struct mc_state){0};
  x->setpoint = 0;
  x->wait = 0;
  x->code = MC_DAC_ZERO;
  x->written = 0;
  x->adopt = 0;
  x->calib = 0;
}

void mc_set_defaults(struct mc *mc) {
  for (int axis = 0; axis < MC_MAX_AXES; axis++) set_default(&mc->axis[axis], axis);
  mc->joints = mc->axes;
  mc->verbosity = 0;
  mc->double_buffer = 0;
  mc->buffered = 0;
  mc->drive = 0;
  mc->diag = 0;
}

void mc_scan(struct mc *mc) {
  mc->cards = 0;
  for (uint8_t dip = 0; dip < MMCS_CARDS_MAX; dip++) {
    struct mc_card *card = &mc->card[mc->cards];
    card->dip = dip;
    card->base = MMCS_CARD_OFFSET(dip, 0);
    card->a = MC_ENC_MODE;
    card->b = PORT_B_REST;
    card->rearm = 0;
    if (!is_there(mc, mc->cards)) continue;
    hw_init_ppi(mc, mc->cards);
    mc->cards++;
  }
  mc->axes = 2 * mc->cards;
  mc_set_defaults(mc);
  for (int axis = 0; axis < mc->axes; axis++) {
    struct mc_axis *x = &mc->axis[axis];
    (void)hw_counter(mc, axis); /* what a latch before us left behind */
    x->counter = hw_counter(mc, axis);
    x->position = (int16_t)x->counter;
    x->state.encnow = x->position;
    x->raw = 0;
  }
}
