/* SPDX-License-Identifier: Apache-2.0 */
/* What Python, page, FMU and bridges have in common above the machine: the driver configured, a
 * scenario carried out, a machine served, a run recorded, a servo designed. Like mmcs_sim.h it
 * includes no other header of ours, and Python reads it.
 */
#ifndef MMCS_SERVICE_H
#define MMCS_SERVICE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

struct mmcs_sim;
struct mmcs_bus_cycle;
struct mc_param; /* of mcdef.h */

/* What a program does with /dev/mc0 for a scenario (§2.3.6). */
typedef struct mmcs_driver {
  int32_t axes, verbose, interval_us, double_buffer;
} mmcs_driver;
/* MMCS_SET_UP: number of axes, interval, D/A mode, counts 0. MMCS_SWITCH_ON: parameters of every
 * axis, MENABLE. With both, setpoints of 0 are written then. Returns 0, or -errno of the first
 * request that is refused; `refused` then names it ("MSETPARAM of axis 2"). */
enum { MMCS_SET_UP = 1, MMCS_SWITCH_ON = 2 };
int mmcs_sim_configure(struct mmcs_sim *sim, int client, int what, const mmcs_driver *driver,
                       const struct mc_param *params, char *refused, size_t refused_len);

/* A scenario's script: its motions, its events, [[call]]s and [[process]]es, each at a time (s
 * since the motion began; of an event with at_power_on s since power-on). mmcs_script_create_from()
 * makes one. */
typedef struct mmcs_script mmcs_script;
void mmcs_script_destroy(mmcs_script *script);

typedef struct mmcs_timed_event {
  double at, until; /* until < 0: the value stays; else the input is healthy from then on */
  double value;
  int32_t input, index; /* as in mmcs_event */
  int32_t at_power_on;
} mmcs_timed_event;
/* A request. axes: bit n is axis n, of MCALIB, MSETENC and MSETPARAM. Before MCALIB and MCLEARERROR
 * the states are read. */
typedef struct mmcs_call {
  double at;
  uint32_t request, axes;
  int32_t value;
  int32_t set_at, sets; /* of MSETPARAM: its changes among the script's */
} mmcs_call;
/* What an MSETPARAM changes of the present parameters: the bits `mask` of a word of struct mc_param
 * (word 0, `which`, cannot be changed). */
typedef struct mmcs_set {
  int32_t word, mask, value;
} mmcs_set;
/* MMCS_PROCESS_PD: a position loop in a user's process, every period_us, to its goals from `at` on.
 * MMCS_PROCESS_BOUNCE: writes its goals, which are speeds, at `at`; after a SIGUSR1 an axis at its
 * upper limit gets the negative speed, one at its lower limit the positive. */
enum { MMCS_PROCESS_PD = 0, MMCS_PROCESS_BOUNCE = 1 };
typedef struct mmcs_process {
  double at, p, d, period_us;
  int32_t kind;
  uint32_t axes; /* bit n is axis n */
  /* Among the script's numbers: goals of every axis of the driver; how late a PD runs in each of
   * its first `turns` periods, us (later ones are on time). */
  int32_t goals_at, late_at, turns;
} mmcs_process;

/* A request of the start that the scenario expects to be refused, by its name. */
typedef struct mmcs_refusal {
  char request[32];
} mmcs_refusal;

/* Schedules the events, opens the driver, configures it, starts the motion. 0; -errno, and `what`
 * names the request; or errno (> 0) when the scenario expects that refusal, which ends the run. */
int mmcs_script_begin(mmcs_script *script, struct mmcs_sim *sim, char *what, size_t what_len);
double mmcs_script_start(const mmcs_script *script);    /* s since power-on */
double mmcs_script_duration(const mmcs_script *script); /* of the motion, s */
int mmcs_script_axes(const mmcs_script *script);        /* of the driver; 0: programs open it */
int mmcs_script_client(const mmcs_script *script);      /* the driver's number; -1: none */
/* Instead of mmcs_script_begin(), on a machine at time `t` of the motion: all that was due before
 * `t`, with at_it also at `t`, has been done already. */
void mmcs_script_resume(mmcs_script *script, int client, double start, double t, int at_it);
/* Where a script is, beside a snapshot of its machine: the number of bytes, written unless NULL;
 * restore takes those of the same script. */
