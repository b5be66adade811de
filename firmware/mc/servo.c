/* SPDX-License-Identifier: Apache-2.0 */
// Length: the law, and the way of a 32-bit processor, which is to have a file of its own.
/* The servo law: see servo.h. §2.1-§2.2.
 *
 * It is there twice. wide_step() takes all numbers that there may be, in 64 bits that saturate: on
 * a 32-bit processor that is slow. narrow_step() does the same in 32 bits, without a division if b0
 * is a power of two; servo_prepare() works out for which errors nothing can overflow there, and a
 * loop that works meets no others. Both give the same bits.
 */
#include "servo.h"

#include "servo_math.h"

/* Out of the way of the usual path. */
#define RARE __attribute__((noinline))

/* What narrow_step() takes; |v| <= bound, or -bound <= v < bound. */
#define NARROW_FB (1u << 27)
#define NARROW_N (1u << 28)
#define NARROW_DEMAND (1u << 29)
#define NARROW_FRICTION (1u << 28)
#define NARROW_PHI (1u << 27)
#define NARROW_A (1u << 29)
#define NARROW_BASE (1 << 14) /* |b0| */
#define NARROW_RATIO 2        /* |b1/b0|, |b2/b0| */

int32_t servo_extend(int32_t position, uint16_t from, uint16_t to) {
  int16_t moved = (int16_t)(uint16_t)(to - from);
  return (int32_t)((uint32_t)position + (uint32_t)moved);
}

RARE static int32_t wide_phi(const struct mc_param *par, uint16_t raw) {
  return sat32((int64_t)par->adc_a * raw + par->adc_b);
}

/* Narrow factors have 16 bits, whose product takes the 68020 half the time of one of 32. */
int32_t servo_phi(const struct mc_param *par, const struct servo_state *s, uint16_t raw) {
  return s->narrow_phi ? (int16_t)par->adc_a * (int16_t)raw + par->adc_b : wide_phi(par, raw);
}

int32_t servo_feedback(const struct mc_param *par, const struct mc_state *m) {
  return (par->mode & ADFB) != 0 ? m->adcvai : m->encnow;
}

/* --- state and parameters -------------------------------------------------------------------- */

void servo_reset(struct servo_state *s) {
  s->n1 = s->n2 = 0;
  s->y1 = s->y2 = s->e1 = s->e2 = 0;
  s->filtered = 0;
  s->over = 0;
  s->triangle = 0;
  s->falling = 0;
  s->primed = 0;
  s->outside = 0;
  s->wide = 1;
}

static int32_t clip_limit(int32_t ilim) {
  if (ilim < 0) return 0;
  return ilim < SERVO_DAC_MAX ? ilim : SERVO_DAC_MAX;
}

static enum servo_kind kind_of(const struct mc_param *par, int is_power) {
  int mode = par->mode & MD_MASK;
  if (mode == MD_TORQ) return SERVO_TORQUE;
  if (mode == MD_TEST1) return SERVO_TRIANGLE;
  if (mode != MD_POS && mode != MD_VEL) return SERVO_OFF;
  if ((par->b1 | par->b2) == 0) return par->a2 == 0 && is_power ? SERVO_PD : SERVO_SUM;
  if (par->b2 != 0) return SERVO_RECURSION;
  if (par->b1 == -(int64_t)par->b0) return SERVO_INTEGRATOR;
  int decays = par->b1 < 0 && par->b1 > -par->b0 && par->b0 <= 1 << 10;
  return decays && par->a2 == 0 && is_power ? SERVO_FILTER : SERVO_RECURSION;
}

/* With errors e within top and N1, N2 within NARROW_N, N = a0*e + a1*e1 + a2*e2 - b1*N1/b0 -
 * b2*N2/b0 must leave room for friction and A/D offset in 32 bits:
 * sum|a|*top < 2^29, plus 2*2*2^28, plus 2^28 + 2^27 is less than 2^31. Without b1 and b2, and
 * with u = N/b0 at most half of N, sum|a|*top may reach 2^31. */
