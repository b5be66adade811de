/* SPDX-License-Identifier: Apache-2.0 */
/* Musashi's 68020 behind iss.h. The core is one set of globals: whoever runs is swapped in. */
#include <stdlib.h>
#include <string.h>

#include "../iss.h"
#include "m68kcpu.h"

#define EXPORT __attribute__((visibility("default")))
#define LINES 64      /* longwords of instruction cache, direct mapped */
#define MISS_CYCLES 3 /* a bus cycle without wait states; none of it is taken to overlap */

struct iss {
  struct iss_bus bus;
  struct iss_timing timing;
  uint32_t ram;
  uint8_t *memory;
  int64_t cycles; /* of iss_run() calls that ended, and extra ones */
  int running;
  uint32_t tag[LINES]; /* address of the longword + 1 */
  m68ki_cpu_core core; /* while swapped out */
};

/* The part of the core that changes and holds no pointers. */
#define CORE_BYTES offsetof(m68ki_cpu_core, cyc_instruction)

static struct iss *now;

static void enter(struct iss *iss) {
  if (now == iss) return;
  if (now != NULL) m68k_get_context(&now->core);
  m68k_set_context(&iss->core);
  now = iss;
}

/* --- memory ---------------------------------------------------------------------------------- */

static unsigned load(uint32_t address, int size) {
  const uint8_t *m = now->memory + address;
  if (size == 1) return m[0];
  if (size == 2) return (unsigned)m[0] << 8 | m[1];
  return (unsigned)m[0] << 24 | (unsigned)m[1] << 16 | (unsigned)m[2] << 8 | m[3];
}

static int inside(uint32_t address, int size) {
  return address < now->ram && now->ram - address >= (uint32_t)size;
}

/* A second fault while the frame of the first is pushed halts the processor for good. */
static void bus_error(void) {
  if (m68ki_cpu.run_mode == RUN_MODE_BERR_AERR_RESET_WSF) {
    m68ki_cpu.stopped = STOP_LEVEL_HALT;
    SET_CYCLES(0);
    return;
  }
  m68k_pulse_bus_error();
}

static unsigned get(uint32_t address, int size) {
  uint32_t value = 0;
  if (inside(address, size)) {
    now->cycles += now->timing.wait_states;
    return load(address, size);
  }
  if (now->bus.read(now->bus.ctx, address, size, &value) != 0) bus_error();
  return value;
}

static void put(uint32_t address, int size, uint32_t value) {
  if (!inside(address, size)) {
    if (now->bus.write(now->bus.ctx, address, size, value) != 0) bus_error();
    return;
  }
  now->cycles += now->timing.wait_states;
  for (int n = size - 1; n >= 0; n--, value >>= 8)
    now->memory[address + (uint32_t)n] = (uint8_t)value;
}

static unsigned fetch(uint32_t address, int size) {
  if (!inside(address, size)) return get(address, size);
  if (now->timing.cache) {
    for (uint32_t at = address & ~3u; at < address + (uint32_t)size; at += 4) {
      uint32_t *tag = &now->tag[at / 4 % LINES];
      if (*tag == at + 1) continue;
      *tag = at + 1;
      now->cycles += MISS_CYCLES + now->timing.wait_states;
    }
  }
  return load(address, size);
}

unsigned int m68k_read_memory_8(unsigned int address) {
  return get(address, 1);
}
unsigned int m68k_read_memory_16(unsigned int address) {
  return get(address, 2);
}
unsigned int m68k_read_memory_32(unsigned int address) {
  return get(address, 4);
}
unsigned int m68k_read_immediate_16(unsigned int address) {
  return fetch(address, 2);
}
unsigned int m68k_read_immediate_32(unsigned int address) {
  return fetch(address, 4);
}
unsigned int m68k_read_pcrelative_8(unsigned int address) {
  return get(address, 1);
}
unsigned int m68k_read_pcrelative_16(unsigned int address) {
  return get(address, 2);
}
unsigned int m68k_read_pcrelative_32(unsigned int address) {
  return get(address, 4);
}
void m68k_write_memory_8(unsigned int address, unsigned int value) {
  put(address, 1, value);
}
void m68k_write_memory_16(unsigned int address, unsigned int value) {
  put(address, 2, value);
}
void m68k_write_memory_32(unsigned int address, unsigned int value) {
  put(address, 4, value);
}

int mmcs_m68020_acknowledge(int level) {
  int vector = now->bus.acknowledge(now->bus.ctx, level);
  if (vector == -1) return (int)M68K_INT_ACK_AUTOVECTOR;
  return vector < 0 ? (int)M68K_INT_ACK_SPURIOUS : vector;
}

/* --- iss.h ----------------------------------------------------------------------------------- */

EXPORT int iss_abi(void) {
  return MMCS_ISS_ABI;
}

EXPORT struct iss *iss_create(uint32_t ram, const uint8_t *image, size_t size,
                              const struct iss_bus *bus, const struct iss_timing *timing) {
  static int ready;
  struct iss *iss = calloc(1, sizeof *iss);
  if (iss == NULL || size > ram || (iss->memory = calloc(1, ram)) == NULL) {
    free(iss);
    return NULL;
  }
  memcpy(iss->memory, image, size);
  iss->ram = ram;
  iss->bus = *bus;
  iss->timing = *timing;
  if (!ready) m68k_init();
  ready = 1;
  m68k_get_context(&iss->core);
  enter(iss);
  m68k_set_cpu_type(M68K_CPU_TYPE_68020);
  m68k_pulse_reset();
  return iss;
}

EXPORT void iss_destroy(struct iss *iss) {
  if (iss == NULL) return;
  if (now == iss) now = NULL;
  free(iss->memory);
  free(iss);
}

EXPORT int iss_run(struct iss *iss, int cycles) {
  enter(iss);
  int64_t before = iss->cycles;
  iss->running = 1;
  int used = m68k_execute(cycles);
  iss->running = 0;
  iss->cycles += used;
  return (int)(iss->cycles - before);
}

EXPORT int64_t iss_cycles(const struct iss *iss) {
  return iss->cycles + (iss->running ? m68k_cycles_run() : 0);
}

EXPORT int iss_stopped(const struct iss *iss) {
  return (now == iss ? m68ki_cpu.stopped : iss->core.stopped) != 0;
}

EXPORT void iss_set_level(struct iss *iss, int level) {
  enter(iss);
  m68k_set_irq((unsigned)level);
}

EXPORT uint32_t iss_pc(struct iss *iss) {
  enter(iss);
  return m68ki_cpu.pc;
}

EXPORT uint8_t *iss_memory(struct iss *iss) {
  return iss->memory;
}

EXPORT size_t iss_state_size(void) {
  return CORE_BYTES + sizeof(int64_t) + sizeof(((struct iss *)0)->tag);
}

EXPORT void iss_get_state(struct iss *iss, uint8_t *bytes) {
  enter(iss);
  memcpy(bytes, &m68ki_cpu, CORE_BYTES);
  memcpy(bytes + CORE_BYTES, &iss->cycles, sizeof iss->cycles);
  memcpy(bytes + CORE_BYTES + sizeof iss->cycles, iss->tag, sizeof iss->tag);
}

EXPORT void iss_set_state(struct iss *iss, const uint8_t *bytes) {
  enter(iss);
  memcpy(&m68ki_cpu, bytes, CORE_BYTES);
  memcpy(&iss->cycles, bytes + CORE_BYTES, sizeof iss->cycles);
  memcpy(iss->tag, bytes + CORE_BYTES + sizeof iss->cycles, sizeof iss->tag);
}
