/* SPDX-License-Identifier: Apache-2.0 */
/* The simulator as a C ABI, for the Python package, the page, FMUs and programs of your own. It
 * includes no other header of ours; plant, model, engine and service include it. mmcs_service.h has
 * what stands above the machine: scenarios, served machines, records, control design.
 *
 * Python reads this very file through cffi, so it holds plain C declarations only: no macros but
 * integer constants, no conditionals but the include guard. Angles are radians, times seconds,
 * torques N m at the motor shaft, analog values volts, unless a comment says otherwise.
 */
#ifndef MMCS_SIM_H
#define MMCS_SIM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif
/* These functions, and nothing else, are visible outside the library. */
#pragma GCC visibility push(default)

/* One axis: amplifier, motor, gear, encoder, potentiometer, brake. */
typedef struct mmcs_motor {
  double inertia; /* kg m^2 at the motor: rotor, plus reflected load when the axis stands alone */
  double viscous; /* N m s/rad */
  double coulomb_pos;  /* N m, motor turning positive */
  double coulomb_neg;  /* N m, motor turning negative, given positive */
  double stiction_pos; /* N m, >= coulomb_pos */
  double stiction_neg;
  double km;         /* N m/A */
  double resistance; /* ohm */
  double v_supply;   /* V, effective; limits speed by back-EMF; 0 = no limit */
  double amp_gain;   /* A/V of drive */
  double amp_max;    /* A, current limit; 0 = none */
  double amp_tau;    /* s, current-loop time constant; 0 = ideal */
  double gear;       /* motor revolutions per joint revolution, signed */
  double stop_lo;    /* rad at the joint; stop_lo >= stop_hi = no stops */
  double stop_hi;
  double pot_v_per_rad;       /* V per joint rad into the A/D */
  double pot_offset;          /* V at joint angle 0 */
  double angle0;              /* rad, joint angle at t = 0 */
  double gravity;             /* N m at the motor, constant load, for axes that stand alone */
  double brake_torque;        /* N m at the motor; 0 = no brake */
  double brake_delay;         /* s from loss of power to full torque */
  double stiffness;           /* N m/rad at the joint side of a flexible coupling; 0 = rigid */
  double damping;             /* N m s/rad of that coupling */
  double backlash;            /* rad at the joint */
  double load_inertia;        /* kg m^2 at the joint beyond the coupling (flexible axes only) */
  int32_t counts_per_rev;     /* encoder counts (x4) per motor revolution */
  int32_t index_per_rev;      /* index pulses per motor revolution, 0 or 1 */
  double brake_release_delay; /* s from power to a free shaft */
  double encoder_offset;      /* rad at the motor: encoder disc turned against the shaft */
} mmcs_motor;

/* One link of a serial arm (standard Denavit-Hartenberg); joints are the axes in order. */
typedef struct mmcs_link {
  double alpha, a, d, theta0; /* rad, m, m, rad */
  double mass;                /* kg */
  double com[3];              /* m, in the link frame */
  double inertia[6];          /* kg m^2 about the COM: xx yy zz xy yz xz */
} mmcs_link;

typedef struct mmcs_config {
  int32_t cards; /* 1..16, must equal the model's build */
  int32_t axes;  /* motors connected, <= 2*cards */
  int32_t links; /* 0: axes stand alone; else == axes: coupled arm */
  int32_t skip;  /* 1: event skipping on, if the model was built for it */
  uint64_t seed;
  double gravity[3];         /* m/s^2 in the base frame, for the arm */
  double cpu_us_per_axis;    /* servo computation time of the host, per axis and interrupt */
  double latency_max_us;     /* interrupt latency is uniform in 0..this, by seed */
  double bus_timeout_us;     /* VME bus timer */
  int32_t amp_panic_cut;     /* 1: amplifiers are disabled while PANIC is high */
  int32_t host;              /* what runs the firmware: one of MMCS_HOST_... */
  int32_t wait_states;       /* of a real processor's memory */
  int32_t instruction_cache; /* its bytes: 256, or 0 for one in which every fetch hits */
  int32_t axis_speed;        /* counts/s, of the fastest axis: struct mc_config; 0: not known */
  char processor[256];       /* file names for a real processor: its library, */
  char firmware[256];        /* and the image that it runs */
  char card[256];            /* the library of cards of one's own; "": none */
} mmcs_config;
enum { MMCS_HOST_NATIVE = 0, MMCS_HOST_M68020 = 1 };