void servo_prepare(struct servo_state *s, const struct mc_param *par) {
  uint32_t base = magnitude(par->b0);
  uint32_t a0 = magnitude(par->a0), a1 = magnitude(par->a1), a2 = magnitude(par->a2);
  s->shift = 0;
  while (s->shift < 30 && 1u << s->shift < base) s->shift++;
  if (par->b0 < 0 || 1u << s->shift != base) s->shift = SERVO_NO_SHIFT;
  s->kind = (uint8_t)kind_of(par, s->shift != SERVO_NO_SHIFT);
  s->limit = par->ilimax == 0 ? clip_limit(par->ilim) : SERVO_DAC_MAX;
  s->narrow_phi = (uint8_t)(is_within(par->adc_a, 1u << 14) && is_within(par->adc_b, 1u << 30));
  s->wide = 1;
  s->top = 0;
  if (s->kind == SERVO_OFF) return;
  if (!is_within(par->ic_pos, NARROW_FRICTION) || !is_within(par->ic_neg, NARROW_FRICTION)) return;
  if (s->kind >= SERVO_TORQUE) {
    s->top = NARROW_DEMAND * 2;
    return;
  }
  if ((a0 | a1 | a2) >= NARROW_A || base > NARROW_BASE ||
      magnitude(par->b1) > NARROW_RATIO * base || magnitude(par->b2) > NARROW_RATIO * base) {
    return;
  }
  uint32_t bound = s->kind > SERVO_SUM || base == 1 ? 1u << 2 : 1u << 4;
  for (s->top = 1u << 27; a0 + a1 + a2 >= bound && s->top > 0; s->top >>= 1) bound *= 2;
}

/* N = b0*u: another b0 with the same u. */
static int64_t rescale(int64_t n, int32_t from, int32_t to) {
  int32_t remainder;
  return sat_mul(divide(n, from, &remainder), to);
}

void servo_change(struct servo_state *s, const struct mc_param *from, const struct mc_param *to) {
  int changed = from->mode ^ to->mode;
  if ((changed & (MD_MASK | ADFB | ZEROFB)) != 0) {
    int32_t filtered = s->filtered;
    uint8_t outside = s->outside;
    servo_reset(s);
    s->filtered = filtered;
    s->outside = (changed & ADFB) != 0 ? 0 : outside;
  } else if (from->b0 != to->b0) {
    s->n1 = rescale(s->n1, from->b0, to->b0);
    s->n2 = rescale(s->n2, from->b0, to->b0);
  }
  if ((changed & POSCHK) != 0) s->outside = 0;
  servo_prepare(s, to);
}

/* --- common to both ways --------------------------------------------------------------------- */

/* Limits raise an event when they are crossed, not while the axis stays beyond them. */
static uint8_t check_position(const struct mc_param *par, struct servo_state *s, int32_t fb) {
  uint8_t outside = 0;
  if (fb < par->plo) outside |= MERR_PLO;
  if (fb > par->phi) outside |= MERR_PHI;
  uint8_t crossed = (uint8_t)(outside & ~s->outside);
  s->outside = outside;
  return crossed;
}

/* inow = p/F * inow + (F - p) * i is inow * F through a unity-gain pole at p/F. With F = 1024 no
 * product leaves 32 bits: 1023 * 1024 * 2048 < 2^31. */
int32_t servo_inow(const struct mc_param *par, struct servo_state *s, int32_t current) {
  int32_t pole = par->ipole;
  if (pole == 0) {
    s->filtered = current * MC_FSCALE;
    return current;
  }
  s->filtered = pole * s->filtered / MC_FSCALE + (int16_t)(MC_FSCALE - pole) * (int16_t)current;
  return s->filtered;
}

/* Which way friction is to be overcome. At rest the demand u tells where the axis is about to go;
 * on an axis whose encoder runs against the torque (ic_pos < 0) that is the other way. */
