/* SPDX-License-Identifier: Apache-2.0 */
/* Length: one model of every call of the manual. */
/* Random calls of the driver, of which a model of the manual says what each must answer. §2.3
 *
 * `driver_tests NAME N SEED` makes N other ones, `driver_tests NAME N SEED 3,17` of these those
 * alone, and prints them: test_firmware.py looks for the fewest that fail. */
#include "traffic.h"

#define CLIENTS 4
#define AXES 4
#define RUN 5000 /* calls of one machine */

static uint64_t state;
static long calls, seed;
static long number_of_call, next_kept;
static const char *kept; /* the numbers of those that are made, or NULL: all */

static long decimal(const char **text) {
  long value = 0;
  for (; **text >= '0' && **text <= '9'; ++*text) value = 10 * value + **text - '0';
  return value;
}

static void begin(long usual) {
  const char *count = test_argc > 3 ? test_argv[2] : "0",
             *from = test_argc > 3 ? test_argv[3] : "1";
  calls = test_argc > 3 ? decimal(&count) : usual;
  seed = decimal(&from);
  kept = test_argc > 4 ? test_argv[4] : NULL;
  number_of_call = next_kept = -1;
}

static int is_kept(void) {
  while (number_of_call > next_kept && *kept != 0) {
    next_kept = decimal(&kept);
    kept += *kept != 0;
  }
  return number_of_call == next_kept;
}

static uint32_t chance(uint32_t below) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (uint32_t)(state >> 33) % below;
}

/* To the next call. Its chances are its own, so that others may be left out. */
static int more(void) {
  do number_of_call++;
  while (kept != NULL && number_of_call < calls && !is_kept());
  state = ((uint64_t)number_of_call << 32 | (uint32_t)seed) * 0x9E3779B97F4A7C15u;
  state = (state ^ state >> 29) * 0xBF58476D1CE4E5B9u; /* neighbours have nothing in common */
  state ^= state >> 32;
  return number_of_call < calls;
}

/* 1: the next call is the first of another machine. */
static int machine_ends(const struct mc *mc) {
  static long run;
  long was = mc != NULL ? run : -1;
  run = number_of_call / RUN;
  return run != was;
}

static void show(const char *call, int client, long argument, long other) {
  if (kept == NULL) return;
  printf("%ld: %s, client %d, 0x%lx 0x%lx\n", number_of_call, call, client, argument, other);
}

/* Small numbers, corners and any others. */
static int32_t number(void) {
  static const int32_t corners[] = {0,         1,         -1,   2,    1023,  1024, 2047, 4095,
                                    INT32_MAX, INT32_MIN, 2000, 1000, 30000, -256, 255,  65536};
  uint32_t kind = chance(4);
  if (kind == 0) return corners[chance(16)];
  if (kind == 1) return (int32_t)chance(64) - 8;
  return (int32_t)(kind == 2 ? chance(1u << 16) : chance(1u << 31) * 2u + chance(2));
}

static const uint32_t requests[] = {
#define REQUEST(name, ...) name,
#include "requests.def"
};

union argument {
  int32_t words[18];
  struct mc_param param;
  struct mc_stats stats;
  struct mmcs_setpoint setpoint;
};

/* Some that the driver takes among those of any numbers. */
static uint32_t random_request(union argument *arg) {
  static const uint32_t often[] = {MCLEARERROR, MSETPARAM, MENABLE, MSETNUMJOINTS, MSTOP};
  uint32_t request =
      chance(2) != 0 ? often[chance(COUNT(often))] : requests[chance(COUNT(requests))];
  for (int i = 0; i < 18; i++) arg->words[i] = number();
  if (request == MSETPARAM) {
    arg->param = (struct mc_param)MC_PARAM_INITIAL;
    arg->param.which = (int)chance(AXES);
    arg->param.mode = (int)chance(0x800);
    for (uint32_t others = chance(4); others > 0; others--) arg->words[chance(18)] = number();
  } else if (chance(2) != 0) {
    arg->words[0] = request == MSETINTERVAL
                        ? 200 + (int32_t)chance(3000)
                        : (int32_t)(chance(5) | chance(4096) << 8 | chance(2) << 4);
  }
  return request;
}

