/* SPDX-License-Identifier: Apache-2.0 */
/* What sim/service decides for Python, page, FMU and bridges alike: how a driver is configured,
 * a scenario carried out, a machine served, a run recorded and a servo designed. As mmcs_sim.h, it
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
struct mmcs_checkpoint;
struct mc_param; /* of mcdef.h */

/* What a program does with /dev/mc0 for a scenario (§2.3.6). */
typedef struct mmcs_driver {
  int32_t axes, verbose, interval_us, double_buffer;
} mmcs_driver;
/* MMCS_SET_UP: number of axes, interval, D/A mode, counts 0. MMCS_SWITCH_ON: parameters of every
 * axis, MENABLE. Both: then the setpoints are written, 0. Returns 0, or -errno of the first request
 * that is refused; `refused` then names it ("MSETPARAM of axis 2"). */
enum { MMCS_SET_UP = 1, MMCS_SWITCH_ON = 2 };
int mmcs_sim_configure(struct mmcs_sim *sim, int client, int what, const mmcs_driver *driver,
                       const struct mc_param *params, char *refused, size_t refused_len);

/* A scenario's script: its events, [[call]]s and [[process]]es, each at a time (s of motion, of an
 * event at power-on s since then). */
typedef struct mmcs_script mmcs_script;
/* driver, params (of each of its axes): as configured at the begin. No driver: others open it. */
mmcs_script *mmcs_script_create(const mmcs_driver *driver, const struct mc_param *params);
void mmcs_script_destroy(mmcs_script *script);

typedef struct mmcs_timed_event {
  double at, until; /* until < 0: the value stays; else the input is healthy from then on */
  double value, healthy;
  int32_t input, index; /* as in mmcs_event */
  int32_t at_power_on;
} mmcs_timed_event;
void mmcs_script_event(mmcs_script *script, const mmcs_timed_event *event);

/* A request. axes: bit n is axis n, of MCALIB, MSETENC and MSETPARAM. Before MCALIB and MCLEARERROR
 * the states are read. */
typedef struct mmcs_call {
  double at;
  uint32_t request, axes;
  int32_t value;
} mmcs_call;
/* What a MSETPARAM changes of the parameters in force: the bits `mask` of a word of struct mc_param
 * (0: `which`, which stays). */
typedef struct mmcs_set {
  int32_t word, mask, value;
} mmcs_set;
void mmcs_script_call(mmcs_script *script, const mmcs_call *call, const mmcs_set *sets,
                      int32_t count);

/* MMCS_PROCESS_PD: a position loop in a user's process, every period_us; from `at` on to its goals.
 * MMCS_PROCESS_BOUNCE: writes its goals at `at`; after a SIGUSR1 an axis at its upper limit gets
 * minus the size of its goal, one at its lower limit plus. */
enum { MMCS_PROCESS_PD = 0, MMCS_PROCESS_BOUNCE = 1 };
typedef struct mmcs_process {
  double at, p, d, period_us;
  int32_t kind;
  uint32_t axes; /* bit n is axis n */
} mmcs_process;
/* goals: of every axis of the driver. late_us: how late a PD wakes up, by its turn; not late after
 * the last. */
void mmcs_script_process(mmcs_script *script, const mmcs_process *process, const double *goals,
                         const double *late_us, int32_t turns);

/* Schedules the events, opens the driver, configures it, starts the motion of the segments added
 * before. 0, or -errno, and `what` names the request. */
int mmcs_script_begin(mmcs_script *script, struct mmcs_sim *sim, char *what, size_t what_len);
double mmcs_script_start(const mmcs_script *script); /* s since power-on */
int mmcs_script_client(const mmcs_script *script);   /* the driver's number; -1: none */
/* Instead of mmcs_script_begin(), on a machine that is at a time of the motion: what was due before
 * `t`, or at it as well, has been done. */
void mmcs_script_resume(mmcs_script *script, int client, double start, double t, int at_it);
/* Runs to each call and process that is due before a time of the motion and carries it out; then
 * the machine is to be run to that time. 0; 1: an assertion failed; or -errno, and `what` names
 * it. */
int mmcs_script_act(mmcs_script *script, struct mmcs_sim *sim, double until, char *what,
                    size_t what_len);
/* A call now, for a person; its `at` is not used. 0, or the least -errno. */
int mmcs_script_ask(mmcs_script *script, struct mmcs_sim *sim, const mmcs_call *call,
                    const mmcs_set *sets, int32_t count);

/* What became of a call, for each axis, or once, and what MCALIB saw before. */
typedef struct mmcs_answer {
  uint32_t request;
  int32_t axis;           /* -1: of none */
  int32_t result;         /* 0 or more, or -errno */
  int32_t adcvai, encnow; /* of MCALIB */
} mmcs_answer;
int32_t mmcs_script_answers(const mmcs_script *script, const mmcs_answer **answers);
/* Of each process, in order. */
typedef struct mmcs_process_told {
  int32_t acts, turns;            /* how often it woke up, or turned round */
  double shortest_us, longest_us; /* between two acts; 0 before the second */
} mmcs_process_told;
int32_t mmcs_script_told(const mmcs_script *script, const mmcs_process_told **told);

/* A served machine: its clients, their lease and its dead-man, its pace, the stream, the way back
 * (docs/use/protocol.md). Clocks of the wall are the carrier's: `now` is in s of one of them. */