static int direction(const struct mc_param *par, int32_t vel, int sign_of_u) {
  if (vel != 0) return vel < 0 ? -1 : 1;
  return par->ic_pos < 0 ? -sign_of_u : sign_of_u;
}

/* beyond: i stands for a larger number of the same sign. */
static inline int32_t limit_current(const struct mc_param *par, struct servo_state *s, int32_t i,
                                    int beyond) {
  int32_t size = i < 0 ? -i : i;
  if (par->ilimax != 0 && (size > par->ilim || beyond)) {
    if (s->over < INT32_MAX) s->over++;
    if (s->over > par->ilimax) {
      s->events |= MERR_ILIM;
      s->over = 0;
    }
  } else {
    s->over = 0;
  }
  if (size <= s->limit) return i;
  s->clipped = 1;
  return i < 0 ? -s->limit : s->limit;
}

/* --- any numbers ----------------------------------------------------------------------------- */

/* An axis begins at rest. */
static void prime(struct servo_state *s, int32_t y) {
  if (!s->primed) s->y1 = s->y2 = y;
  s->primed = 1;
}

/* vel = (3y - 4y1 + y2) / 2, truncated toward zero. */
static int32_t velocity(int32_t y, int32_t y1, int32_t y2) {
  if (is_within(y, NARROW_FB) && is_within(y1, NARROW_FB) && is_within(y2, NARROW_FB)) {
    return (3 * y - 4 * y1 + y2) / 2;
  }
  return sat32((3 * (int64_t)y - 4 * (int64_t)y1 + y2) / 2);
}

static int32_t wide_sense(struct servo_state *s, int32_t y) {
  prime(s, y);
  int32_t vel = velocity(y, s->y1, s->y2);
  s->wide = 1;
  s->y2 = s->y1;
  s->y1 = y;
  return vel;
}

/* b * N / b0 without losing what N / b0 truncates: b*(N/b0) + b*(N mod b0)/b0. */
static int64_t wide_term(int32_t b, int64_t n, int32_t b0) {
  int32_t remainder;
  if (b == 0 || n == 0) return 0;
  int64_t whole = sat_mul(b, divide(n, b0, &remainder));
  return sat_add(whole, (int64_t)b * remainder / b0);
}

/* D(z) = (a0 + a1/z + a2/z^2) / (b0 + b1/z + b2/z^2): from
 * b0*u + b1*u1 + b2*u2 = a0*e + a1*e1 + a2*e2 follows, with N = b0*u kept un-truncated,
 * N = a0*e + a1*e1 + a2*e2 - b1*N1/b0 - b2*N2/b0 and u = N/b0. */
static int64_t wide_law(const struct mc_param *par, struct servo_state *s, int32_t e) {
  int32_t remainder;
  int64_t n = sat_add((int64_t)par->a0 * e, (int64_t)par->a1 * s->e1);
  n = sat_add(n, (int64_t)par->a2 * s->e2);
  n = sat_sub(n, wide_term(par->b1, s->n1, par->b0));
  n = sat_sub(n, wide_term(par->b2, s->n2, par->b0));
  s->e2 = s->e1;
  s->e1 = e;
  s->n2 = s->n1;
  s->n1 = n;
  return divide(n, par->b0, &remainder);
}

/* MD_TEST1: 0, 1, ... ilim, ilim-1, ... -ilim, ... one D/A unit per sample. */
static int32_t triangle(const struct mc_param *par, struct servo_state *s) {
  int32_t limit = clip_limit(par->ilim);
  if (s->triangle >= limit) {
    s->triangle = limit;
    s->falling = 1;
  } else if (s->triangle <= -limit) {
    s->triangle = -limit;
    s->falling = 0;
  }
  int32_t value = s->triangle;
  if (limit > 0) s->triangle += s->falling ? -1 : 1;
  return value;
}