static const struct mc_param table_2_1 = {.a0 = 1,
                                          .b0 = 1,
                                          .clkdivisor = 1,
                                          .ilim = 1024,
                                          .adc_a = 1,
                                          .plo = INT32_MIN,
                                          .phi = INT32_MAX};

/* Whatever the call: what is worked out of the parameters in force is up to date. */
static void judge_law(const struct mc *mc) {
  for (int axis = 0; axis < mc->axes; axis++) {
    const struct servo_prepared *got = &mc->axis[axis].law;
    struct servo_prepared want;
    servo_prepare(&want, &mc->axis[axis].par);
    CHECK(got->kind == want.kind && got->phi == want.phi && got->shift == want.shift);
    CHECK(got->top == want.top && got->limit == want.limit);
  }
}

/* --- any calls, right and wrong ones, of hardware that fails ---------------------------------- */

static void disturb(void) {
  struct mock_card *c = &m.card[chance(2)];
  uint32_t what = chance(10);
  if (what == 0) m.estop_open = chance(4) == 0;
  if (what == 1) c->present = chance(8) != 0;
  if (what == 2) m.adaptor_dead = chance(8) == 0;
  if (what == 3) c->index[chance(2)] = 1;
  if (what == 4) c->adc[chance(2)] = (uint16_t)chance(4096);
  if (what == 5) m.latency_us = (int64_t)chance(200);
  if (what == 6 && chance(4) == 0) c->a = c->b = 0;
  if (what == 7) m.dac_errors = (int)chance(5);
  if (what > 7) c->count[chance(2)] = (uint16_t)(c->count[0] + chance(2000));
}

static int any_call(struct mc *mc) {
  static int32_t buffer[MC_MAX_AXES * 7 + 8];
  int client = (int)chance(5) - (chance(100) == 0 ? 2 : 0);
  size_t len = chance(3) != 0 ? 4 * chance(6) : chance(sizeof buffer);
  void *memory = chance(100) == 0 ? NULL : buffer;
  uint32_t what = chance(32);
  static const char *const names[] = {"open", "close", "halt", "run", "disturb"};
  show(what < 5    ? names[what]
       : what < 9  ? "write"
       : what < 13 ? "read"
                   : "ioctl",
       client, (long)len, memory != NULL);
  if (what == 0) return mc_open(mc, (int)chance(4));
  if (what == 1) return chance(3) == 0 ? mc_close(mc, client) : 0;
  if (what == 2) return chance(20) == 0 ? mc_halt(mc) : 0;
  if (what == 3) mock_run(&m, (int64_t)chance(400));
  if (what == 4) disturb();
  if (what < 5) return 0;
  for (int i = 0; i < 8; i++) buffer[i] = number();
  if (what < 9) return mc_write(mc, client, memory, len);
  if (what < 13) {
    int got = mc_read(mc, client, memory, len);
    for (int i = 0; i < got / 4; i++) mock_tell((uint32_t)buffer[i]);
    return got;
  }
  union argument arg;
  uint32_t request = random_request(&arg);
  if (request == MENABLE && chance(50) != 0) return 0; /* it waits for milliseconds */
  if (request == MDIAGMODE && chance(8) != 0) return 0;
  if (chance(100) == 0) request ^= 1u << chance(32);
  show("request", client, (long)request, arg.words[0]);
  int result = mc_ioctl(mc, client, request, memory != NULL ? (void *)&arg : NULL);
  for (int i = 0; i < 18; i++) mock_tell((uint32_t)arg.words[i]);
  return result;
}

/* Whatever was before: the next program finds a machine that works. */
static void orderly(struct mc *mc) {
  m.estop_open = m.adaptor_dead = m.dac_errors = 0;
  m.latency_us = 0;
  for (int i = 0; i < 2; i++) m.card[i].present = 1;
  for (int i = 0; i < MC_MAX_CLIENTS; i++) (void)mc_close(mc, i);
  mock_run(&m, 70000);
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
  CHECK_EQ(enable(mc), 0);
  DEMAND(mc, 0, 0, 0, 0);
  mock_run(&m, 10000);
  CHECK(mc_is_enabled(mc) && !mock_panic(&m));
  CHECK_EQ(mc_close(mc, 0), 0);
}

