/* SPDX-License-Identifier: Apache-2.0 */
/* What the cards hold at an SCLOCK, §5.3.
 *
 * All encoders come first: that is the time in which the A/Ds finish. Port C of every card tells
 * that the card is alive, and whether its A/Ds are done.
 */
#include "mc_priv.h"

/* Port C reads 0xFF from a card that is not there, but also from one with both indexes latched:
 * port A tells them apart. */
static int is_alive(struct mc *mc, int card, uint8_t port_c) {
  if (port_c != 0xFF) return 1;
  return hw_card_get(mc, card, MMCS_CARD_PPI_A) == mc->card[card].a;
}

/* The index latches the counter, and the first read after a latch gives that count. An index seen
 * before the pair was read came after the last read: the pair is its count, up to a whole interval
 * old; where the axis is now tells another read. So for an axis, too, that waits for no index but
 * whose card does. An index that came while the pair was being read is trusted only if the count
 * before and after agree; else the next index is waited for. */
static void read_index(struct mc *mc, struct mc_sample *s, int axis, int armed, const uint8_t *v) {
  uint8_t mask = (uint8_t)INDEX_BM(axis), before = v[0], after = v[5];
  int waits = armed && mc->axis[axis].calib;
  if ((before & mask) != 0) {
    s->index[axis] = s->counter[axis];
    s->indexed[axis] = (uint8_t)waits;
    s->counter[axis] = hw_counter(mc, axis);
  } else if ((after & mask) != 0 && waits) {
    s->index[axis] = hw_counter(mc, axis);
    if (s->index[axis] == s->counter[axis]) {
      s->indexed[axis] = 1;
    } else {
      mc->card[axis / 2].rearm = MC_DROPPED;
    }
  }
}

/* v: port C, both counters, port C again. 1 if the card is alive. */
static int read_card(struct mc *mc, struct mc_sample *s, int card, const uint8_t *v) {
  int axis = 2 * card;
  s->counter[axis] = (uint16_t)(v[1] << 8 | v[2]);
  s->counter[axis + 1] = (uint16_t)(v[3] << 8 | v[4]);
  s->indexed[axis] = s->indexed[axis + 1] = 0;
  s->port_c[card] = v[5];
  if (!is_alive(mc, card, v[5])) {
    mc->card[card].silent = 1;
    return 0;
  }
  if (axis_calibrates(mc, card)) {
    int armed = mc->card[card].rearm == MC_ARMED;
    read_index(mc, s, axis, armed, v);
    read_index(mc, s, axis + 1, armed, v);
  }
  return 1;
}

/* 1: the A/Ds of a card are done. */
static int await_analog(struct mc *mc, int card, uint8_t port_c) {
  for (int i = 0; i < MC_ADC_POLLS && (port_c & MMCS_CARD_PPI_C_ADC_READY_bm) == 0; i++) {
    port_c = hw_card_get(mc, card, MMCS_CARD_PPI_C);
  }
  if ((port_c & MMCS_CARD_PPI_C_ADC_READY_bm) != 0) return 1;
  mc_count(&mc->adc_timeouts, 1);
  if (!mc->card[card].late) text_log(mc, "A/D time-out: card", mc->card[card].dip, "");
  return 0;
}

/* Late converters keep their old values. */
static void read_analog(struct mc *mc, struct mc_sample *s) {
  uint8_t values[MC_ANALOG * MC_MAX_CARDS];
  for (int card = 0; card < mc->cards; card++) {
    mc->card[card].late = (uint8_t)!await_analog(mc, card, s->port_c[card]);
  }
  hw_get_list(mc, mc->list.analog, values, MC_ANALOG * (unsigned)mc->cards);
  const uint8_t *v = values;
  uint16_t *raw = s->raw;
  for (int card = 0; card < mc->cards; card++, v += MC_ANALOG, raw += 2) {
    if (mc->card[card].late) {
      raw[0] = mc->axis[2 * card].raw;
      raw[1] = mc->axis[2 * card + 1].raw;
    } else {
      raw[0] = (uint16_t)((v[2] & 0x0F) << 8 | v[0]);
      raw[1] = (uint16_t)((v[2] & 0xF0) << 4 | v[1]);
    }
  }
}

int sample_read(struct mc *mc, struct mc_sample *s) {
  uint8_t v[MC_SENSE * MC_MAX_CARDS];
  int good = 1;
  hw_get_list(mc, mc->list.sense, v, MC_SENSE * (unsigned)mc->cards);
  for (int card = 0; card < mc->cards; card++) {
    if (!read_card(mc, s, card, v + MC_SENSE * (unsigned)card)) good = 0;
  }
  if (good) read_analog(mc, s);
  return good && !mc->fault;
}

static void take_first(struct mc_axis *x, unsigned raw) {
  x->raw = (uint16_t)raw;
  x->state.adcvai = servo_phi(&x->par, x->raw);
}

/* Shares nothing with read_analog(), which is laid into the pass: it has no time for calls. */
void sample_first(struct mc *mc) {
  mc->fault = 0;
  for (int card = 0; card < mc->cards; card++) {
    int polls = MC_ADC_POLLS;
    while ((hw_card_get(mc, card, MMCS_CARD_PPI_C) & MMCS_CARD_PPI_C_ADC_READY_bm) == 0) {
      if (polls-- == 0) break;
    }
    unsigned low1 = hw_card_get(mc, card, MMCS_CARD_ADC1_LO);
    unsigned low2 = hw_card_get(mc, card, MMCS_CARD_ADC2_LO);
    unsigned high = hw_card_get(mc, card, MMCS_CARD_ADC_HI);
    if (polls < 0 || mc->fault) continue;
    take_first(&mc->axis[2 * card], (high & 0x0F) << 8 | low1);
    take_first(&mc->axis[2 * card + 1], (high & 0xF0) << 4 | low2);
  }
}
