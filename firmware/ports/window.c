/* SPDX-License-Identifier: Apache-2.0 */
/* struct mc_bus on a memory-mapped front: where each register lies. §4.2.1 */
#include "window.h"

static uint32_t place(const struct window *w, uint16_t offset) {
  return w->width == WINDOW_WORDS ? 2u * (offset - 1u) : offset;
}

static enum mc_bus_result read8(void *ctx, uint16_t offset, uint8_t *value) {
  const struct window *w = ctx;
  uint32_t word = 0xFF;
  enum mc_bus_result result = w->load(w->ctx, place(w, offset), &word);
  *value = (uint8_t)word;
  return result;
}

static enum mc_bus_result write8(void *ctx, uint16_t offset, uint8_t value) {
  const struct window *w = ctx;
  return w->store(w->ctx, place(w, offset), value);
}

void window_make_bus(struct mc_bus *bus, struct window *window) {
  *bus = (struct mc_bus){.ctx = window, .read8 = read8, .write8 = write8};
}

enum mc_bus_result window_load_word(void *ctx, uint32_t at, uint32_t *value) {
  *value = *(volatile uint32_t *)((uintptr_t)ctx + at);
  return MC_BUS_OK;
}

enum mc_bus_result window_store_word(void *ctx, uint32_t at, uint32_t value) {
  *(volatile uint32_t *)((uintptr_t)ctx + at) = value;
  return MC_BUS_OK;
}