TEST(test_random_calls, "DRV-3 DRV-4") {
  static const int errors[] = {MC_EIO,   MC_ENXIO,  MC_EBADF,  MC_EFAULT,
                               MC_EBUSY, MC_EINVAL, MC_ENFILE, MC_ENOTTY};
  begin(60000);
  struct mc *mc = NULL;
  while (more()) {
    if (machine_ends(mc)) {
      if (mc != NULL) orderly(mc);
      mc = mock_start(&m, number_of_call / RUN % 2 != 0 ? MC_MAX_CARDS : 2);
    }
    int result = any_call(mc), known = result >= 0;
    for (unsigned i = 0; i < COUNT(errors); i++) known |= result == -errors[i];
    CHECK(known);
    CHECK(!m.masked);
    judge_law(mc);
    mock_tell((uint32_t)result);
  }
  if (mc != NULL) orderly(mc);
}

/* --- the model -------------------------------------------------------------------------------- */

/* A machine in order, axes at rest at count 0, and what its programs have asked for so far. Errors
 * are moments: `raised` of each flag, `looked` of the last read of any axis, `saw` of the axis. */
static struct {
  struct {
    int used, reads, writes, has_read, signals;
    long looked, saw[AXES], again[AXES][8];
    unsigned missed[AXES]; /* shown by reads that failed: shown once more, and not cleared */
  } client[CLIENTS];
  struct mc_param param[AXES];
  int32_t setpoint[AXES];
  int joints, interval, verbosity, diag, double_buffer, stopped, enabled;
  unsigned pending[AXES];
  long raised[AXES][8], now;
  uint16_t index[AXES];
} s;

static int users(int who_write) {
  int n = 0;
  for (int i = 0; i < CLIENTS; i++) n += s.client[i].used && s.client[i].writes >= who_write;
  return n;
}

static void model_stop(void) {
  memset(s.setpoint, 0, sizeof s.setpoint);
  for (int axis = 0; axis < AXES; axis++) s.param[axis].mode &= ~MD_MASK;
  s.enabled = 0;
}

static int model_open(int flags) {
  int i = 0;
  if (flags < MC_O_RDONLY || flags > MC_O_RDWR) return -MC_EINVAL;
  while (s.client[i].used) i++;
  if (users(0) == 0 || (flags != MC_O_RDONLY && users(1) == 0)) {
    for (int axis = 0; axis < AXES; axis++) {
      s.param[axis] = table_2_1;
      s.param[axis].which = axis;
      s.pending[axis] = 0;
    }
    memset(s.setpoint, 0, sizeof s.setpoint);
    s.joints = AXES;
    s.interval = 2000;
    s.verbosity = s.diag = s.double_buffer = s.stopped = 0;
  }
  memset(&s.client[i], 0, sizeof s.client[i]);
  s.client[i].used = 1;
  s.client[i].reads = flags != MC_O_WRONLY;
  s.client[i].writes = flags != MC_O_RDONLY;
  for (int axis = 0; axis < AXES; axis++) s.client[i].saw[axis] = s.now;
  return i;
}

static int model_close(int i) {
  if (i < 0 || i >= CLIENTS || !s.client[i].used) return -MC_EBADF;
  s.client[i].used = 0;
  if (s.client[i].writes && users(1) == 0) {
    model_stop();
    s.diag = s.double_buffer = 0;
  }
  return 0;
}

static int may(int i, int writes) {
  return i >= 0 && i < CLIENTS && s.client[i].used &&
         (writes ? s.client[i].writes : s.client[i].reads);
}

static int model_set(int axis, int n, const int32_t *values) {
  if (s.stopped) return -MC_EIO;
  memcpy(&s.setpoint[axis], values, (size_t)n * sizeof *values);
  return 0;
}

static int model_write(int i, const int32_t *values, size_t len, int good) {
  if (!may(i, 1)) return -MC_EBADF;
  if (len % 4 != 0 || len / 4 > (size_t)s.joints) return -MC_EINVAL;
  if (len == 0) return 0;
  if (!good) return -MC_EFAULT;
  int result = model_set(0, (int)len / 4, values);
  return result < 0 ? result : (int)len;
}