static int32_t wide_current(const struct mc_param *par, struct servo_state *s, int64_t u,
                            const struct mc_state *m) {
  int64_t i = u;
  if ((par->mode & COULCOMP) != 0) {
    int way = direction(par, m->vel, (u > 0) - (u < 0));
    if (way > 0) i = sat_add(i, par->ic_pos);
    if (way < 0) i = sat_sub(i, par->ic_neg);
  }
  if ((par->mode & ADOFF) != 0) i = sat_add(i, m->adcvai);
  if (i > INT32_MAX) return limit_current(par, s, INT32_MAX, 1);
  if (i < -INT32_MAX) return limit_current(par, s, -INT32_MAX, 1);
  return limit_current(par, s, (int32_t)i, 0);
}

RARE static int32_t wide_step(const struct mc_param *par, struct servo_state *s, int32_t setpoint,
                              struct mc_state *m) {
  int mode = par->mode & MD_MASK;
  servo_sense(par, s, m);
  if ((par->mode & POSCHK) != 0) s->events = check_position(par, s, m->fbnow);
  int32_t current = 0;
  if (s->kind != SERVO_OFF) {
    int32_t fed = (par->mode & ZEROFB) != 0 ? 0 : mode == MD_VEL ? m->vel : m->fbnow;
    int32_t demand = (par->mode & ADDMD) != 0 ? m->adcvai : setpoint;
    m->error = sat32((int64_t)demand - fed);
    int64_t u = s->kind < SERVO_TORQUE    ? wide_law(par, s, m->error)
                : s->kind == SERVO_TORQUE ? demand
                                          : triangle(par, s);
    current = wide_current(par, s, u, m);
  }
  m->inow = servo_inow(par, s, current);
  return current;
}

/* --- numbers that 32 bits hold --------------------------------------------------------------- */

static inline int32_t shifted(const struct servo_state *s, int32_t n) {
  return n < 0 ? -(-n >> s->shift) : n >> s->shift;
}

static int32_t over_b0(const struct mc_param *par, const struct servo_state *s, int32_t n) {
  return s->shift == SERVO_NO_SHIFT ? n / par->b0 : shifted(s, n);
}

static int32_t narrow_term(const struct mc_param *par, const struct servo_state *s, int32_t b,
                           int32_t n) {
  if (b == 0) return 0;
  int32_t quotient = over_b0(par, s, n);
  return b * quotient + over_b0(par, s, b * (n - quotient * par->b0));
}

/* N of any law but SERVO_PD and SERVO_FILTER. */
static int32_t narrow_sum(const struct mc_param *par, struct servo_state *s, int32_t e) {
  int32_t n = par->a0 * e, n1 = (int32_t)s->n1;
  if (par->a1 != 0) n += par->a1 * s->e1;
  if (par->a2 != 0) n += par->a2 * s->e2;
  if (s->kind == SERVO_INTEGRATOR) {
    n += n1;
  } else if (s->kind == SERVO_RECURSION) {
    n -= narrow_term(par, s, par->b1, n1) + narrow_term(par, s, par->b2, (int32_t)s->n2);
  } else {
    return n;
  }
  if (!is_within(n, NARROW_N)) s->wide = 1;
  return n;
}

/* The same of a filter. b1*(N1/b0) + b1*(N1 mod b0)/b0 is b1*N1/b0, truncated: b1*(N1/b0) is whole,
 * and what is left has its sign. Up to the D/A's full scale the product has 32 bits. */
static inline int32_t narrow_filter(const struct mc_param *par, struct servo_state *s, int32_t e) {
  int32_t n1 = (int32_t)s->n1, n = par->a0 * e + par->a1 * s->e1;
  n -= is_within(n1, 1u << 21) ? shifted(s, par->b1 * n1) : narrow_term(par, s, par->b1, n1);
  if (!is_within(n, NARROW_N)) s->wide = 1;
  return n;
}

