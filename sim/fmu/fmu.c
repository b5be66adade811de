/* SPDX-License-Identifier: Apache-2.0 */
/* The machine as a co-simulation unit: driver, RTL and plant behind FMI 3.0. docs/use/bridges.md */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3.h"
#include "mcdef.h"
#include "mmcs_service.h"
#include "mmcs_sim.h"

enum { MAX_AXES = 32, TEXT = 400 };

/* References: a group and an axis, or one of the lines. */
enum { TIME = 0, ESTOP_CLOSED = 1, ENABLED = 2, PANIC = 3, HASH = 4, PER_AXIS = 100 };
enum { SETPOINT = 1, ENCODER, ANGLE, VELOCITY, CURRENT };

/* What changes beside machine and script. */
struct moment {
  double begin, zero; /* the unit's time at the machine's time */
  double now;
  int32_t client;
  int32_t commanded; /* setpoints have come from outside */
  int32_t estop_closed;
  int32_t setpoint[MAX_AXES];
  struct mc_state state[MAX_AXES];
};

struct unit {
  void *environment;
  fmi3Log log;
  void *setup; /* resources/setup.bin, of mmcs_service.h */
  size_t setup_size;
  int axes, estop_input;
  mmcs_sim *sim;
  mmcs_script *script; /* what the scenario does, if the unit was made with its motions */
  struct moment at;
};

static fmi3Status refuse(struct unit *u, const char *what, const char *why) {
  char text[TEXT];
  snprintf(text, sizeof text, "mmcs: %s: %s", what, why);
  if (u != NULL && u->log != NULL) u->log(u->environment, fmi3Error, "logStatusError", text);
  return fmi3Error;
}

const char *fmi3GetVersion(void) {
  return "3.0";
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, bool on, size_t n,
                               const fmi3String categories[]) {
  (void)instance, (void)on, (void)n, (void)categories;
  return fmi3OK;
}

/* --- making and unmaking ------------------------------------------------------------------- */

/* The token of a set-up: its sum and its build (mmcs/bridge/fmu.py). */
static bool is_of(const void *setup, const char *token) {
  const mmcs_setup *head = setup;
  char own[TEXT];
  snprintf(own, sizeof own, "%08x %s", head->sum, head->build);
  return token != NULL && strcmp(token, own) == 0;
}

static bool read_setup(struct unit *u, const char *resources, const char *token, char *why) {
  char path[4096];
  snprintf(path, sizeof path, "%s/setup.bin", resources != NULL ? resources : "");
  u->setup = mmcs_setup_load(path, &u->setup_size, why, TEXT);
  if (u->setup == NULL) return false;
  mmcs_script *script = mmcs_script_create_from(u->setup, u->setup_size, NULL, why, TEXT);
  if (script == NULL) return false;
  u->axes = mmcs_script_axes(script);
  mmcs_script_destroy(script);
  if (!is_of(u->setup, token))
    snprintf(why, TEXT, "the token of modelDescription.xml is another's");
  return is_of(u->setup, token);
}

static void forget_machine(struct unit *u) {
  mmcs_script_destroy(u->script);
  mmcs_sim_destroy(u->sim);
  u->script = NULL;
  u->sim = NULL;
}

void fmi3FreeInstance(fmi3Instance instance) {
  if (instance == NULL) return;
  struct unit *u = instance;
  forget_machine(u);
  free(u->setup);
  free(u);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         bool visible, bool logging, bool event_mode,
                                         bool early_return, const fmi3ValueReference intermediate[],
                                         size_t n, void *environment, fmi3Log log, void *update) {
  (void)name, (void)visible, (void)logging, (void)event_mode, (void)early_return;
  (void)intermediate, (void)n, (void)update;
  struct unit *u = calloc(1, sizeof *u);
  if (u == NULL) return NULL;
  u->environment = environment;
  u->log = log;
  u->at.estop_closed = true;
  char why[TEXT] = "";
  if (read_setup(u, resources, token, why)) return u;
  refuse(u, "resources/setup.bin", why);
  fmi3FreeInstance(u);
  return NULL;
}

fmi3Status fmi3Reset(fmi3Instance instance) {
  struct unit *u = instance;
  forget_machine(u);
  u->at = (struct moment){.estop_closed = true};
  return fmi3OK;
}

static bool make_machine(struct unit *u) {
  char err[TEXT] = "";
  u->sim = mmcs_sim_create_from(u->setup, u->setup_size, NULL, err, sizeof err);
  if (u->sim != NULL)
    u->script = mmcs_script_create_from(u->setup, u->setup_size, NULL, err, sizeof err);
  const char *name;
  for (int32_t n = 0; (name = mmcs_sim_input_name(n)) != NULL; n++)
    if (strcmp(name, "estop") == 0) u->estop_input = n;
  if (u->script == NULL) refuse(u, "the machine cannot be made", err);
  return u->script != NULL;
}

