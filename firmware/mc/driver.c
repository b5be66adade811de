/* SPDX-License-Identifier: Apache-2.0 */
/* Open, close, read, write: see mc.h, §2.3. */
#include "mc_priv.h"

_Static_assert(sizeof(struct mc) <= MC_WORDS * sizeof(uint64_t), "MC_WORDS in mc.h is too small");

size_t mc_size(void) {
  return sizeof(struct mc);
}

static int is_client(const struct mc *mc, int client) {
  return client >= 0 && client < MC_MAX_CLIENTS && mc->client[client].used;
}

int mc_attach(struct mc *mc, const struct mc_bus *bus, const struct mc_os *os,
              const struct mc_config *config) {
  if (mc == NULL || bus == NULL || os == NULL || config == NULL) return -MC_EINVAL;
  uint32_t hz = config->sysclk_hz;
  if (hz != 8000000 && hz != 4000000 && hz != 2000000 && hz != 1000000) return -MC_EINVAL;
  mc->bus = *bus;
  mc->os = *os;
  mc->config = *config;
  mc->opens = mc->cards = mc->axes = mc->joints = 0;
  mc->power = MC_IDLE;
  mc->grace = 0;
  mc->stopped = MC_FREE;
  for (int i = 0; i < MC_MAX_CLIENTS; i++) mc->client[i].used = 0;
  return 0;
}

/* The first open, and the first one for writing: finds the cards, sets the defaults, starts SCLOCK
 * and its interrupts. If it fails, whoever only reads goes on. */
static int start(struct mc *mc) {
  unsigned level = mc->os.mask(mc->os.ctx);
  uint8_t before = mc->opens > 0 ? mc->pccsr : MMCS_PCCSR_BASE_CARDS;
  int result = 0;
  mc->fault = 0;
  mc->pccsr = MMCS_PCCSR_BASE_CARDS;
  hw_put(mc, MMCS_PCCSR, mc->pccsr);
  if (mc->fault || (hw_get(mc, MMCS_PCCSR) & MMCS_PCCSR_BASE_bm) != MMCS_PCCSR_BASE_CARDS) {
    result = -MC_ENXIO;
    if (mc->opens > 0) {
      mc->pccsr = before;
      hw_put(mc, MMCS_PCCSR, before);
    }
  } else {
    hw_put(mc, MMCS_VECTOR, mc->config.vector);
    mc->stopped = mc->shut = MC_FREE;
    mc->cause = MCAUSE_NONE;
    mc->cause_of = mc->silent = mc->told = 0;
    mc->adc_timeouts = 0;
    mc->crowded = 0;
    mc->stats = (struct mc_stats){0};
    mc_scan(mc);
    result = timer_counts(mc, MC_INTERVAL_US, &mc->n0, &mc->n1);
    timer_start(mc);
    /* heartbeats that the last close ended may still be running out */
    if (mc->grace > 0) mc->grace = timer_grace(mc);
  }
  mc->os.unmask(mc->os.ctx, level);
  return result;
}

static int has_writer(const struct mc *mc) {
  for (int i = 0; i < MC_MAX_CLIENTS; i++) {
    if (mc->client[i].used && mc->client[i].can_write) return 1;
  }
  return 0;
}

int mc_open(struct mc *mc, int flags) {
  int client = 0;
  if (flags < MC_O_RDONLY || flags > MC_O_RDWR) return -MC_EINVAL;
  while (client < MC_MAX_CLIENTS && mc->client[client].used) client++;
  if (client == MC_MAX_CLIENTS) return -MC_ENFILE;
  if (mc->opens == 0 || (flags != MC_O_RDONLY && !has_writer(mc))) {
    int result = start(mc);
    if (result != 0) return result;
  }
  unsigned level = mc->os.mask(mc->os.ctx);
  mc->client[client] = (struct mc_client){0};
  mc->client[client].can_read = flags != MC_O_WRONLY;
  mc->client[client].can_write = flags != MC_O_RDONLY;
  mc->client[client].used = 1;
  mc->opens++;
  mc->os.unmask(mc->os.ctx, level);
  return client;
}