size_t mmcs_script_save(mmcs_script *script, uint8_t *bytes);
void mmcs_script_restore(mmcs_script *script, const uint8_t *bytes);
/* Runs to each call and process that is due before a time of the motion and carries it out; the
 * caller then runs the machine to that time. 0; 1: an assertion failed; or -errno, and `what` names
 * the request. */
int mmcs_script_act(mmcs_script *script, struct mmcs_sim *sim, double until, char *what,
                    size_t what_len);
/* Carries out a call now; its `at` is ignored. 0, or the least -errno. */
int mmcs_script_ask(mmcs_script *script, struct mmcs_sim *sim, const mmcs_call *call,
                    const mmcs_set *sets);

/* A set-up: a scenario checked and compiled (`mmcs compile`), from which every machine is made. A
 * build product for one build of the simulator, no format for exchange: that is the scenario.
 *
 * Little-endian: this head, then the records of each kind of sim/setup/records.def in its order,
 * each kind padded to 8 bytes. No pointers: one record names others by their place in their kind.
 */
#define MMCS_SETUP_KINDS 13
typedef struct mmcs_setup {
  char magic[8];   /* "mmcsset\n" */
  uint32_t bytes;  /* of all of it */
  uint32_t sum;    /* CRC-32 of what follows this field */
  char build[64];  /* mmcs_sim_build_id() of the build that it is for, and of no other */
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
  const mmcs_timed_event *events;
  const mmcs_call *calls; /* in order of time */
  const mmcs_set *sets;   /* of the calls */
  int32_t what;           /* MMCS_OVER_...: those that count */
  int32_t event_count, call_count, set_count;
  int32_t skip; /* of mmcs_config */
} mmcs_overrides;

/* The machine of a set-up in power-on state, and what is done with it; overrides may be NULL. The
 * data is not needed afterwards. NULL on error, with one sentence in err: the data is no set-up,
 * cut short, damaged, of another build, or the machine cannot be made. */
struct mmcs_sim *mmcs_sim_create_from(const void *data, size_t size,
                                      const mmcs_overrides *overrides, char *err, size_t err_len);
mmcs_script *mmcs_script_create_from(const void *data, size_t size, const mmcs_overrides *overrides,
                                     char *err, size_t err_len);
/* A file's bytes for both, to be freed by free(). NULL and one sentence if it cannot be read. */
void *mmcs_setup_load(const char *path, size_t *size, char *err, size_t err_len);

/* The result of a call, one for each of its axes (one in all without axes). */
typedef struct mmcs_answer {
  uint32_t request;
  int32_t axis;           /* -1: of none */
  int32_t result;         /* 0 or more, or -errno */
  int32_t adcvai, encnow; /* of MCALIB: the state read before it */
} mmcs_answer;
int32_t mmcs_script_answers(const mmcs_script *script, const mmcs_answer **answers);
/* What each process did, in order. */
typedef struct mmcs_process_told {
  int32_t acts, turns;            /* how often it ran; how often it reversed */
  double shortest_us, longest_us; /* between two acts; 0 before the second */
} mmcs_process_told;
int32_t mmcs_script_told(const mmcs_script *script, const mmcs_process_told **told);

/* A served machine: its clients, their lease and its dead-man, its pace, the stream, rewind
 * (docs/use/protocol.md). The carrier (server.py, the page) owns sockets and real time: `now` is a
 * clock of the carrier, s. */
typedef struct mmcs_server {
  double speed; /* s of the machine per s; 0: as fast as it goes */
  int32_t paused;
  int32_t opens;      /* clients that have a device open */
  int32_t stopped_by; /* the process behind the last stop, or 0 */
  int64_t target; /* clock to which a client asked to advance: the carrier runs to it and sets -1 */
} mmcs_server;
enum { MMCS_CLOSED = 0, MMCS_MC = 1, MMCS_VME = 2 };
typedef struct mmcs_client {
  double heard; /* `now` of its last message: the carrier writes it */
  int32_t number, pid;
  int32_t device; /* what it has open: MMCS_... */
  int32_t driver; /* the driver's number of an open /dev/mc0, or -1 */
  int32_t flags;  /* as open(2) */
  int32_t writes; /* open for writing */
} mmcs_client;
mmcs_server *mmcs_server_create(struct mmcs_sim *sim);
void mmcs_server_destroy(mmcs_server *server);
/* kind: "device" or "message". Valid until mmcs_server_leave(), which closes its device and ends
 * its lease. */