/* A motion: what the user program writes as the setpoint of one axis, in counts (or the axis'
 * own setpoint units), evaluated at every servo sample. Segments of one axis follow each other. */
enum {
  MMCS_SEG_HOLD = 0,
  MMCS_SEG_STEP = 1,
  MMCS_SEG_RAMP = 2,
  MMCS_SEG_QUINTIC = 3,
  MMCS_SEG_TRAPEZOID = 4,
  MMCS_SEG_SINE = 5,
  MMCS_SEG_CHIRP = 6,
  MMCS_SEG_TABLE = 7,
  MMCS_SEG_SQUARE = 8
};
typedef struct mmcs_segment {
  int32_t axis;
  int32_t kind;
  double t0;        /* s, start */
  double duration;  /* s */
  double to;        /* target value (HOLD, STEP, RAMP, QUINTIC, TRAPEZOID), or mean (SINE, ...) */
  double amplitude; /* SINE, CHIRP, SQUARE */
  double f0, f1;    /* Hz; CHIRP sweeps f0..f1 */
  double v_max, a_max;         /* TRAPEZOID, units/s and units/s^2; 0 = from the duration */
  int32_t table_at, table_len; /* TABLE: of the numbers, values at equal distances in time */
} mmcs_segment;

/* Something that happens at a time: a named input of the machine or the plant takes a value.
 * The names are listed by mmcs_sim_input_name(). */
typedef struct mmcs_event {
  double t;
  int32_t input; /* index of the name */
  int32_t index; /* axis or card it applies to, else 0 */
  double value;
} mmcs_event;

typedef struct mmcs_stats {
  uint64_t cycles; /* clocks simulated */
  uint64_t evals;  /* model evaluations (fewer than cycles when skipping) */
  double time_s;   /* simulated time */
  int32_t interrupts, missed, overruns, panics, spurious, clips; /* the driver's */
  int32_t bus_errors;  /* bus time-outs and errors seen by the master */
  int32_t panic_level; /* system PANIC now */
  uint64_t bus_cycles;
  int32_t enabled;                                /* the servo drives the motors */
  int32_t stopped;                                /* a stop is latched */
  int32_t cause, cause_of;                        /* mc_cause() */
  int32_t interval_us, diag, double_buffer;       /* as the driver has them */
  uint64_t cache_hits, cache_misses, cache_bytes; /* of all caches, see mmcs_sim_caches() */
} mmcs_stats;

/* What happened, in the order it happened (PANIC, errors, signals, faults injected, messages). */
typedef struct mmcs_note {
  double t;
  char kind[16]; /* "panic", "error", "signal", "fault", "log", "bus", "assert" */
  int32_t axis;  /* -1: none */
  char text[100];
} mmcs_note;

/* The running hashes after so many servo samples: all samples, and everything that left the
 * machine (bus cycles, drive voltages, lines). Kept every 32 samples. */
typedef struct mmcs_checkpoint {
  int64_t samples;
  int64_t clock;
  uint64_t hash;
  uint64_t trail;
} mmcs_checkpoint;

/* A snapshot that the simulation keeps. */
typedef struct mmcs_snapshot {
  int64_t id;
  int64_t clock;
  double t;
  int64_t bytes;
  int64_t rows;  /* of the log so far */
  int64_t deeds; /* done so far */
  int32_t kept;  /* 1: until it is dropped; 0: by the ring */
} mmcs_snapshot;

typedef struct mmcs_sim mmcs_sim;

/* Creates a machine in power-on state at t = 0: for mmcs_sim_create_from() of mmcs_service.h, which
 * all others use. The values are those of a checked scenario. NULL on error, with one sentence in
 * err. */
mmcs_sim *mmcs_sim_create(const mmcs_config *config, const mmcs_motor *motors,
                          const mmcs_link *links, char *err, size_t err_len);
void mmcs_sim_destroy(mmcs_sim *sim);

/* What this build of the model is. */
int32_t mmcs_sim_build_cards(void);
int32_t mmcs_sim_build_clk_hz(void);
/* Kind, cards and a digest of all sources: what a snapshot must match. */
const char *mmcs_sim_build_id(void);