typedef struct mmcs_server {
  double speed; /* s of the machine per s; 0: as fast as it goes */
  int32_t paused;
  int32_t opens;      /* clients that have a device open */
  int32_t stopped_by; /* the process behind the last stop, or 0 */
  int64_t target; /* the clock up to which a client lets time pass, which is the carrier's to do;
                     then -1 */
} mmcs_server;
enum { MMCS_CLOSED = 0, MMCS_MC = 1, MMCS_VME = 2 };
typedef struct mmcs_client {
  double heard; /* when it was last heard: the carrier writes it */
  int32_t number, pid;
  int32_t device; /* what it has open: MMCS_... */
  int32_t driver; /* the driver's number of an open /dev/mc0, or -1 */
  int32_t flags;  /* as open(2) */
  int32_t writes; /* open for writing */
} mmcs_client;
mmcs_server *mmcs_server_create(struct mmcs_sim *sim);
void mmcs_server_destroy(mmcs_server *server);
/* kind: "device" or "message". Valid until it leaves: then what it had is closed, and its end is
 * that of its lease. */
mmcs_client *mmcs_server_enter(mmcs_server *server, const char *kind, const char *name, int pid);
void mmcs_server_leave(mmcs_server *server, mmcs_client *client);
/* 0, or -errno: of "/dev/mc0" or "/dev/vme16". opened: the driver's number if it has been, else -1.
 */
int mmcs_server_open(mmcs_server *server, mmcs_client *client, const char *device, int flags,
                     int opened);
/* "client 5 (mctool) has the lease", if that is another; else NULL. */
const char *mmcs_server_held(mmcs_server *server, const mmcs_client *client);
/* For a process, or 0. 0, or -errno. */
int mmcs_server_stop(mmcs_server *server, int pid);
/* Requests of a client that has /dev/mc0 open: as mmcs_sim_ioctl() and mmcs_sim_write(), and -EBUSY
 * while another has the lease; a stop is everybody's. A mapped access of one that has /dev/vme16,
 * at an A16 address: 0, 1 time-out, 2 bus error. */
int mmcs_server_ioctl(mmcs_server *server, mmcs_client *client, uint32_t request, void *argument);
int mmcs_server_write(mmcs_server *server, mmcs_client *client, const void *data, size_t size);
int mmcs_server_bus(mmcs_server *server, mmcs_client *client, uint64_t address, int size,
                    int writes, uint32_t *value);
/* All that had come at `now` has been heard. 1: the holder of the lease was silent for too long,
 * and the machine is stopped. */
int mmcs_server_check(mmcs_server *server, double now);
/* The next message that is due of what a client follows: its bytes, 0 if there is none; valid until
 * the next call. */
int64_t mmcs_server_stream(mmcs_server *server, mmcs_client *client, double now,
                           const uint8_t **message);
/* A request of the messages (sim/service/messages.def). asked: a line for each value, its keys with
 * a tab behind each, then what it is (n null, b, i, d, t text, o object and l list, whose values
 * follow, x deeper) and itself; without other control characters. only_check: of call, change and
 * input gives their arguments. held: NULL, or why setpoints may not be written. The reply is a JSON
 * object, valid until the next call: errno and text; what it gives; or, where the rest is the
 * carrier's, the arguments. */
const char *mmcs_server_request(mmcs_server *server, mmcs_client *client, double now,
                                const char *asked, int only_check, const char *held);

/* Digests of a log in run.mmcs, from its rows in order: a byte for so many rows each, and two bytes
 * for each column up to each mark (marks ascend). each 0: as the record of so many rows has them.
 */
typedef struct mmcs_digests mmcs_digests;
mmcs_digests *mmcs_digests_create(int32_t columns, int64_t rows, int64_t each, const int64_t *marks,
                                  int32_t count);
void mmcs_digests_destroy(mmcs_digests *digests);
void mmcs_digests_take(mmcs_digests *digests, const double *rows, int64_t count);
/* When all rows are taken, as a JSON object, valid until the digests are destroyed: the checkpoints
 * that a record keeps of these, rows_each, rows, marks, columns; bytes as base64. */
const char *mmcs_digests_told(mmcs_digests *digests, const struct mmcs_checkpoint *points,
                              int32_t count);
/* Rows as lines of log.csv; of no rows its first line. Valid until the next call. */
const char *mmcs_log_lines(int32_t columns, const double *rows, int64_t count);

/* Control design (§2.5). The answers are JSON objects, valid until the next call; error: one
 * sentence on what cannot be made. gains: P, I, D and tau of P + I/s + D s/(tau s + 1). D(z) is
 * num/den, in powers of 1/z, den[0] = 1. */
/* num and den, of a sample time and a method: "backward", "bilinear", "prewarp" (exact at a
 * frequency in rad/s), "matched", "ztransform" or "zoh". */
const char *mmcs_design_discrete(const double *gains, const char *method, double t, double prewarp);
/* a and b, what MSETPARAM takes; gain_error, warnings. scale: b[0], or NULL: a good power of two.
 */
const char *mmcs_design_integers(const double *num, int32_t nums, const double *den, int32_t dens,
                                 const int64_t *scale);
/* What pages ask: coefficients by name, warnings, gain_error; of nums 0 for the gains, backward. */
const char *mmcs_design_answer(const double *gains, double t, const double *num, int32_t nums,
                               const double *den, int32_t dens);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
