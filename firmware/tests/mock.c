/* SPDX-License-Identifier: Apache-2.0 */
/* Length: adaptor, cards and host of one model, which each call of the driver goes through. */
/* See mock.h. §4.3, §5.3 */
#include "mock.h"

#include "harness.h"

static void latch_card(struct mock *m, struct mock_card *c) {
  for (int j = 0; j < 2; j++) {
    c->latched[j] = c->count[j];
    c->has_latch[j] = 1;
  }
  if (m->now >= c->adc_until) c->adc_until = m->now + 25;
}

static void sclock_rise(struct mock *m) {
  m->level_high = 1;
  m->fresh2 = 0;
  if (m->pccsr & 0x80) m->sclock_latch = 1;
  for (int i = 0; i < 16; i++) {
    if (m->card[i].b & 0x04) latch_card(m, &m->card[i]);
  }
}

/* A waiting count is loaded at the end of a whole pulse; until then timer 2 stands still. */
static void fall(struct mock *m) {
  m->level_high = 0;
  if (!m->load2) {
    m->falls++;
  } else if (!m->fresh2) {
    m->falls = m->load2 = 0;
  }
}

int mock_panic(const struct mock *m) {
  if (m->estop_open) return 1;
  for (int i = 0; i < 16; i++) {
    const struct mock_card *c = &m->card[i];
    for (int j = 0; j < 2 && c->present; j++) {
      if (c->enabled[j] && m->now >= c->beat_until[j]) return 1;
    }
  }
  return 0;
}

static uint8_t level(const struct mock_card *c, int j) {
  return (uint8_t)((c->b & 1) != 0 ? c->joint[j] : (c->a >> 4 & 2) | (c->a >> 6 & 1));
}

/* A tick of CLK, 1 MHz here: the slowest that there is. */
static void tick(struct mock_card *c) {
  for (int j = 0; j < 2; j++) {
    uint8_t *in = c->input[j];
    int changed = in[1] ^ in[2], down = (in[2] >> 1 ^ in[1]) & 1; /* A leads B: up */
    if ((c->a & 7) == 5 && (changed == 1 || changed == 2)) {
      c->count[j] = (uint16_t)(c->count[j] + (down ? -1 : 1));
    }
    in[2] = in[1];
    in[1] = in[0];
    in[0] = level(c, j);
  }
}

static void step(struct mock *m) {
  m->now++;
  for (int i = 0; i < 16; i++) {
    if (m->card[i].present) tick(&m->card[i]);
  }
  if (m->period > 0) {
    if (++m->phase == m->period) m->phase = 0;
    int falls = m->phase == m->period - m->low_us;
    if (falls) fall(m);
    if (m->phase == 0 && !falls) sclock_rise(m);
  }
  int panic = mock_panic(m);
  if (panic && !m->panic && (m->pccsr & 0x80)) m->panic_latch = 1;
  if (m->panic && !panic) m->releases++;
  m->panic = panic;
}

static int requests(const struct mock *m) {
  return (m->sclock_latch && (m->pccsr & 0x20)) || (m->panic_latch && (m->pccsr & 0x40));
}

static void poll(struct mock *m) {
  if (!requests(m)) {
    m->irq_since = -1;
    return;
  }
  if (m->irq_since < 0) m->irq_since = m->now;
  if (m->masked || m->serving || m->now < m->irq_since + m->latency_us) return;
  m->serving = m->masked = 1;
  m->irq_since = -1;
  if (m->ack_broken) {
    mc_spurious(m->memory);
    m->sclock_latch = m->panic_latch = 0;
  } else {
    m->passes += mc_interrupt(m->memory);
  }
  m->serving = m->masked = 0;
}

static int64_t earlier(int64_t a, int64_t b) {
  return a < b ? a : b;
}

