/* SPDX-License-Identifier: Apache-2.0 */
/* What the cards hold at an SCLOCK, §5.3.
 *
 * All encoders come first: that is the time in which the A/Ds finish. Port C of every card is read
 * once: it tells that the card is alive, and whether its A/Ds are done.
 */
#include "mc_priv.h"

/* Port C reads 0xFF from a card that is not there, but also from one with both indexes latched:
 * port A tells them apart. */
static int is_alive(struct mc *mc, int card, uint8_t port_c) {
  if (port_c != 0xFF) return 1;
  return hw_card_get(mc, card, MMCS_CARD_PPI_A) == mc->card[card].a;
}

/* The index latches the counter, and the first read after a latch gives that count. An index seen
 * before the pair was read came after the last read: the pair is its count. One that came while
 * it was being read is trusted only if the count before and after agree; else the next index is
 * waited for. */
static void read_index(struct mc *mc, struct mc_sample *s, int axis, uint8_t before,
                       uint8_t after) {
  uint8_t mask = hw_index_bm(axis);
  if (!mc->axis[axis].calib) return;
  if ((before & mask) != 0) {
    s->index[axis] = s->counter[axis];
    s->indexed[axis] = 1;
  } else if ((after & mask) != 0) {
    s->index[axis] = hw_counter(mc, axis);
    if (s->index[axis] == s->counter[axis]) {
      s->indexed[axis] = 1;
    } else {
      mc->card[axis / 2].rearm = 1;
    }
  }
}

static void read_encoders(struct mc *mc, struct mc_sample *s, int card) {
  static const uint8_t order[] = {MC_STEP(MMCS_CARD_ENC1_MSB), MC_STEP(MMCS_CARD_ENC1_LSB),
                                  MC_STEP(MMCS_CARD_ENC2_MSB), MC_STEP(MMCS_CARD_ENC2_LSB),
                                  MC_STEP(MMCS_CARD_PPI_C)};
  uint8_t v[sizeof order];
  int axis = 2 * card;
  int calibrates = mc->axis[axis].calib || mc->axis[axis + 1].calib;
  uint8_t before = calibrates ? hw_card_get(mc, card, MMCS_CARD_PPI_C) : 0;
  s->indexed[axis] = s->indexed[axis + 1] = 0;
  hw_card_get_list(mc, card, order, v, sizeof order);
  s->counter[axis] = (uint16_t)(v[0] << 8 | v[1]);
  s->counter[axis + 1] = (uint16_t)(v[2] << 8 | v[3]);
  s->port_c[card] = v[4];
  s->answers[card] = (uint8_t)is_alive(mc, card, s->port_c[card]);
  if (!calibrates || !s->answers[card] || mc->card[card].rearm) return;
  read_index(mc, s, axis, before, s->port_c[card]);
  read_index(mc, s, axis + 1, before, s->port_c[card]);
}

static void read_analog(struct mc *mc, struct mc_sample *s, int card) {
  static const uint8_t order[] = {MC_STEP(MMCS_CARD_ADC1_LO), MC_STEP(MMCS_CARD_ADC2_LO),
                                  MC_STEP(MMCS_CARD_ADC_HI)};
  uint8_t v[sizeof order];
  int axis = 2 * card;
  uint8_t c = s->port_c[card];
  for (int i = 0; i < MC_ADC_POLLS && (c & MMCS_CARD_PPI_C_ADC_READY_bm) == 0; i++) {
    c = hw_card_get(mc, card, MMCS_CARD_PPI_C);
  }
  if ((c & MMCS_CARD_PPI_C_ADC_READY_bm) == 0) {
    mc_count(&mc->adc_timeouts, 1);
    if (!mc->card[card].late) text_log(mc, "A/D time-out: card", mc->card[card].dip, "");
    mc->card[card].late = 1;
    s->raw[axis] = mc->axis[axis].raw;
    s->raw[axis + 1] = mc->axis[axis + 1].raw;
    return;
  }
  mc->card[card].late = 0;
  hw_card_get_list(mc, card, order, v, sizeof order);
  s->raw[axis] = (uint16_t)((v[2] & 0x0F) << 8 | v[0]);
  s->raw[axis + 1] = (uint16_t)((v[2] & 0xF0) << 4 | v[1]);
}

int sample_read(struct mc *mc, struct mc_sample *s) {
  int good = 1;
  for (int card = 0; card < mc->cards; card++) {
    read_encoders(mc, s, card);
    if (!s->answers[card]) good = 0;
  }
  for (int card = 0; card < mc->cards && good; card++) read_analog(mc, s, card);
  return good && !mc->fault;
}