static void look(struct unit *u) {
  size_t bytes = (size_t)u->axes * sizeof(struct mc_state);
  (void)mmcs_sim_read(u->sim, u->at.client, u->at.state, bytes);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, bool has_tolerance, double tolerance,
                                       double start, bool has_stop, double stop) {
  (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
  struct unit *u = instance;
  char err[TEXT] = "";
  forget_machine(u);
  if (!make_machine(u)) return fmi3Error;
  if (mmcs_script_begin(u->script, u->sim, err, sizeof err) != 0)
    return refuse(u, err, "the driver refuses it");
  u->at.client = mmcs_script_client(u->script);
  u->at.begin = u->at.now = start;
  u->at.zero = mmcs_script_start(u->script);
  look(u);
  return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
  (void)instance;
  return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
  (void)instance;
  return fmi3OK;
}

/* --- variables ----------------------------------------------------------------------------- */

static bool has_axis(const struct unit *u, fmi3ValueReference ref) {
  return ref % PER_AXIS < (uint32_t)u->axes;
}

/* NaN: there is none. */
static double number(const struct unit *u, fmi3ValueReference ref) {
  int axis = (int)(ref % PER_AXIS);
  mmcs_truth truth = {0};
  if (ref == TIME) return u->at.now;
  if (ref < PER_AXIS || !has_axis(u, ref)) return NAN;
  mmcs_sim_true(u->sim, axis, &truth);
  switch (ref / PER_AXIS) {
    case SETPOINT:
      return u->at.setpoint[axis];
    case ENCODER:
      return u->at.state[axis].encnow;
    case ANGLE:
      return truth.angle;
    case VELOCITY:
      return truth.velocity;
    case CURRENT:
      return truth.current;
    default:
      return NAN;
  }
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
                          double values[], size_t n_values) {
  for (size_t k = 0; k < n; k++) {
    double value = k < n_values ? number(instance, refs[k]) : NAN;
    if (isnan(value)) return refuse(instance, "fmi3GetFloat64", "there is no such variable");
    values[k] = value;
  }
  return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
                          const double values[], size_t n_values) {
  struct unit *u = instance;
  for (size_t k = 0; k < n; k++) {
    if (k >= n_values || refs[k] / PER_AXIS != SETPOINT || !has_axis(u, refs[k]))
      return refuse(u, "fmi3SetFloat64", "there is no such input");
    if (!(fabs(values[k]) < (double)INT32_MAX))
      return refuse(u, "setpoint", "must be a number of counts, less than 2^31");
    u->at.setpoint[refs[k] % PER_AXIS] = (int32_t)lround(values[k]);
    u->at.commanded = true;
  }
  return fmi3OK;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
                          bool values[], size_t n_values) {
  struct unit *u = instance;
  mmcs_stats stats = {0};
  if (u->sim != NULL) mmcs_sim_get_stats(u->sim, &stats);
  for (size_t k = 0; k < n; k++) {
    if (k >= n_values || refs[k] < ESTOP_CLOSED || refs[k] > PANIC)
      return refuse(u, "fmi3GetBoolean", "there is no such variable");
    values[k] = refs[k] == ESTOP_CLOSED ? u->at.estop_closed
                : refs[k] == ENABLED    ? stats.enabled != 0
                                        : stats.panic_level != 0;
  }
  return fmi3OK;
}

/* Of all samples and registers: that of `mmcs run`, if the unit has done the same. */
fmi3Status fmi3GetUInt64(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
                         uint64_t values[], size_t n_values) {
  struct unit *u = instance;
  for (size_t k = 0; k < n; k++) {
    if (k >= n_values || refs[k] != HASH)
      return refuse(u, "fmi3GetUInt64", "there is no such variable");
    values[k] = mmcs_sim_hash(u->sim);
  }
  return fmi3OK;
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
                          const bool values[], size_t n_values) {
  for (size_t k = 0; k < n; k++) {
    if (k >= n_values || refs[k] != ESTOP_CLOSED)
      return refuse(instance, "fmi3SetBoolean", "there is no such input");
    ((struct unit *)instance)->at.estop_closed = values[k];
  }
  return fmi3OK;
}

/* --- time ---------------------------------------------------------------------------------- */

fmi3Status fmi3DoStep(fmi3Instance instance, double at, double step, bool no_set_state, bool *event,
                      bool *terminate, bool *early, double *reached) {
  (void)no_set_state;
  struct unit *u = instance;
  if (u->sim == NULL) return refuse(u, "fmi3DoStep", "comes before the initialization");
  if (!(step >= 0) || fabs(at - u->at.now) > 1e-9 + 1e-12 * fabs(at))
    return refuse(u, "fmi3DoStep", "a step goes on where the last one ended");
  mmcs_event button = {mmcs_sim_time(u->sim), u->estop_input, 0, !u->at.estop_closed};
  if (mmcs_sim_add_event(u->sim, &button) != 0) return refuse(u, "estop_closed", "is refused");
  /* Refused while the servo is off: output `enabled` says so. */
  if (u->at.commanded)
    (void)mmcs_sim_write(u->sim, u->at.client, u->at.setpoint,
                         sizeof u->at.setpoint[0] * (size_t)u->axes);
  const double until = at + step - u->at.begin;
  char what[TEXT];
  const int result = mmcs_script_act(u->script, u->sim, until, what, sizeof what);
  if (result < 0) return refuse(u, what, "the driver refuses it");
  if (result > 0 || mmcs_sim_run(u->sim, u->at.zero + until) != 0)
    return refuse(u, "fmi3DoStep", "an assertion of the machine has failed");
  u->at.now = at + step;
  look(u);
  *event = *terminate = *early = false;
  *reached = u->at.now;
  return fmi3OK;
}

/* --- its state ----------------------------------------------------------------------------- */

/* Behind it the bytes of script, snapshot and history; without a machine their lengths are 0. */
struct state {
  struct moment at;
  uint64_t setup; /* sum of the set-up file */
  uint64_t script, snapshot, history;
  uint8_t bytes[];
};

static size_t size_of(const struct state *s) {
  return sizeof *s + s->script + s->snapshot + s->history;
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
  struct unit *u = instance;
  const uint8_t *snapshot = NULL, *history = NULL;
  struct state head = {.at = u->at, .setup = ((const mmcs_setup *)u->setup)->sum};
  if (u->sim != NULL) {
    const int64_t id = mmcs_sim_snapshot(u->sim, -1);
    if (id < 0) return refuse(u, "fmi3GetFMUState", "an assertion of the machine has failed");
    head.script = mmcs_script_save(u->script, NULL);
    head.snapshot = (uint64_t)mmcs_sim_snapshot_bytes(u->sim, id, &snapshot);
    head.history = (uint64_t)mmcs_sim_history_bytes(u->sim, &history);
    (void)mmcs_sim_drop(u->sim, id);
  }
  struct state *made = *state = realloc(*state, size_of(&head));
  if (made == NULL) return fmi3Fatal;
  *made = head;
  if (u->sim == NULL) return fmi3OK;
  (void)mmcs_script_save(u->script, made->bytes);
  memcpy(made->bytes + head.script, snapshot, head.snapshot);
  memcpy(made->bytes + head.script + head.snapshot, history, head.history);
  return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
  struct unit *u = instance;
  const struct state *s = state;
  char err[TEXT] = "";
  if (s->setup != ((const mmcs_setup *)u->setup)->sum)
    return refuse(u, "fmi3SetFMUState", "the state of another unit");
  if (s->snapshot == 0) {
    forget_machine(u);
  } else {
    if (u->sim == NULL && !make_machine(u)) return fmi3Error;
    const uint8_t *snapshot = s->bytes + s->script, *history = snapshot + s->snapshot;
    if (mmcs_sim_restore_bytes(u->sim, snapshot, s->snapshot, history, s->history, err,
                               sizeof err) != 0)
      return refuse(u, "fmi3SetFMUState", err);
    mmcs_script_restore(u->script, s->bytes);
  }
  u->at = s->at;
  return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
  (void)instance;
  free(*state);
  *state = NULL;
  return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
  (void)instance;
  *size = size_of(state);
  return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, uint8_t bytes[],
                                 size_t size) {
  if (size < size_of(state)) return refuse(instance, "fmi3SerializeFMUState", "too few bytes");
  memcpy(bytes, state, size_of(state));
  return fmi3OK;
}

/* What the machine's own bytes hold is checked when the state is set. */
fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const uint8_t bytes[], size_t size,
                                   fmi3FMUState *state) {
  struct state head = {0};
  if (size >= sizeof head) memcpy(&head, bytes, sizeof head);
  if (size < sizeof head || size_of(&head) != size ||
      (head.script | head.snapshot | head.history) > size)
    return refuse(instance, "fmi3DeserializeFMUState", "not a state of this unit, or cut short");
  *state = realloc(*state, size);
  if (*state != NULL) memcpy(*state, bytes, size);
  return *state != NULL ? fmi3OK : fmi3Fatal;
}

/* --- what is refused ------------------------------------------------------------------------ */

#define REFUSED(name)                                        \
  fmi3Status fmi3##name(fmi3Instance instance) {             \
    return refuse(instance, "fmi3" #name, "is not offered"); \
  }
#define NEVER(name)               \
  fmi3Instance fmi3##name(void) { \
    return NULL;                  \
  }
FMI3_REFUSED(REFUSED)
FMI3_NEVER(NEVER)