/* How many us pass in which nobody does anything, at most `most`. */
static int64_t quiet(const struct mock *m, int64_t most) {
  if (requests(m) != (m->irq_since >= 0) || m->panic != mock_panic(m)) return 0;
  int64_t wait = m->irq_since + m->latency_us - m->now - 1;
  if (m->irq_since >= 0 && !m->masked && !m->serving) most = earlier(most, wait > 0 ? wait : 0);
  for (int i = 0; i < 16; i++) {
    const struct mock_card *c = &m->card[i];
    for (int j = 0; j < 2 && c->present; j++) {
      const uint8_t *in = c->input[j];
      if (in[0] != level(c, j) || in[1] != in[0] || in[2] != in[1]) return 0;
      int64_t beat = c->beat_until[j] - m->now;
      if (c->enabled[j] && beat > 0) most = earlier(most, beat - 1);
    }
  }
  if (m->period == 0) return most;
  int64_t falls = m->period - m->low_us - m->phase;
  return earlier(most, (falls > 0 ? falls : m->period - m->phase) - 1);
}

/* To the next moment at which something may happen, at most so far. */
static void advance(struct mock *m, int64_t most) {
  int64_t us = quiet(m, most - 1);
  m->now += us;
  m->phase += us;
  step(m);
}

void mock_run(struct mock *m, int64_t us) {
  for (int64_t until = m->now + us; m->now < until; poll(m)) advance(m, until - m->now);
}

void mock_pass(struct mock *m) {
  for (int passes = m->passes; m->passes == passes; poll(m)) advance(m, INT64_MAX);
}

/* --- timers ----------------------------------------------------------------------------- */

static void control(struct mock *m, uint8_t v) {
  unsigned timer = v >> 6;
  if (timer == 3) {
    m->status = (uint8_t)(m->level_high ? 0x80 : 0);
    m->has_status = 1;
  } else if ((v & 0x30) == 0) {
    if (!m->has_latch2) m->latch2 = (uint16_t)(0 - m->falls);
    m->has_latch2 = 1;
    m->latch_no = 0;
  } else {
    m->byte_no[timer] = 0;
    m->n[timer] = 0;
    if (timer == 1) {
      int high = (v & 0x0E) != 0; /* mode 0: low at once; else high */
      if (high && !m->level_high) sclock_rise(m);
      if (!high && m->level_high) fall(m);
      m->level_high = high;
      m->period = 0;
    }
  }
}

static void count(struct mock *m, int timer, uint8_t v) {
  m->n[timer] |= (uint32_t)v << (8 * m->byte_no[timer]++);
  if (timer == 2 && m->byte_no[2] == 2) m->fresh2 = m->load2 = 1;
  if (timer != 1 || m->byte_no[1] < 2) return;
  uint32_t n0 = m->n[0] ? m->n[0] : 65536, n1 = m->n[1] ? m->n[1] : 65536;
  m->period = (int64_t)n0 * n1 / 8;
  m->low_us = n0 / 8;
  m->origin = m->now;
  m->phase = 0;
}

static uint8_t read_timer(struct mock *m, int timer) {
  if (timer == 1 && m->has_status) {
    m->has_status = 0;
    return m->status;
  }
  if (timer != 2 || !m->has_latch2) return 0xEE;
  if (m->latch_no++ == 0) return (uint8_t)m->latch2;
  m->has_latch2 = 0;
  return (uint8_t)(m->latch2 >> 8);
}

/* --- cards ------------------------------------------------------------------------------ */

static uint8_t port_c(const struct mock *m, const struct mock_card *c) {
  unsigned v = 0xE0;
  for (int j = 0; j < 2; j++) {
    if (m->now < c->beat_until[j]) v |= 1u << 2 * j;
    if (c->index[j]) v |= 2u << 2 * j;
  }
  if (m->now >= c->adc_until) v |= 0x10;
  return (uint8_t)v;
}

