/* SPDX-License-Identifier: Apache-2.0 */
/* What the engine wants of an instruction-set simulator, as a C ABI of its own library, so that
 * the engine is the same whether one is installed or not. */
#ifndef MMCS_ISS_H
#define MMCS_ISS_H

#include <stddef.h>
#include <stdint.h>

#define MMCS_ISS_ABI 2

#ifdef __cplusplus
extern "C" {
#endif

/* What lies outside the processor's memory. Functions return 0, or 1 for a bus error. */
struct iss_bus {
  void *ctx;
  int (*read)(void *ctx, uint32_t address, int size, uint32_t *value);
  int (*write)(void *ctx, uint32_t address, int size, uint32_t value);
  /* The acknowledge cycle of a level: a vector, -1 autovector, -2 spurious. */
  int (*acknowledge)(void *ctx, int level);
};

/* How long things take beyond the processor's own count of cycles. */
struct iss_timing {
  int32_t cache;       /* 1: the 256 bytes of instruction cache are modelled; 0: all fetches hit */
  int32_t wait_states; /* per access to memory, fetches that hit the cache excepted */
};

struct iss;

int iss_abi(void);
/* Memory of `ram` bytes from address 0 with the image at its begin; then reset. NULL: no room. */
struct iss *iss_create(uint32_t ram, const uint8_t *image, size_t size, const struct iss_bus *bus,
                       const struct iss_timing *timing);
void iss_destroy(struct iss *iss);
/* Runs for at least so many cycles, less on STOP; returns the cycles used. */
int iss_run(struct iss *iss, int cycles);
/* Cycles used so far, within iss_run() too. */
int64_t iss_cycles(const struct iss *iss);
int iss_stopped(const struct iss *iss);
/* The level that is requested now. */
void iss_set_level(struct iss *iss, int level);
uint32_t iss_pc(struct iss *iss);
uint8_t *iss_memory(struct iss *iss);
/* Registers and cache as bytes without addresses of this process, for snapshots. */
size_t iss_state_size(void);
void iss_get_state(struct iss *iss, uint8_t *bytes);
void iss_set_state(struct iss *iss, const uint8_t *bytes);

#ifdef __cplusplus
}
#endif
#endif
