/* SPDX-License-Identifier: Apache-2.0 */
/* struct mc_bus on a memory-mapped front: AXI4-Lite, Wishbone or APB (rtl/adaptor/). §4.2.1
 *
 * The driver counts in offsets of the VME window; here the register at offset 2 n + 1 is the lowest
 * byte of word n, or, on a front of 8 bits, the byte at that offset. */
#ifndef WINDOW_H
#define WINDOW_H

#include "mc.h"

enum window_width { WINDOW_WORDS = 32, WINDOW_BYTES = 8 };

struct window {
  enum window_width width;
  void *ctx;
  /* One access of that width, `at` bytes from the window's first byte; MC_BUS_ERROR where the bus
   * ended it with its own error. */
  enum mc_bus_result (*load)(void *ctx, uint32_t at, uint32_t *value);
  enum mc_bus_result (*store)(void *ctx, uint32_t at, uint32_t value);
};

/* The driver's bus over this window, which must outlive it. */
void window_make_bus(struct mc_bus *bus, struct window *window);

/* load and store of a window of words in the processor's own memory; ctx is the address of its
 * first byte. A bus error is the processor's trap there: these never fail. */
enum mc_bus_result window_load_word(void *ctx, uint32_t at, uint32_t *value);
enum mc_bus_result window_store_word(void *ctx, uint32_t at, uint32_t value);

#endif