/* FST waveforms of a stretch (s). The file is created at its beginning, or now if that has passed:
 * -1 if this build has no tracing or the file can't be made. Later a note says so. */
int mmcs_sim_trace(mmcs_sim *sim, const char *path, double from_s, double to_s);

/* Waveforms without a file: the changes of watched nets, clock by clock. A net is a register, or a
 * port of a board or chip, of 32 bits at most, by its name from rtl/mmcs.sv down. Only a machine
 * that does not skip sees every clock; a trace build has traces instead. */
typedef struct mmcs_change {
  int64_t clock;
  int32_t net;
  uint32_t value;
} mmcs_change;
/* Watches a net from now on; its present value is its first change. Returns its number; -1: there
 * is no such net, or this build cannot watch. */
int mmcs_sim_watch(mmcs_sim *sim, const char *name);
/* The number of changes since the first watch. Valid until the next call that moves time. */
int64_t mmcs_sim_changes(const mmcs_sim *sim, const mmcs_change **changes);

/* /dev/mc0 as a process sees it. open: flags as open(2) (0 read-only, 1 write-only, 2 both);
 * returns a client number >= 0 or -errno. Simulated time passes during these calls. */
int mmcs_sim_open(mmcs_sim *sim, int flags);
int mmcs_sim_close(mmcs_sim *sim, int client);
int mmcs_sim_ioctl(mmcs_sim *sim, int client, uint32_t request, void *arg);
int mmcs_sim_read(mmcs_sim *sim, int client, void *buf, size_t len);
int mmcs_sim_write(mmcs_sim *sim, int client, const void *buf, size_t len);
/* Stops the machine on behalf of no client, as mc_halt() does. 0, or -errno. */
int mmcs_sim_stop(mmcs_sim *sim);
/* The callback is called every millisecond of simulated time while a request waits (MENABLE does);
 * if it returns other than 0 the request fails. It may call the functions of this header, except
 * requests that wait, snapshots and mmcs_sim_run(). No request waits longer than a simulated
 * second. */
typedef int (*mmcs_look)(void *ctx);
int mmcs_sim_set_look(mmcs_sim *sim, mmcs_look look, void *ctx);
/* SIGUSR1s delivered to this client since the last call. */
int mmcs_sim_signals(mmcs_sim *sim, int client);

/* One VME access by hand (offset 0..0x7FF in the window, am 0x29 or 0x2D, size 1, 2 or 4 bytes).
 * 0, or 1 bus time-out, 2 bus error. */
int mmcs_sim_bus_read(mmcs_sim *sim, uint32_t offset, int am, int size, uint32_t *value);
int mmcs_sim_bus_write(mmcs_sim *sim, uint32_t offset, int am, int size, uint32_t value);
/* A cycle of the VME bus, from the clock at which its address goes out to that of its answer. */
enum { MMCS_BUS_READ = 0, MMCS_BUS_WRITE = 1, MMCS_BUS_IACK = 2 };
typedef struct mmcs_bus_cycle {
  int64_t begin, end; /* clocks */
  uint32_t address, data;
  int32_t am, strobes; /* strobes: bit 0 DS0*, bit 1 DS1* */
  int32_t kind;        /* MMCS_BUS_... */
  int32_t answer;      /* 0 DTACK*, 1 none, 2 BERR* */
} mmcs_bus_cycle;
/* Those since the last call, valid until the next; the first call starts to record them. */
int64_t mmcs_sim_bus_cycles(mmcs_sim *sim, const mmcs_bus_cycle **cycles);

/* t0 of a segment counts from the call of mmcs_sim_start_motion(). numbers: those of TABLEs, which
 * are copied. */
int mmcs_sim_add_segment(mmcs_sim *sim, const mmcs_segment *segment, const double *numbers);
int mmcs_sim_start_motion(mmcs_sim *sim, int client);
/* Named inputs, then the upsets of registers: NULL past the last. Events are in simulated time
 * from t = 0. */
