/* SPDX-License-Identifier: Apache-2.0 */
/* The requests of Table 2.3 and of <sys/mmcs.h>. A rejected one changes nothing; each is atomic to
 * a sample. */
#include "mc_priv.h"

struct argument {
  int client; /* whose request it is */
  union {
    int32_t value;
    uint32_t word;
    struct mc_param param;
    struct mc_stats stats;
    struct mmcs_setpoint setpoint;
  };
};

struct request {
  uint32_t code;
  int (*serve)(struct mc *mc, struct argument *arg);
  uint8_t changes; /* needs the device open for writing */
  uint8_t waits;   /* takes its time: masks the level by itself */
};

#define SIZE_OF(code) ((code) >> 16 & 0x1FFFu)

_Static_assert(SIZE_OF(MGETPARAM) == sizeof(struct mc_param), "mcdef.h: length MC_PARAM");
_Static_assert(SIZE_OF(MGETSTATS) == sizeof(struct mc_stats), "mcdef.h: MC_STATS");
_Static_assert(SIZE_OF(MSETENC) == sizeof(int), "mcdef.h: MC_INT");
_Static_assert(SIZE_OF(MSETPOINT) == sizeof(struct mmcs_setpoint), "sys/mmcs.h: MSETPOINT");
_Static_assert(sizeof(struct mc_state) == 28, "read() counts in states of 28 bytes");

static int has_axis(const struct mc *mc, int32_t axis) {
  return axis >= 0 && axis < mc->joints;
}

/* "Lower 8 bits specify axis" of MSETENC, MSETLED, MSETDAC. */
static int axis_of(const struct argument *arg) {
  return (int)(arg->word & 0xFF);
}

static int get_num_cards(struct mc *mc, struct argument *arg) {
  arg->value = mc->cards;
  return 0;
}

static int set_num_joints(struct mc *mc, struct argument *arg) {
  if (arg->value < 0 || arg->value > mc->axes) return -MC_EINVAL;
  int low = arg->value < mc->joints ? arg->value : mc->joints;
  int high = arg->value < mc->joints ? mc->joints : arg->value;
  for (int axis = low; axis < high; axis++) {
    struct mc_axis *x = &mc->axis[axis];
    servo_reset(&x->servo);
    x->code = MC_DAC_ZERO;
    if (mc->power != MC_IDLE) axis_forget_demand(x);
    x->wait = 0;
  }
  mc->joints = arg->value;
  return 0;
}

static int is_too_slow(const struct mc_param *par, uint32_t interval_us) {
  return par->clkdivisor > 1 && (uint64_t)par->clkdivisor * interval_us > MC_SERVO_US;
}

static int get_param(struct mc *mc, struct argument *arg) {
  if (!has_axis(mc, arg->param.which)) return -MC_EINVAL;
  arg->param = mc->axis[arg->param.which].par;
  return 0;
}

/* 1: the demand would mean something else. Torque is fed nothing back. */
static int changes_meaning(const struct mc_param *from, const struct mc_param *to) {
  int changed = from->mode ^ to->mode;
  if ((changed & (MD_MASK | ADDMD)) != 0) return 1;
  return (changed & (ADFB | ZEROFB)) != 0 && (to->mode & MD_MASK) != MD_TORQ;
}

/* What no servo could make sense of. A servo slower than the heartbeats that it keeps alive would
 * be dead while they live. */
static int is_nonsense(const struct mc *mc, const struct mc_param *par) {
  return par->b0 == 0 || par->clkdivisor < 1 || is_too_slow(par, mc->interval_us) ||
         par->ilim < 0 || par->ilimax < 0 || par->ipole < 0 || par->ipole >= MC_FSCALE;
}

/* Bumpless: an axis that under power enters position mode, or gets another feedback, stays where it
 * is; in other modes it gets the setpoint 0; until a process writes again. */
static int set_param(struct mc *mc, struct argument *arg) {
  const struct mc_param *to = &arg->param;
  if (!has_axis(mc, to->which)) return -MC_EINVAL;
  if (is_nonsense(mc, to)) return -MC_EINVAL;
  if (calib_disturbs(to) && axis_calibrates(mc, to->which / 2)) {
    text_log(mc, "parameters: axis", to->which, " needs its A/D, which stands still: calibration");
    return -MC_EBUSY;
  }
  if ((mc->diag & M_ENDIAG) != 0 && mc->power != MC_IDLE && axis_needs_encoder(to)) {
    text_log(mc, "parameters: axis", to->which, " needs its encoder, which M_ENDIAG cuts off");
    return -MC_EBUSY;
  }
  struct mc_axis *x = &mc->axis[to->which];
  servo_change(&x->servo, &x->par, to);
  servo_prepare(&x->law, to);
  if (((to->mode ^ x->par.mode) & MD_MASK) != 0) x->code = MC_DAC_ZERO;
  if (mc->power != MC_IDLE && changes_meaning(&x->par, to)) axis_forget_demand(x);
  if (x->wait >= to->clkdivisor) x->wait = to->clkdivisor - 1;
  x->par = *to;
  return 0;
}

