/* SPDX-License-Identifier: Apache-2.0 */
/* Registers, with software shadows of what can be set bit by bit, §4.3.3 and §5.3. */
#include "mc_priv.h"

uint8_t hw_get(struct mc *mc, uint16_t offset) {
  uint8_t value;
  if (mc->bus.read8(mc->bus.ctx, offset, &value) == MC_BUS_OK) return value;
  mc->fault = 1;
  return 0xFF;
}

void hw_put(struct mc *mc, uint16_t offset, uint8_t value) {
  if (mc->bus.write8(mc->bus.ctx, offset, value) != MC_BUS_OK) mc->fault = 1;
}

uint8_t hw_card_get(struct mc *mc, int card, unsigned reg) {
  return hw_get(mc, (uint16_t)(mc->card[card].base + 2 * reg));
}

void hw_card_put(struct mc *mc, int card, unsigned reg, uint8_t value) {
  hw_put(mc, (uint16_t)(mc->card[card].base + 2 * reg), value);
}

void hw_get_list(struct mc *mc, const uint16_t *offsets, uint8_t *values, unsigned n) {
  if (mc->bus.read_list != NULL && n > 0) {
    if (mc->bus.read_list(mc->bus.ctx, offsets, values, n) != MC_BUS_OK) mc->fault = 1;
    return;
  }
  for (unsigned i = 0; i < n; i++) values[i] = hw_get(mc, offsets[i]);
}

void hw_put_list(struct mc *mc, const uint16_t *offsets, const uint8_t *values, unsigned n) {
  if (mc->bus.write_list != NULL && n > 0) {
    if (mc->bus.write_list(mc->bus.ctx, offsets, values, n) != MC_BUS_OK) mc->fault = 1;
    return;
  }
  for (unsigned i = 0; i < n; i++) hw_put(mc, offsets[i], values[i]);
}

static void fill(uint16_t *list, unsigned base, const uint8_t *regs, unsigned n) {
  for (unsigned i = 0; i < n; i++) list[i] = (uint16_t)(base + 2u * regs[i]);
}

/* Port C stands before the pairs, too, so that no byte that somebody else has read of a counter is
 * taken for the first one of a pair: any other access to the card begins them anew. */
void hw_make_lists(struct mc *mc) {
  static const uint8_t sense[MC_SENSE] = {MMCS_CARD_PPI_C,    MMCS_CARD_ENC1_MSB,
                                          MMCS_CARD_ENC1_LSB, MMCS_CARD_ENC2_MSB,
                                          MMCS_CARD_ENC2_LSB, MMCS_CARD_PPI_C};
  static const uint8_t analog[MC_ANALOG] = {MMCS_CARD_ADC1_LO, MMCS_CARD_ADC2_LO, MMCS_CARD_ADC_HI};
  static const uint8_t drive[MC_DRIVE] = {MMCS_CARD_DAC1_LO, MMCS_CARD_DAC1_HI, MMCS_CARD_DAC2_LO,
                                          MMCS_CARD_DAC2_HI};
  for (unsigned card = 0; card < (unsigned)mc->cards; card++) {
    unsigned base = mc->card[card].base;
    fill(mc->list.sense + MC_SENSE * card, base, sense, MC_SENSE);
    fill(mc->list.analog + MC_ANALOG * card, base, analog, MC_ANALOG);
    fill(mc->list.drive + MC_DRIVE * card, base, drive, MC_DRIVE);
  }
}

void hw_set_pccsr(struct mc *mc, uint8_t set, uint8_t clear) {
  mc->pccsr = (uint8_t)((mc->pccsr & ~clear) | set);
  hw_put(mc, MMCS_PCCSR, mc->pccsr);
}

/* Port B, then the counters on. What switches their inputs between joint and artificial signals is
 * no movement: they hold until an edge of the switch is through their inputs, three CLK of 1 us at
 * most; that is what the reads are for. */
