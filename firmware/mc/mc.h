/* SPDX-License-Identifier: Apache-2.0 */
/* The mc driver, §2.3: what a host calls, and what it must provide.
 *
 * Freestanding C11. No allocation, no floating point. The driver reaches the hardware through
 * struct mc_bus and its host through struct mc_os; nothing else differs between ports.
 */
#ifndef MC_H
#define MC_H

#include <stddef.h>
#include <stdint.h>

#include "mcdef.h"

/* Errors are negative Unix numbers, the same on every port. */
#define MC_EIO 5
#define MC_ENXIO 6
#define MC_EBADF 9
#define MC_EFAULT 14
#define MC_EBUSY 16
#define MC_EINVAL 22
#define MC_ENFILE 23
#define MC_ENOTTY 25

enum mc_bus_result { MC_BUS_OK = 0, MC_BUS_TIMEOUT = 1, MC_BUS_ERROR = 2 };

/* The bus below: one byte at an odd offset (0x001..0x7FF) of the adaptor's 2 KiB window. */
struct mc_bus {
  void *ctx;
  /* Reads one byte; on failure *value is unspecified and the result is not MC_BUS_OK. */
  enum mc_bus_result (*read8)(void *ctx, uint16_t offset, uint8_t *value);
  enum mc_bus_result (*write8)(void *ctx, uint16_t offset, uint8_t value);
  /* The same for n > 0 offsets in order, for processors on which a call costs more than an access;
   * null: read8 and write8 do it. All are tried; a byte that cannot be read becomes 0xFF, and the
   * result is not MC_BUS_OK if any failed. */
  enum mc_bus_result (*read_list)(void *ctx, const uint16_t *offsets, uint8_t *values, unsigned n);
  enum mc_bus_result (*write_list)(void *ctx, const uint16_t *offsets, const uint8_t *values,
                                   unsigned n);
};

/* The host around: all may be called from the interrupt handler except delay_us, copy_*. */
struct mc_os {
  void *ctx;
  /* Delivers SIGUSR1 to the process behind an open descriptor (client 0..MC_MAX_CLIENTS-1). */
  void (*signal)(void *ctx, int client);
  /* One line of text for the console, no newline. */
  void (*log)(void *ctx, const char *text);
  /* Called once per servo pass between the reads and the writes: a host model lets the time of
   * the computation of `axes` axes pass here; a real processor does nothing. */
  void (*compute)(void *ctx, unsigned axes);
  /* Waits at least `us` microseconds in process context. Interrupts may come meanwhile. */
  void (*delay_us)(void *ctx, uint32_t us);
  /* Masks the interrupt level; returns what unmask must be given back. Nests. */
  unsigned (*mask)(void *ctx);
  void (*unmask)(void *ctx, unsigned previous);
  /* Copies from or to the calling process: 0, or -MC_EFAULT. */
  int (*copy_in)(void *ctx, void *to, const void *from_user, size_t len);
  int (*copy_out)(void *ctx, void *to_user, const void *from, size_t len);
};

struct mc_config {
  uint32_t sysclk_hz; /* rate of the system clock that feeds timer 0: 8, 4, 2 or 1 MHz */
  uint8_t vector;     /* interrupt vector number written to 0x441 */
  uint32_t speed;     /* of the fastest axis, counts/s; 0: not known */
};

#define MC_MAX_CARDS 16
#define MC_MAX_AXES 32
#define MC_MAX_CLIENTS 16

/* Open flags, as open(2). */
enum { MC_O_RDONLY = 0, MC_O_WRONLY = 1, MC_O_RDWR = 2 };

/* Defined in mc_priv.h. A host gives it zeroed memory: mc_size() bytes, or, where nothing can be
 * allocated, `static uint64_t memory[MC_WORDS]`, which is enough on every processor. */
struct mc;
#define MC_WORDS 1264

size_t mc_size(void);

/* Binds bus, host and configuration; touches no hardware. 0, or -MC_EINVAL. All members of all
 * three are looked at: name those that are meant in an initializer, so that the others are 0. */
int mc_attach(struct mc *mc, const struct mc_bus *bus, const struct mc_os *os,
              const struct mc_config *config);

/* open(2): returns the client number, or a negative error. First open scans and initialises. */
int mc_open(struct mc *mc, int flags);
int mc_close(struct mc *mc, int client);
/* ioctl(2): `arg` is a pointer in the calling process (or ignored). 0, or a negative error. */
int mc_ioctl(struct mc *mc, int client, uint32_t request, void *arg);
/* read(2), write(2): bytes moved, or a negative error. */
int mc_read(struct mc *mc, int client, void *user_buf, size_t len);
int mc_write(struct mc *mc, int client, const void *user_buf, size_t len);

/* A stop that needs no descriptor: the host's own, or that of a process which only looks on. As
 * MSTOP: zero torque, all modes off, calibrations given up, brakes. May be called at any time but
 * from within another call of the driver's on the same processor, interrupts masked or not. A
 * device that nobody has open is at rest: nothing happens. 0, or -MC_EIO.
 *
 * A stop, this or MSTOP, is latched: write() fails with EIO until an MENABLE succeeds. One that
 * comes while MENABLE waits makes that fail. */
int mc_halt(struct mc *mc);

/* The interrupt handler: call with the level masked, after the acknowledge cycle. Returns 1 if a
 * servo pass ran, 0 if not (panic only, or spurious). */
int mc_interrupt(struct mc *mc);
/* The acknowledge cycle failed: counts a spurious interrupt. */
void mc_spurious(struct mc *mc);
/* So many microseconds no interrupt has come: a host that has a clock calls it every 10 ms or so,
 * so that the writers are told of a SYSRESET*, which turns the interrupts off, and that these are
 * on again as soon as the adaptor answers. */
int mc_watch(struct mc *mc, uint64_t us); /* 1: they have been told */

/* For the host's log, valid after every call: what is in force, and what was published last, of an
 * axis below mc_joints(). */
int mc_joints(const struct mc *mc);
int32_t mc_setpoint(const struct mc *mc, int axis); /* as write() or the driver set it */
int32_t mc_demand(const struct mc *mc, int axis);   /* behind S1: the setpoint, or phi */
int mc_current(const struct mc *mc, int axis);      /* at the D/A, without ipole's filter */
const struct mc_param *mc_param_of(const struct mc *mc, int axis);
const struct mc_state *mc_state_of(const struct mc *mc, int axis);
int mc_is_enabled(const struct mc *mc); /* the servo writes the D/As */
int mc_is_stopped(const struct mc *mc); /* a stop is latched */
/* What shut the machine down, MCAUSE_... of <sys/mmcs.h>, until an MENABLE; *number: its axis or
 * card (DIP switch), or -1. */
int mc_cause(const struct mc *mc, int *number);
uint32_t mc_interval(const struct mc *mc); /* us between SCLOCKs */
int mc_diag(const struct mc *mc);          /* as MDIAGMODE asked */
int mc_double_buffer(const struct mc *mc); /* as MDACMODE asked */
const struct mc_stats *mc_stats_of(const struct mc *mc);

#endif