mmcs_client *mmcs_server_enter(mmcs_server *server, const char *kind, const char *name, int pid);
void mmcs_server_leave(mmcs_server *server, mmcs_client *client);
/* Opens "/dev/mc0" or "/dev/vme16": 0, or -errno. opened: the driver's number if the carrier has
 * opened /dev/mc0 already, else -1. */
int mmcs_server_open(mmcs_server *server, mmcs_client *client, const char *device, int flags,
                     int opened);
/* "client 5 (mctool) has the lease", if another client has it; else NULL. */
const char *mmcs_server_held(mmcs_server *server, const mmcs_client *client);
/* Stops the machine on behalf of a process, or 0. 0, or -errno. */
int mmcs_server_stop(mmcs_server *server, int pid);
/* ioctl, write: of a client that has /dev/mc0 open, as mmcs_sim_ioctl() and mmcs_sim_write();
 * -EBUSY while another client has the lease, but MSTOP is always allowed. bus: a mapped access of a
 * client that has /dev/vme16 open, at an A16 address: 0, 1 time-out, 2 bus error. */
int mmcs_server_ioctl(mmcs_server *server, mmcs_client *client, uint32_t request, void *argument);
int mmcs_server_write(mmcs_server *server, mmcs_client *client, const void *data, size_t size);
int mmcs_server_bus(mmcs_server *server, mmcs_client *client, uint64_t address, int size,
                    int writes, uint32_t *value);
/* What the driver has said from an event of the tap on; valid until the next call. */
const char *mmcs_server_said(const mmcs_server *server, int64_t event);
/* To be called when all messages received until `now` are handled. 1: the holder of the lease was
 * silent for longer than its dead-man, and the machine has been stopped. */
int mmcs_server_check(mmcs_server *server, double now);
/* The next message that is due in a client's stream: its length, 0 if there is none; valid until
 * the next call. */
int64_t mmcs_server_stream(mmcs_server *server, mmcs_client *client, double now,
                           const uint8_t **message);
/* Carries out a message (sim/service/messages.def). asked: its JSON flattened, a line for each
 * value: its keys, each followed by a tab, then its type (n null, b bool, i integer, d double, t
 * text, o object, l list, x too deep) and the value; members of objects and lists follow in lines
 * of their own; no other control characters. only_check: call, change and input are checked and
 * their arguments given, but not carried out. held: NULL, or why setpoints may not be written. The
 * reply is a JSON object, valid until the next call: errno and text; or the result; or, for what
 * the carrier does, the arguments. */
const char *mmcs_server_request(mmcs_server *server, mmcs_client *client, double now,
                                const char *asked, int only_check, const char *held);

/* Rows as lines of log.csv; with count 0 its heading. Valid until the next call. */
const char *mmcs_log_lines(int32_t columns, const double *rows, int64_t count);
/* The same for cycles of the bus and bus.csv. */
const char *mmcs_bus_lines(const struct mmcs_bus_cycle *cycles, int64_t count);

/* Control design (§2.5). The results are JSON objects, valid until the next call; on failure their
 * `error` is one sentence. gains: P, I, D and tau of P + I/s + D s/(tau s + 1). D(z) is num/den, in
 * powers of 1/z, den[0] = 1. */
/* num and den, of a sample time and a method: "backward", "bilinear", "prewarp" (exact at a
 * frequency in rad/s), "matched", "ztransform" or "zoh". */
const char *mmcs_design_discrete(const double *gains, const char *method, double t, double prewarp);
/* a and b, as MSETPARAM takes them; gain_error, warnings. scale: b[0], or NULL for a suitable power
 * of two. */
const char *mmcs_design_integers(const double *num, int32_t nums, const double *den, int32_t dens,
                                 const int64_t *scale);
/* The same for pages, backward from the gains: coefficients by name, warnings, gain_error. */
const char *mmcs_design_answer(const double *gains, double t);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