static void put_b_holding(struct mc *mc, int card) {
  const struct mc_card *c = &mc->card[card];
  hw_card_put(mc, card, MMCS_CARD_PPI_A, c->a & (uint8_t)~MMCS_CARD_PPI_A_ENC_MODE_bm);
  hw_card_put(mc, card, MMCS_CARD_PPI_B, c->b);
  for (int i = 0; i < 4; i++) (void)hw_card_get(mc, card, MMCS_CARD_PPI_B);
  hw_card_put(mc, card, MMCS_CARD_PPI_A, c->a);
}

static void set_b(struct mc *mc, int card, uint8_t b) {
  int switched = (b ^ mc->card[card].b) & MMCS_CARD_PPI_B_ENC_JOINT_bm;
  mc->card[card].b = b;
  if (switched) {
    put_b_holding(mc, card);
  } else {
    hw_card_put(mc, card, MMCS_CARD_PPI_B, b);
  }
}

static uint8_t wanted_b(const struct mc *mc, int card) {
  unsigned b = 0;
  if ((mc->diag & M_ENDIAG) == 0) b |= MMCS_CARD_PPI_B_ENC_JOINT_bm;
  if (mc->drive && (mc->diag & M_ANDIAG) == 0) b |= MMCS_CARD_PPI_B_DAC_JOINT_bm;
  if (axis_calibrates(mc, card)) {
    if (mc->card[card].rearm == MC_ARMED) b |= MMCS_CARD_PPI_B_INDEX_EN_bm;
  } else {
    b |= MMCS_CARD_PPI_B_SCLOCK_EN_bm;
    if (mc->buffered) b |= MMCS_CARD_PPI_B_DAC_DOUBLE_bm;
  }
  return (uint8_t)b;
}

void hw_apply_modes(struct mc *mc) {
  for (int card = 0; card < mc->cards; card++) {
    uint8_t b = wanted_b(mc, card);
    if (b != mc->card[card].b) set_b(mc, card, b);
  }
}

/* Edges between the two writes are lost; everything else is seen now or latched for next time. */
uint8_t hw_take_latches(struct mc *mc) {
  uint8_t seen = hw_get(mc, MMCS_PCCSR);
  hw_put(mc, MMCS_PCCSR, (uint8_t)(mc->pccsr & ~MMCS_PCCSR_LATCH_EN_bm));
  hw_put(mc, MMCS_PCCSR, mc->pccsr);
  return seen;
}

void hw_init_ppi(struct mc *mc, int card) {
  hw_card_put(mc, card, MMCS_CARD_PPI_CONTROL, MMCS_PPI_MODE_BOARD);
  put_b_holding(mc, card);
}

/* The lights are what may be toggled at any time without a side effect. */
int hw_answers(struct mc *mc, int card) {
  uint8_t a = mc->card[card].a;
  uint8_t other = (uint8_t)(a ^ MC_LIGHTS);
  hw_card_put(mc, card, MMCS_CARD_PPI_A, other);
  uint8_t first = hw_card_get(mc, card, MMCS_CARD_PPI_A);
  hw_card_put(mc, card, MMCS_CARD_PPI_A, a);
  return first == other && hw_card_get(mc, card, MMCS_CARD_PPI_A) == a;
}

/* High byte first, always, and something else before: the byte of a pair that is read first is the
 * one that takes the sample. */
uint16_t hw_counter(struct mc *mc, int axis) {
  unsigned reg = (axis & 1) != 0 ? MMCS_CARD_ENC2_MSB : MMCS_CARD_ENC1_MSB;
  (void)hw_card_get(mc, axis / 2, MMCS_CARD_PPI_C);
  unsigned high = hw_card_get(mc, axis / 2, reg);
  return (uint16_t)(high << 8 | hw_card_get(mc, axis / 2, reg + 1));
}

void hw_write_dacs(struct mc *mc) {
  uint8_t values[MC_DRIVE * MC_MAX_CARDS], *v = values;
  const struct mc_axis *end = mc->axis + mc->axes;
  for (const struct mc_axis *x = mc->axis; x < end; x++) {
    *v++ = (uint8_t)x->code;
    *v++ = (uint8_t)(x->code >> 8);
  }
  hw_put_list(mc, mc->list.drive, values, (unsigned)(v - values));
}
