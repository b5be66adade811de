/* SPDX-License-Identifier: Apache-2.0 */
/* What sim/service decides for Python, page, FMU and bridges alike: how a driver is configured and
 * a scenario carried out. As mmcs_sim.h, it includes no other header of ours, and Python reads it.
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

/* A request of the messages (docs/use/protocol.md, sim/service/messages.def) of a client. */
typedef struct mmcs_asker {
  int32_t client;     /* the driver's number of what it has open, or -1 */
  int32_t writes;     /* open for writing */
  int32_t only_check; /* of call, change and input: 1 gives their arguments */
  const char *held;   /* NULL, or why it may change nothing: EBUSY */
} mmcs_asker;
/* asked: a line for each value, its keys with a tab behind each, then what it is (n null, b, i, d,
 * t text, o object and l list, whose values follow, x deeper) and itself; without other control
 * characters. The reply is a JSON object, valid until the next call: errno and text; what it gives;
 * or, where the rest is the carrier's, the arguments. */
const char *mmcs_sim_request(struct mmcs_sim *sim, const mmcs_asker *by, const char *asked);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