const char *mmcs_sim_input_name(int32_t input);
enum { MMCS_SCOPE_MACHINE = 0, MMCS_SCOPE_CARD = 1, MMCS_SCOPE_AXIS = 2 };
typedef struct mmcs_input {
  const char *name;
  int32_t scope;   /* what the index of an event counts: one of MMCS_SCOPE_... */
  int32_t lasting; /* 1: a state; 0: an act, which happens once */
  double low, high, healthy;
  const char *draw;    /* what a campaign draws: "each", "bit", a range, or "none" */
  const char *sort;    /* "pin", "line", "kill", "message", "register": the sort of fault */
  const char *meaning; /* of its values */
} mmcs_input;
/* The row of sim/abi/inputs.def: NULL past the last. */
const mmcs_input *mmcs_sim_input(int32_t input);
/* Value of an input at a past time: that of the last event up to then. Its healthy value if there
 * was none, and always for an act. */
double mmcs_sim_input_value(const mmcs_sim *sim, int32_t input, int32_t index, double t);
/* Every register of the hardware: its name from rtl/mmcs.sv down, or NULL; its bits; its value now.
 * The input "seu.<name>" flips bits of it. */
const char *mmcs_sim_register_name(int32_t reg);
int32_t mmcs_sim_register_width(int32_t reg);
uint64_t mmcs_sim_register(mmcs_sim *sim, int32_t reg);
int mmcs_sim_add_event(mmcs_sim *sim, const mmcs_event *event);

/* Runs until simulated time t (s); does nothing if t has passed. 0, or -1 when the model raised an
 * assertion (see the notes). */
int mmcs_sim_run(mmcs_sim *sim, double until_s);
/* Runs to a clock, but returns earlier after a SIGUSR1 and, with samples != 0, after a servo
 * sample. */
int mmcs_sim_run_to(mmcs_sim *sim, int64_t clock, int samples);
/* Servo samples since power-on. */
int64_t mmcs_sim_samples(const mmcs_sim *sim);
int32_t mmcs_sim_axes(const mmcs_sim *sim); /* motors connected */
double mmcs_sim_time(const mmcs_sim *sim);
int64_t mmcs_sim_clock(const mmcs_sim *sim);

/* The log: one row per servo sample since motion start: t_s, then per axis these. Valid until the
 * next call that moves time. Dropping the rows that have been copied keeps the memory of a long run
 * bounded; a snapshot then counts the dropped rows and does not hold them. */
#define MMCS_SIM_LOG_FIELDS "setpoint encoder velocity error current errcode angle_rad"
const double *mmcs_sim_log(const mmcs_sim *sim, int64_t *rows, int32_t *cols);
void mmcs_sim_log_taken(mmcs_sim *sim);
int mmcs_sim_notes(const mmcs_sim *sim, const mmcs_note **notes);
/* Notes are kept up to a limit; this many later ones were not kept. */
int64_t mmcs_sim_notes_lost(const mmcs_sim *sim);
void mmcs_sim_get_stats(const mmcs_sim *sim, mmcs_stats *stats);
/* What the physics did. -1: there is no such axis. */
typedef struct mmcs_truth {
  double angle, velocity; /* of the joint, rad and rad/s */
  double current;         /* A */
  int32_t count;          /* encoder transitions up minus down since t = 0 */
} mmcs_truth;
int mmcs_sim_true(const mmcs_sim *sim, int axis, mmcs_truth *truth);
/* Where a servo pass of a real processor spends its time, over those that wrote the D/As: "latency"
 * (SCLOCK to acknowledge), "pass" (SCLOCK to the end), and its parts. */
typedef struct mmcs_phase {
  char name[16];
  int64_t passes;
  double mean_us, max_us;
} mmcs_phase;
/* Fills up to n phases; returns how many there are, 0 where the driver is native code. */
int mmcs_sim_phases(const mmcs_sim *sim, mmcs_phase *phases, int n);
/* What the model's cache of one kind of part did since power-on: steps taken from it, steps that
 * the model computed, and what it holds now. Clocks in which the part rests count as neither. */
typedef struct mmcs_cache {
  char part[16]; /* its module, as in rtl/ */
  uint64_t hits, misses, states, bytes;
} mmcs_cache;
int mmcs_sim_caches(const mmcs_sim *sim, mmcs_cache *caches, int n); /* as mmcs_sim_phases() */
/* Digest of every sample so far and of the hardware state now. */
uint64_t mmcs_sim_hash(const mmcs_sim *sim);
int mmcs_sim_checkpoints(const mmcs_sim *sim, const mmcs_checkpoint **points);