static inline int32_t narrow_law(const struct mc_param *par, struct servo_state *s, int32_t e) {
  int32_t n, u;
  if (s->kind == SERVO_PD) {
    n = par->a0 * e;
    if (par->a1 != 0) n += par->a1 * s->e1;
    u = shifted(s, n);
  } else if (s->kind == SERVO_FILTER) {
    n = narrow_filter(par, s, e);
    u = shifted(s, n);
  } else {
    n = narrow_sum(par, s, e);
    u = over_b0(par, s, n);
  }
  s->e2 = s->e1;
  s->e1 = e;
  s->n2 = s->n1;
  s->n1 = n;
  return u;
}

static inline int32_t narrow_friction(const struct mc_param *par, int32_t vel, int32_t u) {
  int way = direction(par, vel, (u > 0) - (u < 0));
  return way > 0 ? par->ic_pos : way < 0 ? -par->ic_neg : 0;
}

/* Whether narrow_step() may begin: at the first sample all histories but that of y are 0. */
static inline int starts_narrow(struct servo_state *s, int32_t y) {
  prime(s, y);
  return is_within(y, NARROW_FB);
}

RARE static int is_narrow(const struct servo_state *s) {
  if (!is_within(s->y1, NARROW_FB) || !is_within(s->y2, NARROW_FB)) return 0;
  if (!is_within(s->e1, s->top) || !is_within(s->e2, s->top)) return 0;
  if (s->kind == SERVO_PD || s->kind == SERVO_SUM) return 1;
  return fits(s->n1) && fits(s->n2) && is_within((int32_t)s->n1, NARROW_N) &&
         is_within((int32_t)s->n2, NARROW_N);
}

/* 1 and *current, or 0 and nothing has happened. The histories are narrow. */
static inline int narrow_step(const struct mc_param *par, struct servo_state *s, int32_t demand,
                              struct mc_state *m, int32_t *current) {
  int flags = par->mode;
  int32_t fb = m->encnow;
  if ((flags & (ADFB | ADDMD | ADOFF)) != 0) {
    if (!is_within(m->adcvai, NARROW_PHI)) return 0;
    if ((flags & ADFB) != 0) fb = m->adcvai;
    if ((flags & ADDMD) != 0) demand = m->adcvai;
  }
  if (!is_within(fb, NARROW_FB) || !is_within(demand, NARROW_DEMAND)) return 0;
  int32_t y1 = s->y1, vel = (3 * fb - 4 * y1 + s->y2) / 2;
  int32_t fed = (flags & MD_MASK) == MD_VEL ? vel : fb;
  if ((flags & ZEROFB) != 0) fed = 0;
  int32_t error = demand - fed;
  if (!is_within(error, s->top)) return 0;
  s->y2 = y1;
  s->y1 = fb;
  m->fbnow = fb;
  m->vel = vel;
  m->error = error;
  s->clipped = 0;
  s->events = (flags & POSCHK) != 0 ? check_position(par, s, fb) : 0;
  int32_t i = s->kind < SERVO_TORQUE    ? narrow_law(par, s, error)
              : s->kind == SERVO_TORQUE ? demand
                                        : triangle(par, s);
  if ((flags & (COULCOMP | ADOFF)) != 0) {
    if ((flags & COULCOMP) != 0) i += narrow_friction(par, vel, i);
    if ((flags & ADOFF) != 0) i += m->adcvai;
  }
  *current = limit_current(par, s, i, 0);
  m->inow = servo_inow(par, s, *current);
  return 1;
}

/* --- samples --------------------------------------------------------------------------------- */

void servo_sense(const struct mc_param *par, struct servo_state *s, struct mc_state *m) {
  m->fbnow = servo_feedback(par, m);
  m->vel = wide_sense(s, m->fbnow);
  m->error = 0;
  m->inow = 0;
  s->events = s->clipped = 0;
}

int32_t servo_step(const struct mc_param *par, struct servo_state *s, int32_t setpoint,
                   struct mc_state *m) {
  int32_t current;
  if (s->wide && (s->primed ? is_narrow(s) : starts_narrow(s, servo_feedback(par, m)))) {
    s->wide = 0;
  }
  if (!s->wide && narrow_step(par, s, setpoint, m, &current)) return current;
  return wide_step(par, s, setpoint, m);
}
