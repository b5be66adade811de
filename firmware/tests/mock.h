/* SPDX-License-Identifier: Apache-2.0 */
/* A register-level model of adaptor and cards, and of the host around the driver.
 *
 * Time is counted in microseconds; every bus access takes one. Good for the order of accesses and
 * for the driver's decisions; the RTL is the judge of everything else. */
#ifndef MOCK_H
#define MOCK_H

#include "mc.h"
#include "mmcs_regs.h"

#define MOCK_LOG 4096
#define MOCK_HEARTBEAT_US 50000

struct mock_card {
  int present, enabled[2]; /* front switches */
  uint8_t a, b, mode_word;
  uint16_t count[2], latched[2], snapshot[2];
  int has_latch[2];
  int paired;  /* the register whose other byte comes from the snapshot if it is next, or -1 */
  int written; /* the same of writes: `held` was written there */
  uint8_t held;
  int joint[2];        /* A and B of the encoder, bits 1 and 0 */
  uint8_t input[2][3]; /* the same as the counter took them in at its last ticks, latest first */
  uint8_t dac_low[2], dac_high[2];
  int64_t beat_until[2];
  uint16_t adc[2];
  int64_t adc_until;
  int index[2];
};

struct mock_access {
  int write;
  uint16_t offset;
  uint8_t value;
};

struct mock {
  struct mc_bus bus;
  struct mc_os os;
  void *memory;
  int64_t now;
  int adaptor_dead;
  int dac_errors; /* so many D/A writes of card 0 end in a bus error */
  struct mock_card card[16];
  uint8_t pccsr, sclock_latch, panic_latch, vector;
  int estop_open, panic;
  /* timers: 0 and 1 as one divider in us, 2 as its count of falls */
  uint32_t n[3];
  uint8_t byte_no[3], latch_no, status;
  uint16_t latch2;
  int has_status, has_latch2;
  int load2, fresh2; /* a count waits; and no rise of SCLOCK has come since it was written */
  int64_t period, phase, origin, low_us, falls;
  int level_high;
  /* host */
  int masked, serving, ack_broken;
  int signals[MC_MAX_CLIENTS];
  int passes; /* mc_interrupt() that returned 1 */
  int64_t compute_us, latency_us, irq_since;
  int computed_axes, computes;
  char last_log[128];
  int logs;
  int bad_pointer; /* copies fail */
  int logging, used;
  struct mock_access log[MOCK_LOG];
  int brakes_released, releases;
  void (*on_access)(struct mock *m); /* a test's hook, called after each access */
};

/* Digest of all accesses, texts and signals, and of what a test itself has told. */
extern uint32_t mock_told;
void mock_tell(uint32_t word);
/* A new driver, of which `m` has had another, or is all 0. */
struct mc *mock_start(struct mock *m, int cards);
void mock_run(struct mock *m, int64_t us);
/* To the end of the next pass. */
void mock_pass(struct mock *m);
/* A driver opened for reading and writing: client 0. */
struct mc *mock_open(struct mock *m, int cards);
/* Level of the heartbeats and everything else that makes PANIC. */
int mock_panic(const struct mock *m);
uint16_t mock_dac(const struct mock *m, int axis);

#endif