static int is_off(const struct mc_param *p) {
  return (p->mode & MD_MASK) < MD_POS || (p->mode & MD_MASK) > MD_TEST1;
}

static int is_blind(const struct mc_param *p) { /* with M_ENDIAG */
  int mode = p->mode & MD_MASK;
  return (mode == MD_POS || mode == MD_VEL) && (p->mode & ZEROFB) == 0;
}

static int some_blind(void) {
  for (int axis = 0; axis < s.joints; axis++) {
    if (is_blind(&s.param[axis])) return 1;
  }
  return 0;
}

static int too_slow(int divisor, int64_t us) {
  return divisor > 1 && divisor * us > 50000;
}

static int model_param(const struct mc_param *p) {
  if (p->which < 0 || p->which >= s.joints || p->b0 == 0 || p->clkdivisor < 1 || p->ilim < 0 ||
      p->ilimax < 0 || p->ipole < 0 || p->ipole >= MC_FSCALE ||
      too_slow(p->clkdivisor, s.interval)) {
    return -MC_EINVAL;
  }
  struct mc_param *own = &s.param[p->which];
  int changed = own->mode ^ p->mode;
  if (s.enabled && (s.diag & M_ENDIAG) != 0 && is_blind(p)) return -MC_EBUSY;
  if (s.enabled && ((changed & (MD_MASK | ADDMD)) != 0 ||
                    ((changed & ZEROFB) != 0 && (p->mode & MD_MASK) != MD_TORQ))) {
    s.setpoint[p->which] = 0; /* axes are at 0 */
  }
  *own = *p;
  return 0;
}

static void model_clear(int i) {
  int remains = 0;
  for (int axis = 0; axis < AXES; axis++) {
    long until = s.client[i].has_read ? s.client[i].looked : s.now;
    for (unsigned bit = 0; bit < 8; bit++) {
      long at = s.raised[axis][bit];
      if (at <= until) s.pending[axis] &= ~(1u << bit);
      if ((s.pending[axis] >> bit & 1) == 0) continue;
      remains |= s.client[i].again[axis][bit] <= at || s.client[i].again[axis][bit] <= until;
      s.client[i].again[axis][bit] = s.now;
    }
    if (s.client[i].saw[axis] < until) s.client[i].saw[axis] = until;
    if (until >= 0) s.client[i].missed[axis] = 0;
  }
  for (int k = 0; k < CLIENTS; k++) {
    if (remains && s.client[k].used && s.client[k].writes) s.client[k].signals++;
  }
}

static int model_ioctl(int i, uint32_t request, union argument *arg, int good) {
  int32_t value = arg->words[0], axis = value & 0xFF;
  if (i < 0 || i >= CLIENTS || !s.client[i].used) return -MC_EBADF;
  if ((request & MC_ARG_OUT) == 0 && !s.client[i].writes) return -MC_EBADF; /* it may look only */
  if (!good && (request & MC_ARG_IN) != 0) return -MC_EFAULT;
  if (request == MSETVERBOSITY) s.verbosity = value;
  if (request == MDACMODE) s.double_buffer = value != 0;
  if (request == MGETNUMCARDS) arg->words[0] = AXES / 2;
  if (request == MGETVERBOSITY) arg->words[0] = s.verbosity;
  if (request == MGETINTERVAL) arg->words[0] = s.interval;
  switch (request) {
    case MSETNUMJOINTS:
      if (value < 0 || value > AXES) return -MC_EINVAL;
      for (int n = 0; n < AXES && s.enabled; n++) {
        if ((n < value) != (n < s.joints)) s.setpoint[n] = 0;
      }
      s.joints = value;
      return 0;
    case MGETPARAM:
      if (arg->param.which < 0 || arg->param.which >= s.joints) return -MC_EINVAL;
      arg->param = s.param[arg->param.which];
      break;
    case MSETPARAM:
      return model_param(&arg->param);
    case MSTOP:
      model_stop();
      s.stopped = 1;
      return 0;
    case MENABLE:
      if ((s.diag & M_ENDIAG) != 0 && some_blind()) return -MC_EBUSY;
      memset(s.setpoint, 0, sizeof s.setpoint); /* axes hold 0, where they are */
      s.stopped = 0;
      s.enabled = 1;
      return 0;
    case MCLEARERROR:
      model_clear(i);
      return 0;
    case MSETINTERVAL:
      if (value < 100 || value > 536870911) return -MC_EINVAL;
      for (int n = 0; n < AXES; n++) {
        if (too_slow(s.param[n].clkdivisor, value)) return -MC_EINVAL;
      }
      s.interval = value;
      return 0;
    case MDIAGMODE:
      if ((value & ~(M_ANDIAG | M_ENDIAG)) != 0) return -MC_EINVAL;
      if ((value & M_ENDIAG) != 0 && s.enabled && some_blind()) return -MC_EBUSY;
      s.diag = value;
      return 0;
    case MSETLED:
      return axis < s.joints ? 0 : -MC_EINVAL;
    case MCALIBEND:
      return value >= 0 && value < s.joints ? 0 : -MC_EINVAL; /* none is under way */
    case MSETDAC:
      if (axis >= s.joints || !is_off(&s.param[axis])) return -MC_EINVAL;
      return s.enabled ? 0 : -MC_EIO;
    case MSETPOINT:
      if (value < 0 || value >= s.joints) return -MC_EINVAL;
      int32_t one = arg->setpoint.value;
      return model_set(value, 1, &one);
    default:
      break;
  }
  return !good && (request & MC_ARG_OUT) != 0 ? -MC_EFAULT : 0;
}

