/* SPDX-License-Identifier: Apache-2.0 */
/* A set-up: a scenario checked and compiled (`mmcs compile`), from which every machine is made. A
 * build product for one build of the simulator, no format for exchange: that is the scenario. Like
 * mmcs_sim.h it includes no other header of ours, and Python reads it.
 *
 * Little-endian: this head, then the records of each kind of sim/setup/records.def in its order,
 * each kind padded to 8 bytes. No pointers: one record names others by their place in their kind.
 */
#ifndef MMCS_SETUP_H
#define MMCS_SETUP_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

struct mmcs_sim;
struct mmcs_script;
struct mmcs_timed_event;
struct mmcs_call;
struct mmcs_set;

#define MMCS_SETUP_KINDS 13
typedef struct mmcs_setup {
  char magic[8];   /* "mmcsset\n" */
  uint32_t bytes;  /* of all of it */
  uint32_t sum;    /* CRC-32 of what follows this field */
  char build[64];  /* mmcs_sim_build_id() of the build that it is for */
  char name[64];   /* of the scenario */
  double duration; /* of the motion, s */
  int32_t clk_hz;  /* of the machine */
  int32_t by_seed; /* 1: records depend on the seed, which then cannot be another one */
  uint32_t count[MMCS_SETUP_KINDS]; /* records of each kind */
} mmcs_setup;

/* What is to be otherwise than in the set-up. */
enum {
  MMCS_OVER_SEED = 1,
  MMCS_OVER_DURATION = 2,
  MMCS_OVER_EVENTS = 4,
  MMCS_OVER_CALLS = 8,
  MMCS_OVER_SKIP = 16
};
typedef struct mmcs_overrides {
  uint64_t seed;
  double duration;
  const struct mmcs_timed_event *events;
  const struct mmcs_call *calls; /* in order of time */
  const struct mmcs_set *sets;   /* of the calls */
  int32_t what;                  /* MMCS_OVER_...: those that count */
  int32_t event_count, call_count, set_count;
  int32_t skip; /* of mmcs_config */
} mmcs_overrides;

/* The machine of a set-up in power-on state, and what is done with it; overrides may be NULL. The
 * data is not needed afterwards. NULL on error, with one sentence in err: the data is no set-up,
 * cut short, damaged, of another build, or the machine is impossible. On success err holds a
 * caution, or is empty. */
struct mmcs_sim *mmcs_sim_create_from(const void *data, size_t size,
                                      const mmcs_overrides *overrides, char *err, size_t err_len);
struct mmcs_script *mmcs_script_create_from(const void *data, size_t size,
                                            const mmcs_overrides *overrides, char *err,
                                            size_t err_len);
/* A file's bytes for both, to be freed by free(). NULL and one sentence if it cannot be read. */
void *mmcs_setup_load(const char *path, size_t *size, char *err, size_t err_len);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
