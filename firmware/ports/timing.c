/* SPDX-License-Identifier: Apache-2.0 */
/* The arithmetic of bench.c on the SoC's own core, which counts its cycles.
 * docs/simulator/processors.md.
 *
 * The mailbox serves one request, MAILBOX_CLOSE, whose client is profile + 16 * ticks + what << 28:
 * what = 0 runs and gives the cycles of all passes together, 1 those of the longest pass of the run
 * before, 2 its hash. Interrupts stay off. */
#include <stdint.h>

static void timing_mark(uint32_t on);
#define BENCH_MARK(value) timing_mark(value)
#define BENCH_NATIVE
#include "bench.c" /* NOLINT(bugprone-suspicious-include): with another mark and no block */
#include "mailbox.h"

#define BOX ((volatile struct mailbox *)MAILBOX_BASE)
#define CSR(instruction) ".option push\n.option arch, +zicsr\n" instruction "\n.option pop"

void timing_main(void);
void timing_dead(uint32_t cause, uint32_t pc);

static uint32_t begun, total, longest, empty;

static inline uint32_t cycles(void) {
  uint32_t now;
  __asm__ volatile(CSR("csrr %0, mcycle") : "=r"(now)::"memory");
  return now;
}

static void timing_mark(uint32_t on) {
  if (on) {
    begun = cycles();
    return;
  }
  uint32_t span = cycles() - begun - empty;
  total += span;
  if (span > longest) longest = span;
}

static void report(enum mailbox_report what) {
  *(volatile uint32_t *)MAILBOX_REPORT = what;
}

static uint32_t serve(uint32_t request) {
  static uint32_t result;
  uint32_t what = request >> 28;
  if (what == 0) {
    total = longest = 0;
    result = bench(request & 15, request >> 4 & 0xFFFFFF);
  }
  return what == 0 ? total : what == 1 ? longest : result;
}

void timing_main(void) {
  __asm__ volatile(CSR("csrw mcountinhibit, zero"));
  timing_mark(1);
  timing_mark(0);
  empty = total; /* what looking costs */
  BOX->joints = 0;
  for (int n = 0; n < 6; n++) BOX->stats[n] = 0;
  BOX->posted = BOX->done = 0;
  BOX->version = MAILBOX_VERSION;
  BOX->magic = MAILBOX_MAGIC;
  report(MAILBOX_UP);
  for (;;) {
    while (BOX->posted == BOX->done) {
    }
    BOX->result = (int32_t)serve((uint32_t)BOX->client);
    BOX->done = BOX->posted;
    report(MAILBOX_DONE);
  }
}

void timing_dead(uint32_t cause, uint32_t pc) {
  BOX->fault = cause;
  BOX->fault_pc = pc;
  report(MAILBOX_DEAD);
}