/* A byte samples all 16 bits; the other one, if it is read next, comes from that sample. */
static uint8_t read_encoder(struct mock_card *c, unsigned reg) {
  unsigned j = (reg - 4) / 2;
  if (c->paired == (int)(reg ^ 1)) {
    c->paired = -1;
  } else {
    c->paired = (int)reg;
    c->snapshot[j] = c->has_latch[j] ? c->latched[j] : c->count[j];
    c->has_latch[j] = 0;
  }
  return (uint8_t)((reg & 1) == 0 ? c->snapshot[j] >> 8 : c->snapshot[j]);
}

/* A byte is stored at once; the other one, if it is written next, stores both again. */
static void write_encoder(struct mock_card *c, unsigned reg, uint8_t v) {
  unsigned j = (reg - 4) / 2;
  uint16_t old = c->count[j];
  if (c->written == (int)(reg ^ 1)) {
    old = (uint16_t)((reg & 1) != 0 ? c->held << 8 : c->held);
    c->written = -1;
  } else {
    c->written = (int)reg;
    c->held = v;
  }
  c->count[j] = (uint16_t)((reg & 1) == 0 ? (old & 0xFF) | v << 8 : (old & 0xFF00) | v);
}

static uint8_t card_read(struct mock *m, struct mock_card *c, unsigned reg) {
  if (!c->present) return 0xFF;
  c->written = -1;
  if (reg < 4 || reg > 7) c->paired = -1;
  if (reg == 0) return c->a;
  if (reg == 1) return c->b;
  if (reg == 2) return port_c(m, c);
  if (reg >= 4 && reg <= 7) return read_encoder(c, reg);
  if (reg == 0xC || reg == 0xD) return (uint8_t)c->adc[reg & 1];
  if (reg == 0xE) return (uint8_t)(c->adc[0] >> 8 | (c->adc[1] >> 8) << 4);
  return 0xFF;
}

static void card_write(struct mock *m, struct mock_card *c, unsigned reg, uint8_t v) {
  if (!c->present) return;
  unsigned j = reg / 2 & 1;
  c->paired = -1;
  if (reg < 4 || reg > 7) c->written = -1;
  if (reg == 0) c->a = v;
  if (reg == 1) c->b = v;
  if (reg == 1 && !(v & 0x10)) c->index[0] = c->index[1] = 0;
  if (reg == 3 && (v & 0x80)) {
    c->mode_word = v;
    c->a = c->b = 0;
  }
  if (reg >= 4 && reg <= 7) write_encoder(c, reg, v);
  if (reg == 8 || reg == 10) {
    c->dac_low[j] = v;
    c->beat_until[j] = m->now + MOCK_HEARTBEAT_US;
  }
  if (reg == 9 || reg == 11) c->dac_high[j] = v;
}

uint16_t mock_dac(const struct mock *m, int axis) {
  const struct mock_card *c = &m->card[axis / 2];
  return (uint16_t)(c->dac_high[axis & 1] << 8 | c->dac_low[axis & 1]);
}

/* --- bus -------------------------------------------------------------------------------- */

uint32_t mock_told;

void mock_tell(uint32_t word) {
  mock_told = (mock_told ^ word) * 0x01000193u;
  mock_told ^= mock_told >> 15;
}

static void note(struct mock *m, int write, uint16_t offset, uint8_t value) {
  mock_tell((uint32_t)write << 24 | (uint32_t)offset << 8 | value);
  if (m->logging && m->used < MOCK_LOG) {
    m->log[m->used++] = (struct mock_access){write, offset, value};
  }
  if (m->on_access) m->on_access(m);
  step(m);
}

static enum mc_bus_result bus_read(void *ctx, uint16_t offset, uint8_t *value) {
  struct mock *m = ctx;
  if (m->adaptor_dead) return MC_BUS_TIMEOUT;
  if (offset < 0x400) {
    *value = card_read(m, &m->card[offset >> 6], offset >> 1 & 0x1F);
  } else if (offset == MMCS_PCCSR) {
    *value = (uint8_t)((m->pccsr & 0x9F) | m->sclock_latch << 5 | m->panic_latch << 6);
  } else {
    *value = offset < MMCS_PIT_CONTROL ? read_timer(m, (offset - 0x401) / 2) : 0xFF;
  }
  note(m, 0, offset, *value);
  poll(m);
  return MC_BUS_OK;
}

