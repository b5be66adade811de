/* SPDX-License-Identifier: Apache-2.0 */
/* The servo law: see servo.h. §2.1-§2.2.
 *
 * The compensator is there twice. wide_law() takes all numbers that parameters may have, in 64 bits
 * that saturate: on a 32-bit processor that is slow. narrow_law() does the same in 32 bits;
 * servo_prepare() finds out for which errors nothing can overflow there, and that is what a loop
 * that works meets. Both give the same bits.
 */
#include "servo.h"

/* Out of the way of the usual path. */
#define RARE __attribute__((noinline, cold))

#define NARROW_HISTORY (1u << 28) /* narrow_law(): bound of N1 and N2 */
#define NARROW_RATIO 2            /* bound of |b1/b0| and |b2/b0| */
#define NARROW_BASE (1 << 14)     /* bound of |b0| */
#define NARROW_FRICTION (1u << 28)
#define NARROW_OFFSET (1u << 27)

static uint32_t magnitude(int32_t v) {
  return v < 0 ? 0u - (uint32_t)v : (uint32_t)v;
}

/* 1 if -top <= v < top, a power of two. */
static int is_within(int32_t v, uint32_t top) {
  return (uint32_t)v + top < 2 * top;
}

static int are_within(int32_t a, int32_t b, int32_t c, uint32_t top) {
  return (((uint32_t)a + top) | ((uint32_t)b + top) | ((uint32_t)c + top)) < 2 * top;
}

static int fits(int64_t v) {
  return (int32_t)((uint64_t)v >> 32) == ((int32_t)v < 0 ? -1 : 0);
}

static int32_t sat32(int64_t v) {
  if (v > INT32_MAX) return INT32_MAX;
  if (v < INT32_MIN) return INT32_MIN;
  return (int32_t)v;
}

static int64_t sat_add(int64_t a, int64_t b) {
  int64_t sum;
  if (__builtin_add_overflow(a, b, &sum)) return a < 0 ? INT64_MIN : INT64_MAX;
  return sum;
}

static int64_t sat_sub(int64_t a, int64_t b) {
  int64_t difference;
  if (__builtin_sub_overflow(a, b, &difference)) return a < 0 ? INT64_MIN : INT64_MAX;
  return difference;
}

static int64_t sat_mul(int64_t a, int64_t b) {
  int64_t product;
  if (__builtin_mul_overflow(a, b, &product)) {
    return (a < 0) == (b < 0) ? INT64_MAX : INT64_MIN;
  }
  return product;
}

/* n / d truncated toward zero, and the remainder; a 32-bit division whenever that is enough,
 * because 64-bit ones are subroutines on the processors this runs on. */
static int64_t divide(int64_t n, int32_t d, int32_t *remainder) {
  *remainder = 0;
  if (d == 1) return n;
  if (d == -1) return n == INT64_MIN ? INT64_MAX : -n;
  if (fits(n)) {
    *remainder = (int32_t)n % d;
    return (int32_t)n / d;
  }
  int64_t quotient = n / d;
  *remainder = (int32_t)(n - quotient * d);
  return quotient;
}

int32_t servo_extend(int32_t position, uint16_t from, uint16_t to) {
  int16_t moved = (int16_t)(uint16_t)(to - from);
  return (int32_t)((uint32_t)position + (uint32_t)moved);
}

RARE static int32_t wide_phi(const struct mc_param *par, uint16_t raw) {
  return sat32((int64_t)par->adc_a * raw + par->adc_b);
}

int32_t servo_phi(const struct mc_param *par, uint16_t raw) {
  int32_t a = par->adc_a, b = par->adc_b;
  if (is_within(a, 1u << 14) && is_within(b, 1u << 30)) return a * raw + b;
  return wide_phi(par, raw);
}

int32_t servo_feedback(const struct mc_param *par, const struct servo_input *in) {
  return (par->mode & ADFB) != 0 ? in->phi : in->position;
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
}