/* The tap: every servo sample and every change, in two bounded rings. A reader keeps its own
 * position, counted from the first record of the simulation. The tap is no part of the machine's
 * state and does not influence it. The layout of a row is in docs/use/protocol.md. */
typedef struct mmcs_tap_event {
  int64_t n; /* its position */
  double t;
  char kind[16];
  int32_t axis; /* -1: none */
  int32_t value;
  char text[112];
} mmcs_tap_event;
typedef struct mmcs_tap_read {
  int64_t next; /* the position to continue from */
  int64_t lost; /* positions that the ring no longer held */
  int32_t count;
} mmcs_tap_read;
typedef struct mmcs_tap_head {
  int64_t rows, events; /* so far */
  int32_t row_bytes;
} mmcs_tap_head;
/* Sizes of the rings; 0 events switches the tap off. 0, or -1: impossible. */
int mmcs_sim_tap(mmcs_sim *sim, int64_t rows, int64_t events);
int mmcs_sim_tap_head(const mmcs_sim *sim, mmcs_tap_head *head);
/* Every n-th row from a position on, and every event; `limit` at most. 0, or -1. */
int mmcs_sim_tap_rows(const mmcs_sim *sim, int64_t from, int32_t every, uint8_t *rows,
                      int32_t limit, mmcs_tap_read *read);
int mmcs_sim_tap_events(const mmcs_sim *sim, int64_t from, mmcs_tap_event *events, int32_t limit,
                        mmcs_tap_read *read);
/* Adds an event of the caller. */
int mmcs_sim_tap_note(mmcs_sim *sim, const char *kind, int32_t axis, int32_t value,
                      const char *text);

/* Time travel. A snapshot holds everything but client processes; after a restore the future is the
 * same to the bit. With t < 0 it is of now; else it runs until t, for one of t or, if the firmware
 * is active at t, of the last instant at which it was not. Returns a number >= 0, or -1. Restoring
 * forgets the snapshots taken later. */
int64_t mmcs_sim_snapshot(mmcs_sim *sim, double t);
int mmcs_sim_restore(mmcs_sim *sim, int64_t id);
int mmcs_sim_drop(mmcs_sim *sim, int64_t id);
/* Takes a snapshot every so many seconds of mmcs_sim_run() and keeps the last `count`. */
int mmcs_sim_ring(mmcs_sim *sim, double every_s, int32_t count);
/* The snapshots that are kept, in order of time. Valid until the next call, as the bytes below. */
int mmcs_sim_snapshots(const mmcs_sim *sim, const mmcs_snapshot **list);
/* Starts to keep deeds: every call that acts on the machine (requests, bus cycles by hand, motions,
 * events), as far back as the oldest snapshot, 100,000 at most. */
void mmcs_sim_keep_deeds(mmcs_sim *sim);
/* The clock of the first snapshot since which every deed is kept; without one the present clock. */
int64_t mmcs_sim_known(const mmcs_sim *sim);
/* Gives `other`, a machine of the same configuration, the state of `sim`: copy the present one;
 * again that of a clock since mmcs_sim_known(), by repeating the deeds since the snapshot before it
 * (shortly after the clock if the driver was busy then). repeat runs `other` on to a clock and
 * repeats the deeds of `sim` later than the clock `after`. 0, or -1. */
int mmcs_sim_copy(mmcs_sim *other, mmcs_sim *sim);
int mmcs_sim_again(mmcs_sim *other, mmcs_sim *sim, int64_t clock);
int mmcs_sim_repeat(mmcs_sim *other, const mmcs_sim *sim, int64_t after, int64_t clock);
/* Digest of the whole state that decides the future, time included, without counts, logs and
 * hashes of the past. Two simulations of the same machine with equal digests continue equally. */
uint64_t mmcs_sim_future(mmcs_sim *sim);
/* For a file: the state, and the past (log, notes) that all snapshots of a run share. Number of
 * bytes, or -1. Another build or another machine refuses them: -1 and one sentence in err. */
int64_t mmcs_sim_snapshot_bytes(mmcs_sim *sim, int64_t id, const uint8_t **bytes);
int64_t mmcs_sim_history_bytes(mmcs_sim *sim, const uint8_t **bytes);
int mmcs_sim_restore_bytes(mmcs_sim *sim, const uint8_t *snapshot, size_t snapshot_len,
                           const uint8_t *history, size_t history_len, char *err, size_t err_len);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