static enum mc_bus_result bus_write(void *ctx, uint16_t offset, uint8_t v) {
  struct mock *m = ctx;
  if (m->adaptor_dead) return MC_BUS_TIMEOUT;
  if (m->dac_errors > 0 && offset >= 0x011 && offset <= 0x017) {
    m->dac_errors--;
    step(m);
    return MC_BUS_ERROR;
  }
  if (offset < 0x400) {
    card_write(m, &m->card[offset >> 6], offset >> 1 & 0x1F, v);
  } else if (offset == MMCS_PCCSR) {
    m->pccsr = v;
    if (!(v & 0x80)) m->sclock_latch = m->panic_latch = 0;
  } else if (offset == MMCS_VECTOR) {
    m->vector = v;
  } else if (offset == MMCS_PIT_CONTROL) {
    control(m, v);
  } else {
    count(m, (offset - 0x401) / 2, v);
  }
  note(m, 1, offset, v);
  poll(m);
  return MC_BUS_OK;
}

/* --- host ------------------------------------------------------------------------------- */

static void os_signal(void *ctx, int client) {
  ((struct mock *)ctx)->signals[client]++;
  mock_tell(0x10000000u + (uint32_t)client);
}

static void os_log(void *ctx, const char *text) {
  struct mock *m = ctx;
  m->logs++;
  for (const char *at = text; *at != 0; at++) mock_tell((uint8_t)*at);
  strncpy(m->last_log, text, sizeof m->last_log - 1);
}

static void os_compute(void *ctx, unsigned axes) {
  struct mock *m = ctx;
  m->computes++;
  m->computed_axes = (int)axes;
  int64_t until = m->now + m->compute_us * axes;
  while (m->now < until) advance(m, until - m->now);
}

static void os_delay(void *ctx, uint32_t us) {
  mock_run(ctx, us);
}

static unsigned os_mask(void *ctx) {
  struct mock *m = ctx;
  unsigned previous = (unsigned)m->masked;
  m->masked = 1;
  return previous;
}

static void os_unmask(void *ctx, unsigned previous) {
  struct mock *m = ctx;
  m->masked = (int)previous;
  poll(m);
}

static int os_copy(void *ctx, void *to, const void *from, size_t len) {
  if (((struct mock *)ctx)->bad_pointer || to == NULL || from == NULL) return -MC_EFAULT;
  memcpy(to, from, len);
  return 0;
}

struct mc *mock_start(struct mock *m, int cards) {
  free(m->memory);
  memset(m, 0, sizeof *m);
  for (int i = 0; i < 16; i++) {
    m->card[i].present = i < cards;
    m->card[i].enabled[0] = m->card[i].enabled[1] = 1;
    m->card[i].adc[0] = m->card[i].adc[1] = 2048;
    m->card[i].paired = m->card[i].written = -1;
  }
  m->level_high = 1;
  m->irq_since = -1;
  m->bus = (struct mc_bus){m, bus_read, bus_write, NULL, NULL};
  m->os = (struct mc_os){m,       os_signal, os_log,  os_compute, os_delay,
                         os_mask, os_unmask, os_copy, os_copy};
  m->memory = calloc(1, mc_size());
  m->panic = mock_panic(m);
  struct mc_config config = {.sysclk_hz = 8000000, .vector = 0x40};
  if (mc_attach(m->memory, &m->bus, &m->os, &config) != 0) abort();
  return m->memory;
}

struct mc *mock_open(struct mock *m, int cards) {
  struct mc *mc = mock_start(m, cards);
  if (mc_open(mc, MC_O_RDWR) != 0) abort();
  return mc;
}
