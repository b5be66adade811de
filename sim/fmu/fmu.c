/* SPDX-License-Identifier: Apache-2.0 */
/* The machine as a co-simulation unit: driver, RTL and plant behind FMI 3.0. docs/use/bridges.md */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mmcs_service.h"
#include "mmcs_sim.h"
#include "fmi3.h"
#include "mcdef.h"

enum { MAX_AXES = 32, TOKEN = 64, TEXT = 400, READ_WRITE = 2 };

/* resources/setup.bin: this, then motors, links and struct mc_param of each axis
 * (mmcs/bridge/fmu.py writes it). The sizes are those of who wrote it. */
struct setup {
  char magic[8];
  char token[TOKEN];
  int32_t config_bytes, motor_bytes, link_bytes, param_bytes;
  mmcs_driver driver;
  mmcs_config config;
};

/* References: a group and an axis, or one of the lines. */
enum { TIME = 0, ESTOP_CLOSED = 1, ENABLED = 2, PANIC = 3, PER_AXIS = 100 };
enum { SETPOINT = 1, ENCODER, ANGLE, VELOCITY, CURRENT };

struct unit {
  void *environment;
  fmi3Log log;
  struct setup setup;
  mmcs_motor motors[MAX_AXES];
  mmcs_link links[MAX_AXES];
  struct mc_param params[MAX_AXES];
  mmcs_sim *sim;
  int client, estop_input;
  double begin, zero; /* the unit's time at the machine's time */
  double now;
  int32_t setpoint[MAX_AXES];
  bool estop_closed;
  struct mc_state state[MAX_AXES];
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

static bool read_setup(struct unit *u, const char *resources) {
  char path[4096];
  struct setup *s = &u->setup;
  snprintf(path, sizeof path, "%s/setup.bin", resources);
  FILE *file = fopen(path, "rb");
  if (file == NULL) return false;
  bool good = fread(s, sizeof *s, 1, file) == 1 && memcmp(s->magic, "mmcsfmu3", 8) == 0 &&
              s->config_bytes == sizeof(mmcs_config) && s->motor_bytes == sizeof(mmcs_motor) &&
              s->link_bytes == sizeof(mmcs_link) && s->param_bytes == sizeof(struct mc_param) &&
              s->config.axes >= 1 && s->driver.axes == s->config.axes &&
              s->config.axes <= MAX_AXES && s->config.links >= 0 &&
              s->config.links <= s->config.axes;
  size_t axes = good ? (size_t)s->config.axes : 0, links = good ? (size_t)s->config.links : 0;
  good = good && fread(u->motors, sizeof(mmcs_motor), axes, file) == axes &&
         fread(u->links, sizeof(mmcs_link), links, file) == links &&
         fread(u->params, sizeof(struct mc_param), axes, file) == axes;
  fclose(file);
  s->token[TOKEN - 1] = 0;
  s->config.abi = MMCS_SIM_ABI;  // the library is in this very unit
  s->config.processor = s->config.firmware = NULL;
  return good;
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
  u->estop_closed = true;
  const char *why = NULL;
  if (resources == NULL || !read_setup(u, resources))
    why = "is not there or of another build";
  else if (token == NULL || strcmp(token, u->setup.token) != 0)
    why = "the token of modelDescription.xml is another's";
  if (why == NULL) return u;
  refuse(u, "resources/setup.bin", why);
  free(u);
  return NULL;
}

static void forget_machine(struct unit *u) {
  if (u->sim != NULL) mmcs_sim_destroy(u->sim);
  u->sim = NULL;
}

void fmi3FreeInstance(fmi3Instance instance) {
  if (instance == NULL) return;
  forget_machine(instance);
  free(instance);
}

fmi3Status fmi3Reset(fmi3Instance instance) {
  struct unit *u = instance;
  forget_machine(u);
  memset(u->setpoint, 0, sizeof u->setpoint);
  memset(u->state, 0, sizeof u->state);
  u->estop_closed = true;
  u->now = 0;
  return fmi3OK;
}

static void look(struct unit *u) {
  size_t bytes = (size_t)u->setup.config.axes * sizeof(struct mc_state);
  (void)mmcs_sim_read(u->sim, u->client, u->state, bytes);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, bool has_tolerance, double tolerance,
                                       double start, bool has_stop, double stop) {
  (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
  struct unit *u = instance;
  char err[TEXT] = "";
  const char *name;
  forget_machine(u);
  u->sim = mmcs_sim_create(&u->setup.config, u->motors, u->links, err, sizeof err);
  if (u->sim == NULL) return refuse(u, "the machine cannot be made", err);
  u->client = mmcs_sim_open(u->sim, READ_WRITE);
  if (u->client < 0) return refuse(u, "open", "the driver refuses it");
  if (mmcs_sim_configure(u->sim, u->client, MMCS_SET_UP | MMCS_SWITCH_ON, &u->setup.driver,
                         u->params, err, sizeof err) < 0)
    return refuse(u, err, "the driver refuses it");
  u->estop_input = -1;
  for (int32_t n = 0; (name = mmcs_sim_input_name(n)) != NULL; n++)
    if (strcmp(name, "estop") == 0) u->estop_input = n;
  u->begin = u->now = start;
  u->zero = mmcs_sim_time(u->sim);
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
  return ref % PER_AXIS < (uint32_t)u->setup.config.axes;
}

/* NaN: there is none. */
static double number(const struct unit *u, fmi3ValueReference ref) {
  int axis = (int)(ref % PER_AXIS);
  if (ref == TIME) return u->now;
  if (ref < PER_AXIS || !has_axis(u, ref)) return NAN;
  switch (ref / PER_AXIS) {
    case SETPOINT:
      return u->setpoint[axis];
    case ENCODER:
      return u->state[axis].encnow;
    case ANGLE:
      return u->sim != NULL ? mmcs_sim_true_angle(u->sim, axis) : 0;
    case VELOCITY:
      return u->sim != NULL ? mmcs_sim_true_velocity(u->sim, axis) : 0;
    case CURRENT:
      return u->sim != NULL ? mmcs_sim_true_current(u->sim, axis) : 0;
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
    u->setpoint[refs[k] % PER_AXIS] = (int32_t)lround(values[k]);
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
    values[k] = refs[k] == ESTOP_CLOSED ? u->estop_closed
                : refs[k] == ENABLED    ? stats.enabled != 0
                                        : stats.panic_level != 0;
  }
  return fmi3OK;
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
                          const bool values[], size_t n_values) {
  for (size_t k = 0; k < n; k++) {
    if (k >= n_values || refs[k] != ESTOP_CLOSED)
      return refuse(instance, "fmi3SetBoolean", "there is no such input");
    ((struct unit *)instance)->estop_closed = values[k];
  }
  return fmi3OK;
}

/* --- time ---------------------------------------------------------------------------------- */

fmi3Status fmi3DoStep(fmi3Instance instance, double at, double step, bool no_set_state, bool *event,
                      bool *terminate, bool *early, double *reached) {
  (void)no_set_state;
  struct unit *u = instance;
  if (u->sim == NULL) return refuse(u, "fmi3DoStep", "comes before the initialization");
  if (!(step >= 0) || fabs(at - u->now) > 1e-9 + 1e-12 * fabs(at))
    return refuse(u, "fmi3DoStep", "a step goes on where the last one ended");
  mmcs_event button = {mmcs_sim_time(u->sim), u->estop_input, 0, !u->estop_closed};
  if (mmcs_sim_add_event(u->sim, &button) != 0) return refuse(u, "estop_closed", "is refused");
  /* Refused while the servo is off: output `enabled` says so. */
  (void)mmcs_sim_write(u->sim, u->client, u->setpoint,
                       sizeof u->setpoint[0] * (size_t)u->setup.config.axes);
  if (mmcs_sim_run(u->sim, u->zero + (at + step - u->begin)) != 0)
    return refuse(u, "fmi3DoStep", "an assertion of the machine has failed");
  u->now = at + step;
  look(u);
  *event = *terminate = *early = false;
  *reached = u->now;
  return fmi3OK;
}

/* --- what is refused ------------------------------------------------------------------------ */

#define REFUSED(name)                                        \
  FMI3 fmi3Status fmi3##name(fmi3Instance instance);         \
  fmi3Status fmi3##name(fmi3Instance instance) {             \
    return refuse(instance, "fmi3" #name, "is not offered"); \
  }
#define NEVER(name)                   \
  FMI3 fmi3Instance fmi3##name(void); \
  fmi3Instance fmi3##name(void) {     \
    return NULL;                      \
  }
FMI3_REFUSED(REFUSED)
FMI3_NEVER(NEVER)
