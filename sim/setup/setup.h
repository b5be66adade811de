/* SPDX-License-Identifier: Apache-2.0 */
/* The one reader of set-ups (mmcs_service.h). */
#ifndef MMCS_SETUP_READER_H
#define MMCS_SETUP_READER_H

#include <stdbool.h>

#include "mcdef.h"
#include "mmcs_service.h"
#include "mmcs_sim.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A checked copy of a set-up, with its overrides: the records of each kind, and how many. */
struct setup {
  mmcs_setup *head;
#define RECORD(kind, type) \
  type *kind;              \
  size_t kind##s;
#include "records.def"
};

/* False, and one sentence in err: then there is nothing to close. */
bool setup_open(struct setup *setup, const void *data, size_t size, const mmcs_overrides *overrides,
                char *err, size_t err_len);
void setup_close(struct setup *setup);

#ifdef __cplusplus
}
#endif
#endif