/* What a curious user hears of the normal course, Table 2.3 MSETVERBOSITY. */
static void say(struct mc *mc, const char *what, int number) {
  if ((mc->verbosity & M_VERBOSE) != 0) text_log(mc, what, number, "");
}

static int stop(struct mc *mc, struct argument *arg) {
  (void)arg;
  power_rest(mc);
  mc->stopped = MC_LATCHED;
  say(mc, "stopped", -1);
  return 0;
}

static int enable(struct mc *mc, struct argument *arg) {
  (void)arg;
  int result = power_enable(mc);
  if (result == 0) say(mc, "enabled, axes:", mc->axes);
  return result;
}

static int set_verbosity(struct mc *mc, struct argument *arg) {
  mc->verbosity = arg->value;
  say(mc, "cards:", mc->cards);
  return 0;
}

static int get_verbosity(struct mc *mc, struct argument *arg) {
  arg->value = mc->verbosity;
  return 0;
}

static int clear_error(struct mc *mc, struct argument *arg) {
  error_clear(mc, arg->client);
  return 0;
}

static int set_interval(struct mc *mc, struct argument *arg) {
  uint32_t n0 = 0, n1 = 0;
  if (timer_counts(mc, arg->word, &n0, &n1) != 0) return -MC_EINVAL;
  for (int axis = 0; axis < mc->axes; axis++) {
    if (!is_too_slow(&mc->axis[axis].par, arg->word)) continue;
    text_log(mc, "interval: axis", axis, " would be servoed less than every 50 ms: clkdivisor");
    return -MC_EINVAL;
  }
  mc->n0 = n0;
  mc->n1 = n1;
  timer_start(mc);
  if (mc->grace > 0) mc->grace = timer_grace(mc);
  return 0;
}

static int get_interval(struct mc *mc, struct argument *arg) {
  arg->word = mc->interval_us;
  return 0;
}

/* Another number for the place where the axis is: no movement, no error, no jump. */
static void renumber(const struct mc *mc, struct mc_axis *x, int64_t by) {
  int mode = x->par.mode;
  if ((mode & ADFB) != 0) return;
  servo_shift(&x->servo, by);
  if (mc->power != MC_IDLE && (mode & MD_MASK) == MD_POS && (mode & ZEROFB) == 0) {
    x->setpoint = servo_shifted(x->setpoint, by);
  }
}

/* The pair is read twice: the first read may be what SCLOCK latched before. */
static int set_encoder(struct mc *mc, struct argument *arg) {
  int axis = axis_of(arg);
  uint16_t value = (uint16_t)(arg->word >> 8);
  if (!has_axis(mc, axis)) return -MC_EINVAL;
  struct mc_axis *x = &mc->axis[axis];
  unsigned msb = (axis & 1) != 0 ? MMCS_CARD_ENC2_MSB : MMCS_CARD_ENC1_MSB;
  (void)hw_counter(mc, axis);
  int32_t before = servo_extend(x->position, x->counter, hw_counter(mc, axis));
  (void)hw_card_get(mc, axis / 2, MMCS_CARD_PPI_C); /* the pair begins with the next byte */
  hw_card_put(mc, axis / 2, msb, (uint8_t)(value >> 8));
  hw_card_put(mc, axis / 2, msb + 1, (uint8_t)(value & 0xFF));
  (void)hw_counter(mc, axis);
  x->counter = hw_counter(mc, axis);
  x->position = (int16_t)value + (int16_t)(uint16_t)(x->counter - value);
  x->lost = 0;
  renumber(mc, x, (int64_t)(int16_t)value - before);
  return 0;
}

/* Each axis has one of the two lights of its card: bit 8. Further bits have no light here. */
static int set_led(struct mc *mc, struct argument *arg) {
  int axis = axis_of(arg);
  if (!has_axis(mc, axis)) return -MC_EINVAL;
  struct mc_card *card = &mc->card[axis / 2];
  unsigned light = (axis & 1) != 0 ? MMCS_CARD_PPI_A_LED2_bm : MMCS_CARD_PPI_A_LED1_bm;
  unsigned a = card->a & ~light;
  if ((arg->word & 0x100) != 0) a |= light;
  card->a = (uint8_t)a;
  hw_card_put(mc, axis / 2, MMCS_CARD_PPI_A, card->a);
  return 0;
}

