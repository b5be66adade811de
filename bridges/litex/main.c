/* SPDX-License-Identifier: Apache-2.0 */
/* The mc driver on LiteX's processor: brings both joints to a count, then lights gp1 of the card.
 */
#include <generated/csr.h>
#include <generated/mem.h>
#include <generated/soc.h>

#include "window.h"

__asm__(".option arch, +zicsr"); /* the compiler is asked for no more than the core's rv32im */

enum { JOINTS = 2, NEAR = 4, STEADY = 10, INTERVAL_US = 1000, MIE = 8, EXTERNAL = 0x800 };
static int goal[JOINTS] = {200, -120};
#define CSR32(address) (*(volatile uint32_t *)(address))

int main(void);
void interrupt(void);

static uint64_t memory[MC_WORDS]; /* of the driver */
static struct mc *const mc = (struct mc *)memory;

void interrupt(void) {
  (void)mc_interrupt(mc);
}

static void ignore(void *ctx, int client) {
  (void)ctx;
  (void)client;
}
/* A line of text, character by character through LiteX's scratch register, each with its number:
 * whoever watches the simulation reads it. */
static void say(void *ctx, const char *text) {
  uint32_t n = 1;
  (void)ctx;
  for (; *text != 0; text++, n++) CSR32(CSR_CTRL_SCRATCH_ADDR) = n << 8 | (uint8_t)*text;
  CSR32(CSR_CTRL_SCRATCH_ADDR) = n << 8 | '\n';
}
static void no_time(void *ctx, unsigned axes) {
  (void)ctx;
  (void)axes;
}
/* A turn of the loop takes two clocks at least. */
static void delay_us(void *ctx, uint32_t us) {
  (void)ctx;
  for (uint32_t n = us * (CONFIG_CLOCK_FREQUENCY / 2000000); n > 0; n--) __asm__ volatile("");
}
static unsigned mask(void *ctx) {
  unsigned before;
  (void)ctx;
  __asm__ volatile("csrrci %0, mstatus, 8" : "=r"(before)::"memory");
  return !(before & MIE);
}
static void unmask(void *ctx, unsigned previous) {
  (void)ctx;
  if (!previous) __asm__ volatile("csrsi mstatus, 8" ::: "memory");
}
static int copy(void *ctx, void *to, const void *from, size_t len) {
  uint8_t *out = to;
  const uint8_t *in = from;
  (void)ctx;
  while (len-- > 0) *out++ = *in++;
  return 0;
}

static struct window window = {WINDOW_WORDS, (void *)MMCS_BASE, window_load_word,
                               window_store_word};
static const struct mc_os os = {0, ignore, say, no_time, delay_us, mask, unmask, copy, copy};

static void start_interrupts(void) {
  CSR32(CSR_MMCS_EV_ENABLE_ADDR) = 1;
  __asm__ volatile("csrw 0xBC0, %0" ::"r"(1 << MMCS_INTERRUPT)); /* VexRiscv's mask */
  __asm__ volatile("csrw mie, %0" ::"r"(EXTERNAL));
  unmask(0, 0);
}

static int is_near(const struct mc_state *state) {
  for (int n = 0; n < JOINTS; n++) {
    int off = state[n].encnow - goal[n];
    if (off < -NEAR || off > NEAR) return 0;
  }
  return 1;
}

/* Why the program ends before its motors are there; null: it does not. */
static const char *move(void) {
  const struct mc_config config = {.sysclk_hz = 8000000, .vector = 0x40};
  struct mc_param param = MC_PARAM_INITIAL;
  struct mc_state state[JOINTS];
  struct mc_stats stats;
  struct mc_bus bus;
  int interval = INTERVAL_US, joints = JOINTS, light = 1 << 8, steady = 0;
  window_make_bus(&bus, &window);
  if (mc_attach(mc, &bus, &os, &config) != 0) return "mc_attach";
  start_interrupts();
  int client = mc_open(mc, MC_O_RDWR);
  if (client < 0) return "open";
  param.mode = MD_POS;
  param.a0 = 140;
  param.a1 = -112;
  param.b0 = 8;
  if (mc_ioctl(mc, client, MSETNUMJOINTS, &joints) != 0) return "MSETNUMJOINTS";
  if (mc_ioctl(mc, client, MSETINTERVAL, &interval) != 0) return "MSETINTERVAL";
  for (param.which = 0; param.which < JOINTS; param.which++)
    if (mc_ioctl(mc, client, MSETPARAM, &param) != 0) return "MSETPARAM";
  if (mc_ioctl(mc, client, MENABLE, 0) != 0) return "MENABLE";
  if (mc_write(mc, client, goal, sizeof goal) < 0) return "write";
  while (steady < STEADY) {
    delay_us(0, 1000);
    if (mc_read(mc, client, state, sizeof state) != (int)sizeof state) return "read";
    steady = is_near(state) ? steady + 1 : 0;
  }
  if (mc_ioctl(mc, client, MGETSTATS, &stats) != 0) return "MGETSTATS";
  if (stats.overrun != 0 || stats.missed != 0) return "a pass that outlasts SCLOCK";
  return mc_ioctl(mc, client, MSETLED, &light) == 0 ? 0 : "MSETLED";
}

int main(void) {
  const char *failed = move();
  if (failed) say(0, failed);
  for (;;) {
  }
}