/* With errors e within top and N within NARROW_HISTORY, N = a0*e + a1*e1 + a2*e2 - b1*N1/b0 -
 * b2*N2/b0 must leave room for friction and A/D offset in 32 bits:
 * sum|a|*top < 2^29, plus 2*2*2^28, plus 2^28 + 2^27 is less than 2^31. Without b1 and b2, and
 * with u = N/b0 at most half of N, sum|a|*top may reach 2^31. */
void servo_prepare(struct servo_state *s, const struct mc_param *par) {
  uint32_t base = magnitude(par->b0);
  uint64_t sum = (uint64_t)magnitude(par->a0) + magnitude(par->a1) + magnitude(par->a2);
  int recurs = (par->b1 | par->b2) != 0;
  s->top = 0;
  s->shift = 0;
  if (base > NARROW_BASE || magnitude(par->b1) > NARROW_RATIO * base ||
      magnitude(par->b2) > NARROW_RATIO * base || !is_within(par->ic_pos, NARROW_FRICTION) ||
      !is_within(par->ic_neg, NARROW_FRICTION)) {
    return;
  }
  while (1u << s->shift < base) s->shift++;
  if (par->b0 < 0 || 1u << s->shift != base) s->shift = SERVO_NO_SHIFT;
  uint64_t room = recurs || base == 1 ? 1u << 29 : 1u << 31;
  for (uint32_t top = 1u << 27; top > 0 && s->top == 0; top >>= 1) {
    if (sum * top < room) s->top = top;
  }
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

/* --- what the axis does ---------------------------------------------------------------------- */

/* Limits raise an event when they are crossed, not while the axis stays beyond them. */
static uint8_t check_position(const struct mc_param *par, struct servo_state *s, int32_t fb) {
  uint8_t outside = 0;
  if (fb < par->plo) outside |= MERR_PLO;
  if (fb > par->phi) outside |= MERR_PHI;
  uint8_t crossed = (uint8_t)(outside & ~s->outside);
  s->outside = outside;
  return crossed;
}

RARE static int32_t wide_velocity(int32_t y, int32_t y1, int32_t y2) {
  return sat32((3 * (int64_t)y - 4 * (int64_t)y1 + y2) / 2);
}

/* (3y - 4y1 + y2) / 2, truncated toward zero. */
static inline int32_t velocity(int32_t y, int32_t y1, int32_t y2) {
  if (!are_within(y, y1, y2, 1u << 27)) return wide_velocity(y, y1, y2);
  return (3 * y - 4 * y1 + y2) / 2;
}

/* The velocity of this sample; y becomes part of the history. */
static inline int32_t sense(struct servo_state *s, int32_t y) {
  int32_t y1 = s->y1, y2 = s->y2;
  s->y2 = s->primed ? y1 : y;
  s->y1 = y;
  if (s->primed) return velocity(y, y1, y2);
  s->primed = 1;
  return 0;
}

/* inow = p/F * inow + (F - p) * i is inow * F through a unity-gain pole at p/F. With F = 1024 no
 * product leaves 32 bits: 1023 * 1024 * 2048 < 2^31. */
int32_t servo_inow(const struct mc_param *par, struct servo_state *s, int32_t current) {
  int32_t pole = par->ipole;
  if (pole == 0) {
    s->filtered = current * MC_FSCALE;
    return current;
  }
  s->filtered = pole * s->filtered / MC_FSCALE + (MC_FSCALE - pole) * current;
  return s->filtered;
}

/* --- the compensator ------------------------------------------------------------------------- */

/* D(z) = (a0 + a1/z + a2/z^2) / (b0 + b1/z + b2/z^2): from
 * b0*u + b1*u1 + b2*u2 = a0*e + a1*e1 + a2*e2 follows, with N = b0*u kept un-truncated,
 * N = a0*e + a1*e1 + a2*e2 - b1*N1/b0 - b2*N2/b0 and u = N/b0. */
static void remember(struct servo_state *s, int32_t e, int64_t n) {
  s->e2 = s->e1;
  s->e1 = e;
  s->n2 = s->n1;
  s->n1 = n;
}

/* b * N / b0 without losing what N / b0 truncates: b*(N/b0) + b*(N mod b0)/b0. */
static int64_t wide_term(int32_t b, int64_t n, int32_t b0) {
  int32_t remainder;
  if (b == 0 || n == 0) return 0;
  int64_t whole = sat_mul(b, divide(n, b0, &remainder));
  return sat_add(whole, (int64_t)b * remainder / b0);
}

RARE static int64_t wide_law(const struct mc_param *par, struct servo_state *s, int32_t e) {
  int32_t remainder;
  int64_t n = sat_add((int64_t)par->a0 * e, (int64_t)par->a1 * s->e1);
  n = sat_add(n, (int64_t)par->a2 * s->e2);
  n = sat_sub(n, wide_term(par->b1, s->n1, par->b0));
  n = sat_sub(n, wide_term(par->b2, s->n2, par->b0));
  remember(s, e, n);
  return divide(n, par->b0, &remainder);
}

static inline int32_t over_b0(const struct mc_param *par, const struct servo_state *s, int32_t n) {
  if (s->shift == SERVO_NO_SHIFT) return n / par->b0;
  return n < 0 ? -(int32_t)((uint32_t)-n >> s->shift) : n >> s->shift;
}

/* An integrator, b = -b0, needs no arithmetic. */
static int32_t narrow_term(const struct mc_param *par, const struct servo_state *s, int32_t b,
                           int32_t n) {
  if (b == 0) return 0;
  if (b == -par->b0) return -n;
  int32_t quotient = over_b0(par, s, n);
  return b * quotient + over_b0(par, s, b * (n - quotient * par->b0));
}

/* 1 and *u, or 0 and nothing has happened. */
static inline int narrow_law(const struct mc_param *par, struct servo_state *s, int32_t e,
                             int32_t *u) {
  int32_t e1 = s->e1, e2 = s->e2;
  if (!are_within(e, e1, e2, s->top)) return 0;
  int32_t n = par->a0 * e;
  if (par->a1 != 0) n += par->a1 * e1;
  if (par->a2 != 0) n += par->a2 * e2;
  if ((par->b1 | par->b2) != 0) {
    int32_t n1 = (int32_t)s->n1, n2 = (int32_t)s->n2;
    if (!fits(s->n1) || !fits(s->n2) || !are_within(n1, n2, 0, NARROW_HISTORY)) return 0;
    n -= narrow_term(par, s, par->b1, n1);
    n -= narrow_term(par, s, par->b2, n2);
  }
  remember(s, e, n);
  *u = over_b0(par, s, n);
  return 1;
}

/* --- from the law to the current ------------------------------------------------------------- */

static int32_t clip_limit(int32_t ilim) {
  if (ilim < 0) return 0;
  return ilim < SERVO_DAC_MAX ? ilim : SERVO_DAC_MAX;
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

/* Coulomb feedforward: which way friction is to be overcome. At rest the demand u tells where the
 * axis is about to go; on an axis whose encoder runs against the torque (ic_pos < 0) that is the
 * other way. */
static int direction(const struct mc_param *par, int32_t vel, int sign_of_u) {
  if (vel != 0) return vel < 0 ? -1 : 1;
  return par->ic_pos < 0 ? -sign_of_u : sign_of_u;
}

/* beyond: i stands for a larger number of the same sign. */
static inline int32_t limit_current(const struct mc_param *par, struct servo_state *s, int32_t i,
                                    int beyond, struct servo_output *out) {
  int32_t limit = par->ilimax == 0 ? clip_limit(par->ilim) : SERVO_DAC_MAX;
  int32_t size = i < 0 ? -i : i;
  if (par->ilimax != 0 && (size > par->ilim || beyond)) {
    if (s->over < INT32_MAX) s->over++;
    if (s->over > par->ilimax) {
      out->events |= MERR_ILIM;
      s->over = 0;
    }
  } else {
    s->over = 0;
  }
  if (size <= limit) return i;
  out->clipped = 1;
  return i < 0 ? -limit : limit;
}

/* All numbers that the narrow way does not take. */
RARE static int32_t wide_current(const struct mc_param *par, struct servo_state *s, int64_t u,
                                 int32_t phi, struct servo_output *out) {
  const int64_t most = INT64_MAX / 2;
  int64_t i = u > most ? most : u < -most ? -most : u;
  if ((par->mode & COULCOMP) != 0) {
    int way = direction(par, out->vel, (u > 0) - (u < 0));
    if (way > 0) i += par->ic_pos;
    if (way < 0) i -= par->ic_neg;
  }
  if ((par->mode & ADOFF) != 0) i += phi;
  if (i > INT32_MAX) return limit_current(par, s, INT32_MAX, 1, out);
  if (i < -INT32_MAX) return limit_current(par, s, -INT32_MAX, 1, out);
  return limit_current(par, s, (int32_t)i, 0, out);
}

static int32_t narrow_current(const struct mc_param *par, struct servo_state *s, int32_t u,
                              int32_t phi, struct servo_output *out) {
  int32_t i = u;
  if ((par->mode & (COULCOMP | ADOFF)) != 0) {
    if (!is_within(phi, NARROW_OFFSET)) return wide_current(par, s, u, phi, out);
    if ((par->mode & COULCOMP) != 0) {
      int way = direction(par, out->vel, (u > 0) - (u < 0));
      if (way > 0) i += par->ic_pos;
      if (way < 0) i -= par->ic_neg;
    }
    if ((par->mode & ADOFF) != 0) i += phi;
  }
  return limit_current(par, s, i, 0, out);
}

static int32_t servo_current(const struct mc_param *par, struct servo_state *s, int mode,
                             int32_t demand, int32_t phi, struct servo_output *out) {
  int32_t u;
  if (mode == MD_TORQ) return wide_current(par, s, demand, phi, out);
  if (mode == MD_TEST1) return wide_current(par, s, triangle(par, s), phi, out);
  if (narrow_law(par, s, out->error, &u)) return narrow_current(par, s, u, phi, out);
  return wide_current(par, s, wide_law(par, s, out->error), phi, out);
}

/* --- samples --------------------------------------------------------------------------------- */

void servo_sense(const struct mc_param *par, struct servo_state *s, const struct servo_input *in,
                 struct servo_output *out) {
  *out = (struct servo_output){0};
  out->fb = servo_feedback(par, in);
  out->vel = sense(s, out->fb);
}

void servo_step(const struct mc_param *par, struct servo_state *s, const struct servo_input *in,
                struct servo_output *out) {
  int flags = par->mode, mode = flags & MD_MASK;
  int32_t fb = servo_feedback(par, in), vel = sense(s, fb);
  out->fb = fb;
  out->vel = vel;
  out->events = (flags & POSCHK) != 0 ? check_position(par, s, fb) : 0;
  out->clipped = 0;
  int32_t error = 0, current = 0;
  if (mode >= MD_POS && mode <= MD_TEST1) {
    int32_t fed = (flags & ZEROFB) != 0 ? 0 : mode == MD_VEL ? vel : fb;
    int32_t demand = (flags & ADDMD) != 0 ? in->phi : in->setpoint;
    if (__builtin_sub_overflow(demand, fed, &error)) error = demand < 0 ? INT32_MIN : INT32_MAX;
    out->error = error;
    current = servo_current(par, s, mode, demand, in->phi, out);
  } else {
    out->error = 0;
  }
  out->current = current;
  out->inow = servo_inow(par, s, current);
}