static int diag_mode(struct mc *mc, struct argument *arg) {
  if ((arg->value & ~(M_ANDIAG | M_ENDIAG)) != 0) return -MC_EINVAL;
  int blind = (arg->value & M_ENDIAG) != 0 && mc->power != MC_IDLE ? axis_needing_encoder(mc) : -1;
  if (blind >= 0) {
    text_log(mc, "diag mode: axis", blind, " needs its encoder, which M_ENDIAG cuts off");
    return -MC_EBUSY;
  }
  unsigned level = mc->os.mask(mc->os.ctx);
  int relay = (mc->diag ^ arg->value) & M_ANDIAG;
  mc->diag = (uint8_t)arg->value;
  hw_apply_modes(mc);
  mc->os.unmask(mc->os.ctx, level);
  if (relay && mc->drive) mc->os.delay_us(mc->os.ctx, MC_RELAY_US);
  return 0;
}

static int set_dac(struct mc *mc, struct argument *arg) {
  int axis = axis_of(arg);
  if (!has_axis(mc, axis) || !axis_is_off(&mc->axis[axis].par)) return -MC_EINVAL;
  if (mc->power != MC_RUNNING) return -MC_EIO;
  mc->axis[axis].code = (uint16_t)(arg->word >> 8 & 0xFFF);
  return 0;
}

static int dac_mode(struct mc *mc, struct argument *arg) {
  mc->double_buffer = arg->value != 0;
  mc->buffered = mc->double_buffer;
  hw_apply_modes(mc);
  return 0;
}

static int get_stats(struct mc *mc, struct argument *arg) {
  arg->stats = mc->stats;
  return 0;
}

static int zero_stats(struct mc *mc, struct argument *arg) {
  (void)arg;
  mc->stats = (struct mc_stats){0};
  return 0;
}

static int calibrate(struct mc *mc, struct argument *arg) {
  if (!has_axis(mc, arg->value)) return -MC_EINVAL;
  for (int axis = arg->value & ~1; axis <= (arg->value | 1); axis++) {
    if (!calib_disturbs(&mc->axis[axis].par)) continue;
    text_log(mc, "calibrate: axis", axis, " of that card needs its A/D, which would stand still");
    return -MC_EBUSY;
  }
  calib_start(mc, arg->value);
  return 0;
}

static int calibrate_end(struct mc *mc, struct argument *arg) {
  if (!has_axis(mc, arg->value)) return -MC_EINVAL;
  calib_end(mc, arg->value);
  return 0;
}

static int set_setpoint(struct mc *mc, struct argument *arg) {
  if (!has_axis(mc, arg->setpoint.axis)) return -MC_EINVAL;
  int32_t value = arg->setpoint.value;
  return axis_demand(mc, arg->setpoint.axis, 1, &value);
}

static const struct request requests[] = {
#define REQUEST(name, number, argument, way, serve, changes, waits, ...) \
  {name, serve, changes, waits},
#include "requests.def"
};

static const struct request *find(uint32_t code) {
  for (unsigned i = 0; i < sizeof requests / sizeof requests[0]; i++) {
    if (requests[i].code == code) return &requests[i];
  }
  return NULL;
}

static int serve(struct mc *mc, const struct request *r, struct argument *arg) {
  if (r->waits) return r->serve(mc, arg);
  unsigned level = mc->os.mask(mc->os.ctx);
  mc->fault = 0;
  int result = r->serve(mc, arg);
  if (mc->fault && result == 0) result = -MC_EIO; /* the adaptor no longer answers */
  mc->os.unmask(mc->os.ctx, level);
  return result;
}

int mc_ioctl(struct mc *mc, int client, uint32_t request, void *arg) {
  const struct request *r = find(request);
  struct argument argument = {.client = client};
  if (client < 0 || client >= MC_MAX_CLIENTS || !mc->client[client].used) return -MC_EBADF;
  if (r == NULL) return -MC_ENOTTY;
  if (r->changes && !mc->client[client].can_write) return -MC_EBADF;
  if ((request & MC_ARG_IN) != 0 &&
      mc->os.copy_in(mc->os.ctx, &argument.value, arg, SIZE_OF(request)) != 0) {
    return -MC_EFAULT;
  }
  int result = serve(mc, r, &argument);
  if (result == 0 && (request & MC_ARG_OUT) != 0 &&
      mc->os.copy_out(mc->os.ctx, arg, &argument.value, SIZE_OF(request)) != 0) {
    return -MC_EFAULT;
  }
  return result;
}
