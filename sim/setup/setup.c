// SPDX-License-Identifier: Apache-2.0
// Reads set-ups: mmcs_service.h.

#include "setup.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "set-ups are read as they are stored");

enum { ALIGNED = 8 };
enum {
#define RECORD(kind, type) KIND_##kind,
#include "records.def"
  KINDS
};
_Static_assert((int)KINDS == MMCS_SETUP_KINDS, "mmcs_service.h counts the kinds");

static bool refuse(char *err, size_t err_len, const char *format, ...) {
  va_list values;
  va_start(values, format);
  if (err && err_len) vsnprintf(err, err_len, format, values);
  va_end(values);
  return false;
}

// CRC-32 of IEEE 802.3, as zlib has it.
static uint32_t checksum(const uint8_t *data, size_t size) {
  uint32_t sum = 0xFFFFFFFF;
  for (size_t n = 0; n < size; n++) {
    sum ^= data[n];
    for (int bit = 0; bit < 8; bit++) sum = sum >> 1 ^ (sum & 1 ? 0xEDB88320 : 0);
  }
  return ~sum;
}

// What is wrong with the bytes, or NULL.
static const char *wrong_bytes(const mmcs_setup *head, size_t size) {
  if (size < sizeof head->magic || memcmp(head->magic, "mmcsset\n", sizeof head->magic) != 0)
    return "this is no set-up";
  if (size < sizeof *head || size < head->bytes) return "the set-up is cut short";
  const uint8_t *checked = (const uint8_t *)&head->build;
  const size_t before = (size_t)(checked - (const uint8_t *)head);
  if (size != head->bytes || checksum(checked, size - before) != head->sum)
    return "the set-up is damaged";
  return NULL;
}

static bool override(struct setup *s, const mmcs_overrides *over, char *err, size_t err_len) {
  if (over->what & MMCS_OVER_SEED && over->seed != s->config->seed) {
    if (s->head->by_seed)
      return refuse(err, err_len,
                    "%s has a [[process]] with jitter by its seed: `mmcs compile` it "
                    "with another seed",
                    s->head->name);
    s->config->seed = over->seed;
  }
  if (over->what & MMCS_OVER_DURATION) s->head->duration = over->duration;
  if (over->what & MMCS_OVER_SKIP) s->config->skip = over->skip;
  if (over->what & MMCS_OVER_EVENTS) {
    s->event = (mmcs_timed_event *)over->events;
    s->events = (size_t)over->event_count;
  }
  if (over->what & MMCS_OVER_CALLS) {
    s->call = (mmcs_call *)over->calls;
    s->calls = (size_t)over->call_count;
    s->set = (mmcs_set *)over->sets;
    s->sets = (size_t)over->set_count;
  }
  return true;
}

bool setup_open(struct setup *s, const void *data, size_t size, const mmcs_overrides *overrides,
                char *err, size_t err_len) {
  memset(s, 0, sizeof *s);
  s->head = data && size ? malloc(size) : NULL;  // aligned, and to be changed
  if (!s->head) return refuse(err, err_len, "there is no set-up");
  memcpy(s->head, data, size);
  const char *wrong = wrong_bytes(s->head, size);
  if (!wrong) {
    s->head->build[sizeof s->head->build - 1] = s->head->name[sizeof s->head->name - 1] = 0;
    char *at = (char *)(s->head + 1);
    const uint32_t *count = s->head->count;
#define RECORD(kind, type) \
  s->kind = (type *)at;    \
  s->kind##s = *count++;   \
  at += (s->kind##s * sizeof(type) + ALIGNED - 1) / ALIGNED * ALIGNED;
#include "records.def"
  }
  bool good = false;
  if (wrong)
    refuse(err, err_len, "%s: make it by `mmcs compile`", wrong);
  else if (strcmp(s->head->build, mmcs_sim_build_id()) != 0)
    refuse(err, err_len, "%s is for the simulator %s, and this is %s: `mmcs compile` it again",
           s->head->name, s->head->build, mmcs_sim_build_id());
  else
    good = !overrides || override(s, overrides, err, err_len);
  if (!good) setup_close(s);
  return good;
}

void setup_close(struct setup *setup) {
  free(setup->head);
}

mmcs_sim *mmcs_sim_create_from(const void *data, size_t size, const mmcs_overrides *overrides,
                               char *err, size_t err_len) {
  struct setup s;
  if (!setup_open(&s, data, size, overrides, err, err_len)) return NULL;
  mmcs_sim *sim = mmcs_sim_create(s.config, s.motor, s.links ? s.link : NULL, err, err_len);
  setup_close(&s);
  return sim;
}

void *mmcs_setup_load(const char *path, size_t *size, char *err, size_t err_len) {
  FILE *file = fopen(path, "rb");
  char *data = NULL;
  long length = -1;
  if (file && fseek(file, 0, SEEK_END) == 0) length = ftell(file);
  if (length >= 0 && fseek(file, 0, SEEK_SET) == 0) data = malloc((size_t)length + 1);
  if (data) {
    *size = fread(data, 1, (size_t)length, file);
  } else {
    refuse(err, err_len, "%s: there is no such set-up: make it by `mmcs compile`", path);
  }
  if (file) fclose(file);
  return data;
}