/* What a program's read of an axis shows: what is pending, and what came since it last saw it. */
static unsigned flags_shown(int i, int axis) {
  unsigned flags = s.pending[axis] | s.client[i].missed[axis];
  for (unsigned bit = 0; bit < 8; bit++) {
    if (s.raised[axis][bit] > s.client[i].saw[axis]) flags |= 1u << bit;
  }
  return flags;
}

static int shown(int i, int axis) {
  unsigned flags = flags_shown(i, axis);
  uint32_t code = flags != 0 ? (uint32_t)axis << 8 | flags : 0;
  if ((flags & MERR_ZINDEX) != 0) code |= (uint32_t)s.index[axis] << 16;
  return (int)code;
}

static void judge_read(struct mc *mc, int i, size_t len) {
  struct mc_state got[AXES + 1];
  int n = len / 28 < (size_t)s.joints ? (int)(len / 28) : s.joints;
  m.bad_pointer = chance(8) == 0; /* then nothing is seen */
  int want = !may(i, 0) ? -MC_EBADF : len < 28 ? -MC_EINVAL : 28 * n;
  if (want > 0 && m.bad_pointer) want = -MC_EFAULT;
  CHECK_EQ(mc_read(mc, i, got, len), want);
  if (want == -MC_EFAULT) {
    for (int axis = 0; axis < n; axis++) s.client[i].missed[axis] = flags_shown(i, axis);
    memset(s.client[i].again, 0, sizeof s.client[i].again);
    s.client[i].looked = -1;
  }
  if (want < 0) return;
  for (int axis = 0; axis < n; axis++) {
    CHECK_EQ(got[axis].errcode, shown(i, axis));
    CHECK_EQ(got[axis].encnow, 0);
    s.client[i].saw[axis] = s.now;
    s.client[i].missed[axis] = 0;
  }
  s.client[i].looked = s.now;
  s.client[i].has_read = 1;
}

static void judge_ioctl(struct mc *mc, int i) {
  union argument arg, copy;
  uint32_t request = random_request(&arg);
  m.bad_pointer = chance(16) == 0;
  if (request == MCALIB || request == MSETENC) return; /* axes stay at 0, and servoed by that */
  if (request == MENABLE && (s.interval > 20000 || chance(2) != 0)) return;
  if (request == MSETPARAM) { /* no limits, and what counts alone feed back */
    int own = arg.param.which >= 0 && arg.param.which < AXES ? s.param[arg.param.which].mode : 0;
    if (chance(2) != 0) arg.param.mode = own ^ ZEROFB;
    arg.param.mode &= MD_MASK | ZEROFB | ADDMD | SOFTERR;
    arg.param.ilimax = arg.param.ilimax < 0 ? -1 : 0;
  }
  if (request == MSETINTERVAL && s.enabled) arg.words[0] %= 20001;
  copy = arg;
  show("request", i, (long)request, arg.words[0]);
  if (chance(64) == 0) {
    CHECK_EQ(mc_ioctl(mc, i, request ^ 0x7F, &arg),
             may(i, 0) || may(i, 1) ? -MC_ENOTTY : -MC_EBADF);
    return;
  }
  int want = model_ioctl(i, request, &copy, !m.bad_pointer);
  CHECK_EQ(mc_ioctl(mc, i, request, &arg), want);
  if (request != MGETSTATS && want == 0) CHECK(memcmp(&arg, &copy, sizeof arg) == 0);
}

