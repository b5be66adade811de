/* SPDX-License-Identifier: Apache-2.0 */
/* Cards that did not answer for a while, resets and bus errors: what is whole again, what is lost,
 * and who is told, §2.3.4. The level is masked. */
#include "mc_priv.h"

#define HALF 32768u /* counts after which 16 bits do not tell the direction any more */
#define US_PER_S 1000000u

/* The driver cannot know the 32 bits: of both axes, until MSETENC or an index. */
static void lose_counts(struct mc *mc, int card) {
  mc->axis[2 * card].lost = mc->axis[2 * card + 1].lost = 1;
}

/* 1: more counts may have passed since the last sample than 16 bits can tell. */
static int is_too_long(const struct mc *mc) {
  uint32_t speed = mc->config.speed > 0 ? mc->config.speed : MC_SPEED;
  uint64_t us = (uint64_t)mc->skipped * mc->interval_us;
  return us > (uint64_t)HALF * US_PER_S / speed;
}

/* 1: its modes are gone, and so are its counts. What only missed a write gets it now. */
static int was_reset(struct mc *mc, int card) {
  const struct mc_card *c = &mc->card[card];
  unsigned a = hw_card_get(mc, card, MMCS_CARD_PPI_A) ^ c->a;
  if ((a & ~MC_LIGHTS) != 0) return 1;
  unsigned b = hw_card_get(mc, card, MMCS_CARD_PPI_B) ^ c->b;
  if ((b & MMCS_CARD_PPI_B_ENC_JOINT_bm) != 0) return 1;
  if (a != 0) hw_card_put(mc, card, MMCS_CARD_PPI_A, c->a);
  if (b != 0) hw_card_put(mc, card, MMCS_CARD_PPI_B, c->b);
  return 0;
}

static int revive_reset(struct mc *mc, int card) {
  uint16_t counter[2];
  hw_init_ppi(mc, card);
  for (int joint = 0; joint < 2; joint++) {
    (void)hw_counter(mc, 2 * card + joint);
    counter[joint] = hw_counter(mc, 2 * card + joint);
  }
  if (!hw_answers(mc, card)) return 0;
  for (int joint = 0; joint < 2; joint++) {
    struct mc_axis *x = &mc->axis[2 * card + joint];
    x->counter = counter[joint];
    x->position = (int16_t)x->counter;
  }
  lose_counts(mc, card);
  text_log(mc, "card", mc->card[card].dip, " was reset: initialised again");
  return 1;
}

int revive_card(struct mc *mc, int card) {
  struct mc_card *c = &mc->card[card];
  if (was_reset(mc, card)) {
    if (!revive_reset(mc, card)) return 0;
  } else {
    if (!hw_answers(mc, card)) return 0;
    if (c->silent && is_too_long(mc)) {
      lose_counts(mc, card);
      text_log(mc, "card", c->dip, " was silent for too long: its counts are lost");
    }
  }
  c->silent = 0;
  return 1;
}

/* A sample could not be taken. Whose bytes a bus error took is not known. */
void revive_note(struct mc *mc) {
  mc->silent = 1;
  for (int card = 0; mc->fault && card < mc->cards; card++) mc->card[card].silent = 1;
}

void revive_cards(struct mc *mc) {
  mc->silent = 0;
  for (int card = 0; card < mc->cards; card++) {
    if (mc->card[card].silent) (void)revive_card(mc, card);
  }
}
