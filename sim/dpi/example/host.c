/* SPDX-License-Identifier: Apache-2.0 */
/* A computer on the VMEbus behind one DPI call a clock, to copy into a testbench of one's own: the
 * driver of firmware/mc unchanged, one servo loop. The program has a stack of its own, and every
 * wait in it is a way back to the simulator. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <ucontext.h>

#include "mc.h"

enum { kWindow = 0x6000, kAm = 0x2D, kVector = 0x40, kTimeout = 128, kClksPerUs = 8 };
enum { kStep = 200, kMilliseconds = 150 };

/* Pins as the bus master drives them, and what it saw before the last edge. */
static struct {
  unsigned as, ds, write, iack, iackin, address, data;
} out = {1, 3, 1, 1, 1, 0, 0xFFFF};
static unsigned seen_data, seen_dtack = 1, seen_irq = 1;
static ucontext_t simulator, program;
static char stack[1 << 18];
static struct mc *mc;
static int done, masked, passes;

/* --- bus cycles: one clock is one way to the simulator and back ------------------------------ */

static void clocks(int n) {
  while (n-- > 0) swapcontext(&program, &simulator);
}

static int wait_dtack(unsigned level) {
  for (int n = 0; n < kTimeout && seen_dtack != level; ++n) clocks(1);
  return seen_dtack == level;
}

/* Address first, strobes a clock later, release after DTACK*. */
static enum mc_bus_result cycle(unsigned address, int write, unsigned data, int iack) {
  out.address = address;
  out.write = !write;
  out.data = data;
  clocks(1);
  out.as = 0;
  out.ds = 2; /* DS0*: odd bytes, D07..D00 */
  out.iack = !iack;
  clocks(1);
  out.iackin = !iack;
  const int answered = wait_dtack(0);
  data = seen_data & 0xFF;
  out.as = out.write = out.iack = out.iackin = 1;
  out.ds = 3;
  wait_dtack(1);
  clocks(1);
  seen_data = data;
  return answered ? MC_BUS_OK : MC_BUS_TIMEOUT;
}

/* An interrupt is taken between two accesses. */
static void interrupts(void) {
  while (!seen_irq && !masked) {
    masked = 1;
    if (cycle(5 << 1, 0, 0xFFFF, 1) == MC_BUS_OK && seen_data == kVector) {
      passes += mc_interrupt(mc);
    } else {
      mc_spurious(mc);
    }
    masked = 0;
  }
}

/* --- what the driver asks for: struct mc_bus, struct mc_os ----------------------------------- */

static enum mc_bus_result read8(void *ctx, uint16_t offset, uint8_t *value) {
  (void)ctx;
  const enum mc_bus_result result = cycle(kWindow + offset, 0, 0xFFFF, 0);
  *value = (uint8_t)seen_data;
  interrupts();
  return result;
}
static enum mc_bus_result write8(void *ctx, uint16_t offset, uint8_t value) {
  (void)ctx;
  const enum mc_bus_result result = cycle(kWindow + offset, 1, value * 0x101u, 0);
  interrupts();
  return result;
}
static void delay_us(void *ctx, uint32_t us) {
  (void)ctx;
  for (uint32_t n = 0; n < us * kClksPerUs; ++n) {
    clocks(1);
    interrupts();
  }
}
static void compute(void *ctx, unsigned axes) {
  (void)ctx;
  clocks((int)axes * 20 * kClksPerUs);
}
static unsigned mask(void *ctx) {
  (void)ctx;
  const unsigned previous = (unsigned)masked;
  masked = 1;
  return previous;
}
static void unmask(void *ctx, unsigned previous) {
  (void)ctx;
  masked = (int)previous;
  interrupts();
}
static int copy(void *ctx, void *to, const void *from, size_t n) {
  (void)ctx;
  memcpy(to, from, n);
  return 0;
}
static void tell(void *ctx, int client) {
  (void)ctx;
  printf("example: SIGUSR1 to client %d\n", client);
}
static void say(void *ctx, const char *text) {
  (void)ctx;
  printf("example: %s\n", text);
}

/* --- the program: a step of one motor -------------------------------------------------------- */

static void run(void) {
  static const struct mc_bus bus = {.read8 = read8, .write8 = write8};
  static const struct mc_os os = {NULL, tell, say, compute, delay_us, mask, unmask, copy, copy};
  static const struct mc_config config = {.sysclk_hz = 8000000, .vector = kVector};
  int joints = 1, interval_us = 1000, setpoint = kStep;
  struct mc_param law = MC_PARAM_INITIAL; /* axis 0, the whole law a PD: 40 - 36/z, over 4 */
  law.mode = MD_POS;
  law.a0 = 40;
  law.a1 = -36;
  law.b0 = 4;
  mc = calloc(1, mc_size());
  int client = mc_attach(mc, &bus, &os, &config) ? -1 : mc_open(mc, MC_O_RDWR);
  int wrong = mc_ioctl(mc, client, MSETNUMJOINTS, &joints) |
              mc_ioctl(mc, client, MSETINTERVAL, &interval_us) |
              mc_ioctl(mc, client, MSETPARAM, &law) | mc_ioctl(mc, client, MENABLE, NULL);
  if (mc_write(mc, client, &setpoint, sizeof setpoint) < 0) wrong = -1;
  delay_us(NULL, 1000 * kMilliseconds);
  printf("example: result %d, passes %d, missed %u, setpoint %d, encoder %d\n", wrong, passes,
         (unsigned)mc_stats_of(mc)->missed, setpoint, (int)mc_state_of(mc, 0)->encnow);
  for (done = 1;;) clocks(1);
}

/* The imported call; example_tb.sv says what the bits are. */
int host_clock(unsigned seen, unsigned long long *pins) {
  seen_data = seen & 0xFFFF;
  seen_dtack = seen >> 16 & 1;
  seen_irq = seen >> 17 & 1;
  if (!program.uc_stack.ss_sp) {
    getcontext(&program);
    program.uc_stack.ss_sp = stack;
    program.uc_stack.ss_size = sizeof stack;
    makecontext(&program, run, 0);
  }
  swapcontext(&simulator, &program);
  *pins = (unsigned long long)out.data | (unsigned long long)(out.address >> 1) << 16 |
          (unsigned long long)kAm << 31 | (unsigned long long)out.as << 37 |
          (unsigned long long)out.ds << 38 | (unsigned long long)out.write << 40 | 1ull << 41 |
          (unsigned long long)out.iack << 42 | (unsigned long long)out.iackin << 43;
  return done;
}