int mc_close(struct mc *mc, int client) {
  if (!is_client(mc, client)) return -MC_EBADF;
  unsigned level = mc->os.mask(mc->os.ctx);
  mc->client[client].used = 0;
  mc->opens--;
  if (mc->client[client].can_write && !has_writer(mc)) {
    power_rest(mc);
    mc->diag = mc->double_buffer = mc->buffered = 0;
    hw_apply_modes(mc);
  }
  if (mc->opens == 0) {
    hw_set_pccsr(mc, 0, (uint8_t)~MMCS_PCCSR_BASE_bm);
    if (mc->adc_timeouts > 0) text_log(mc, "close, A/D time-outs:", mc->adc_timeouts, "");
  }
  mc->os.unmask(mc->os.ctx, level);
  return 0;
}

int mc_read(struct mc *mc, int client, void *user_buf, size_t len) {
  struct mc_state copy[MC_MAX_AXES];
  if (!is_client(mc, client) || !mc->client[client].can_read) return -MC_EBADF;
  if (len < sizeof(struct mc_state)) return -MC_EINVAL;
  int n = mc->joints;
  if (len / sizeof(struct mc_state) < (size_t)n) n = (int)(len / sizeof(struct mc_state));
  unsigned level = mc->os.mask(mc->os.ctx);
  if (mc->stats.total == 0) sample_first(mc);
  size_t bytes = (size_t)n * sizeof(struct mc_state);
  uint8_t had_read = mc->client[client].has_read;
  error_show(mc, client, n, copy);
  mc->os.unmask(mc->os.ctx, level);
  if (n == 0 || mc->os.copy_out(mc->os.ctx, user_buf, copy, bytes) == 0) return (int)bytes;
  level = mc->os.mask(mc->os.ctx);
  error_unseen(mc, client, n, copy);
  mc->client[client].has_read = had_read;
  mc->os.unmask(mc->os.ctx, level);
  return -MC_EFAULT;
}

int mc_write(struct mc *mc, int client, const void *user_buf, size_t len) {
  int32_t values[MC_MAX_AXES];
  if (!is_client(mc, client) || !mc->client[client].can_write) return -MC_EBADF;
  if (len % sizeof values[0] != 0 || len / sizeof values[0] > (size_t)mc->joints) {
    return -MC_EINVAL;
  }
  int n = (int)(len / sizeof values[0]);
  if (n == 0) return 0;
  if (mc->os.copy_in(mc->os.ctx, values, user_buf, len) != 0) return -MC_EFAULT;
  unsigned level = mc->os.mask(mc->os.ctx);
  int result = axis_demand(mc, 0, n, values);
  mc->os.unmask(mc->os.ctx, level);
  return result < 0 ? result : (int)len;
}

int mc_halt(struct mc *mc) {
  if (mc->opens == 0) return 0;
  unsigned level = mc->os.mask(mc->os.ctx);
  mc->fault = 0;
  power_rest(mc);
  mc->stopped = MC_LATCHED;
  int result = mc->fault ? -MC_EIO : 0;
  mc->os.unmask(mc->os.ctx, level);
  return result;
}

int mc_joints(const struct mc *mc) {
  return mc->joints;
}

int32_t mc_setpoint(const struct mc *mc, int axis) {
  return mc->axis[axis].setpoint;
}

int32_t mc_demand(const struct mc *mc, int axis) {
  const struct mc_axis *x = &mc->axis[axis];
  return (x->par.mode & ADDMD) != 0 ? x->state.adcvai : x->setpoint;
}

int mc_current(const struct mc *mc, int axis) {
  return mc->axis[axis].code - MC_DAC_ZERO;
}

const struct mc_param *mc_param_of(const struct mc *mc, int axis) {
  return &mc->axis[axis].par;
}

int mc_is_enabled(const struct mc *mc) {
  return mc->power == MC_RUNNING;
}

int mc_is_stopped(const struct mc *mc) {
  return mc->stopped != MC_FREE;
}

int mc_cause(const struct mc *mc, int *number) {
  *number = mc->cause_of - 1;
  return mc->cause;
}

uint32_t mc_interval(const struct mc *mc) {
  return mc->interval_us;
}

int mc_diag(const struct mc *mc) {
  return mc->diag;
}

int mc_double_buffer(const struct mc *mc) {
  return mc->double_buffer;
}

const struct mc_state *mc_state_of(const struct mc *mc, int axis) {
  return &mc->axis[axis].state;
}

const struct mc_stats *mc_stats_of(const struct mc *mc) {
  return &mc->stats;
}