static void judge_state(const struct mc *mc) {
  if (users(0) == 0) return;
  CHECK_EQ(mc_joints(mc), s.joints);
  int64_t off = (int64_t)mc_interval(mc) - s.interval;
  CHECK(off <= s.interval / 1000 && -off <= s.interval / 1000);
  s.interval = (int)mc_interval(mc);
  CHECK_EQ(mc_diag(mc), s.diag);
  CHECK_EQ(mc_double_buffer(mc), s.double_buffer);
  CHECK_EQ(mc_is_stopped(mc), s.stopped);
  CHECK_EQ(mc_is_enabled(mc), s.enabled);
  CHECK_EQ(mc_stats_of(mc)->panics, 0);
  for (int axis = 0; axis < AXES; axis++) {
    CHECK_EQ(mc_setpoint(mc, axis), s.setpoint[axis]);
    CHECK(memcmp(mc_param_of(mc, axis), &s.param[axis], sizeof s.param[axis]) == 0);
  }
  for (int i = 0; i < CLIENTS; i++) {
    if (s.client[i].used) CHECK_EQ(m.signals[i], s.client[i].signals);
  }
}

static void judge_call(struct mc *mc) {
  int32_t values[AXES + 1];
  int i = (int)chance(CLIENTS + 2) - 1, flags = (int)chance(5) - 1, axis = (int)chance(AXES);
  unsigned bit = 2 * chance(3); /* MERR_PLO, MERR_ILIM, MERR_ZINDEX */
  size_t len = chance(8) != 0 ? 4 * chance(6) : chance(sizeof values);
  s.now++;
  m.bad_pointer = 0;
  uint32_t what = chance(12);
  static const char *const names[] = {"open",  "close", "error", "run",  "write",
                                      "write", "read",  "read",  "ioctl"};
  show(names[what < 8 ? what : 8], i, what == 0 ? flags : what == 2 ? axis : (long)len, (long)bit);
  if (what == 0 && users(0) < CLIENTS) {
    int opened = model_open(flags);
    CHECK_EQ(mc_open(mc, flags), opened);
    if (opened >= 0) m.signals[opened] = 0;
  }
  if (what == 1 && chance(number_of_call % 1024 < 512 ? 3 : 1) == 0)
    CHECK_EQ(mc_close(mc, i), model_close(i));
  if (what == 2 && users(0) > 0) {
    s.raised[axis][bit] = s.now;
    s.pending[axis] |= 1u << bit;
    if (bit == 4) error_raise_index(mc, axis, s.index[axis] = (uint16_t)chance(65536));
    if (bit != 4) error_raise(mc, axis, (uint8_t)(1u << bit));
  }
  if (what == 3) mock_run(&m, (int64_t)chance(4000));
  if (what == 4 || what == 5) {
    for (int n = 0; n <= AXES; n++) values[n] = number();
    m.bad_pointer = chance(16) == 0;
    CHECK_EQ(mc_write(mc, i, values, len), model_write(i, values, len, !m.bad_pointer));
  }
  if (what == 6 || what == 7) judge_read(mc, i, 7 * len);
  if (what > 7) judge_ioctl(mc, i);
  m.bad_pointer = 0;
  CHECK(!m.masked);
  judge_state(mc);
}

TEST(test_calls_that_a_model_judges, "DRV-2 DRV-3 DRV-4 DRV-5 DRV-6 DRV-12") {
  begin(__STDC_HOSTED__ ? 300000 : 20000);
  struct mc *mc = NULL;
  while (more()) {
    if (machine_ends(mc)) {
      memset(&s, 0, sizeof s);
      mc = mock_start(&m, AXES / 2);
    }
    judge_call(mc);
  }
}
