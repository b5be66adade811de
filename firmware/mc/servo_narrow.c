/* SPDX-License-Identifier: Apache-2.0 */
/* The servo law in 32 bits: see servo_narrow.h. §1.3.1, §2.2
 *
 * Without a division if b0 is a power of two. servo_prepare() works out for which errors nothing
 * can overflow; a loop that works meets no others. All else is servo_step()'s.
 */
#include "servo_narrow.h"

#include "servo_math.h"

#define USUAL(condition) __builtin_expect(condition, 1)
#define NO_SHIFT 32

/* What narrow_step() takes; |v| <= bound, or -bound <= v < bound. */
#define NARROW_FB (1u << 27)
#define NARROW_N (1u << 28)
#define NARROW_DEMAND (1u << 29)
#define NARROW_FRICTION (1u << 28)
#define NARROW_PHI (1u << 27)
#define NARROW_A (1u << 29)
#define NARROW_BASE (1 << 14) /* |b0| */
#define NARROW_RATIO 2        /* |b1/b0|, |b2/b0| */

RARE static int32_t wide_phi(const struct mc_param *par, uint16_t raw) {
  return servo_phi(par, raw);
}

/* Narrow factors have 16 bits, whose product takes the 68020 half the time of one of 32. */
int32_t servo_narrow_phi(const struct mc_param *par, const struct servo_prepared *p, uint16_t raw) {
  if (p->phi == SERVO_PHI_WIDE) return wide_phi(par, raw);
  int32_t product = p->phi == SERVO_PHI_LINE ? (int16_t)par->adc_a * (int16_t)raw : raw;
  return product + par->adc_b;
}

/* --- parameters ------------------------------------------------------------------------------ */

static enum servo_kind kind_of(const struct mc_param *par, int is_power) {
  int mode = par->mode & MD_MASK;
  if (mode == MD_TORQ) return SERVO_TORQUE;
  if (mode == MD_TEST1) return SERVO_TRIANGLE;
  if (mode != MD_POS && mode != MD_VEL) return SERVO_OFF;
  if ((par->b1 | par->b2) == 0) return par->a2 == 0 && is_power ? SERVO_PD : SERVO_SUM;
  if (par->b2 != 0) return SERVO_RECURSION;
  if (par->b1 == -(int64_t)par->b0) return SERVO_INTEGRATOR;
  int decays = par->b0 > 0 && par->b0 <= 1 << 10 && par->b1 < 0 && par->b1 > -par->b0;
  return decays && par->a2 == 0 && is_power ? SERVO_FILTER : SERVO_RECURSION;
}

/* With errors e within top and N1, N2 within NARROW_N, N = a0*e + a1*e1 + a2*e2 - b1*N1/b0 -
 * b2*N2/b0 must leave room for friction and A/D offset in 32 bits:
 * sum|a|*top < 2^29, plus 2*2*2^28, plus 2^28 + 2^27 is less than 2^31. Without b1 and b2, and
 * with u = N/b0 at most half of N, sum|a|*top may reach 2^31. */
void servo_prepare(struct servo_prepared *p, const struct mc_param *par) {
  uint32_t base = magnitude(par->b0);
  uint32_t a0 = magnitude(par->a0), a1 = magnitude(par->a1), a2 = magnitude(par->a2);
  p->shift = 0;
  while (p->shift < 30 && 1u << p->shift < base) p->shift++;
  if (par->b0 < 0 || 1u << p->shift != base) p->shift = NO_SHIFT;
  p->kind = (uint8_t)kind_of(par, p->shift != NO_SHIFT);
  p->limit = par->ilimax == 0 ? servo_clip_limit(par) : SERVO_DAC_MAX;
  p->phi = SERVO_PHI_WIDE;
  if (is_within(par->adc_a, 1u << 14) && is_within(par->adc_b, 1u << 30)) {
    p->phi = par->adc_a == 1 ? SERVO_PHI_OFFSET : SERVO_PHI_LINE;
  }
  p->top = 0;
  if (p->kind == SERVO_OFF) return;
  if (!is_within(par->ic_pos, NARROW_FRICTION) || !is_within(par->ic_neg, NARROW_FRICTION)) return;
  if (p->kind >= SERVO_TORQUE) {
    p->top = NARROW_DEMAND * 2;
    return;
  }
  if ((a0 | a1 | a2) >= NARROW_A || base > NARROW_BASE ||
      magnitude(par->b1) > NARROW_RATIO * base || magnitude(par->b2) > NARROW_RATIO * base) {
    return;
  }
  int direct = p->kind == SERVO_PD || p->kind == SERVO_SUM;
  uint32_t bound = !direct || base == 1 ? 1u << 2 : 1u << 4;
  for (p->top = 1u << 27; a0 + a1 + a2 >= bound && p->top > 0; p->top >>= 1) bound *= 2;
}

/* --- a sample -------------------------------------------------------------------------------- */

static inline int32_t limit_narrow(const struct mc_param *par, const struct servo_prepared *p,
                                   struct servo_memory *s, int32_t i) {
  int32_t size = i < 0 ? -i : i;
  if (par->ilimax != 0 && size > par->ilim) {
    if (s->over++ >= par->ilimax) {
      s->events |= MERR_ILIM;
      s->over = 0;
    }
  } else {
    s->over = 0;
  }
  if (size <= p->limit) {
    s->clipped = 0;
    return i;
  }
  s->clipped = 1;
  return i < 0 ? -p->limit : p->limit;
}

static inline int32_t shifted(const struct servo_prepared *p, int32_t n) {
  return n < 0 ? -(-n >> p->shift) : n >> p->shift;
}

static int32_t over_b0(const struct mc_param *par, const struct servo_prepared *p, int32_t n) {
  return p->shift == NO_SHIFT ? n / par->b0 : shifted(p, n);
}

static int32_t narrow_term(const struct mc_param *par, const struct servo_prepared *p, int32_t b,
                           int32_t n) {
  if (b == 0) return 0;
  int32_t quotient = over_b0(par, p, n);
  return b * quotient + over_b0(par, p, b * (n - quotient * par->b0));
}

/* Any law but SERVO_PD and SERVO_FILTER. */
static int32_t narrow_sum(const struct mc_param *par, const struct servo_prepared *p,
                          struct servo_memory *s, int32_t e) {
  int32_t n = par->a0 * e, n1 = (int32_t)s->n1;
  if (par->a1 != 0) n += par->a1 * s->e1;
  if (par->a2 != 0) n += par->a2 * s->e2;
  if (p->kind == SERVO_INTEGRATOR) n += n1;
  if (p->kind == SERVO_RECURSION) {
    n -= narrow_term(par, p, par->b1, n1) + narrow_term(par, p, par->b2, (int32_t)s->n2);
  }
  if (p->kind != SERVO_SUM && !is_within(n, NARROW_N)) s->narrow = 0;
  s->e2 = s->e1;
  s->e1 = e;
  s->n2 = s->n1;
  s->n1 = n;
  return over_b0(par, p, n);
}

/* Of SERVO_FILTER: b1*(N1/b0) + b1*(N1 mod b0)/b0 is b1*N1/b0, truncated, as b1*(N1/b0) is whole
 * and what is left has its sign. Up to the D/A's full scale the product has 32 bits. */
RARE static int32_t filter_term_of_large(const struct mc_param *par, const struct servo_prepared *p,
                                         int32_t n1) {
  int32_t quotient = shifted(p, n1);
  return par->b1 * quotient + shifted(p, par->b1 * (n1 - quotient * par->b0));
}

static inline int32_t filter_term(const struct mc_param *par, const struct servo_prepared *p,
                                  int32_t n1) {
  return is_within(n1, 1u << 21) ? shifted(p, par->b1 * n1) : filter_term_of_large(par, p, n1);
}

/* PD, with a derivative filter or without. */
static inline int32_t narrow_pd(const struct mc_param *par, const struct servo_prepared *p,
                                struct servo_memory *s, int32_t e) {
  int32_t e1 = s->e1, n1 = (int32_t)s->n1;
  s->n2 = s->n1;
  s->e2 = e1;
  s->e1 = e;
  int32_t n = par->a0 * e;
  if (USUAL(par->a1 != 0)) n += par->a1 * e1;
  if (p->kind == SERVO_FILTER) {
    n -= filter_term(par, p, n1);
    if (!is_within(n, NARROW_N)) s->narrow = 0;
  }
  s->n1 = n;
  return shifted(p, n);
}

static inline int32_t narrow_friction(const struct mc_param *par, int32_t vel, int32_t u) {
  int way = (vel > 0) - (vel < 0);
  if (vel == 0) way = par->ic_pos < 0 ? (u < 0) - (u > 0) : (u > 0) - (u < 0);
  return way > 0 ? par->ic_pos : way < 0 ? -par->ic_neg : 0;
}

/* Whether narrow_step() may begin: at the first sample all histories but that of y are 0. */
static inline int starts_narrow(struct servo_memory *s, int32_t y) {
  s->y1 = s->y2 = y;
  s->primed = 1;
  return is_within(y, NARROW_FB);
}

RARE static int is_narrow(const struct servo_prepared *p, const struct servo_memory *s) {
  if (!is_within(s->y1, NARROW_FB) || !is_within(s->y2, NARROW_FB)) return 0;
  if (!is_within(s->e1, p->top) || !is_within(s->e2, p->top)) return 0;
  if (p->kind == SERVO_PD || p->kind == SERVO_SUM) return 1;
  return fits(s->n1) && fits(s->n2) && is_within((int32_t)s->n1, NARROW_N) &&
         is_within((int32_t)s->n2, NARROW_N);
}

/* 1 and *current, or 0 and nothing has happened. The histories are narrow. */
static inline int narrow_step(const struct mc_param *par, const struct servo_prepared *p,
                              struct servo_memory *s, int32_t demand, struct mc_state *m,
                              int32_t *current) {
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
  if (!is_within(error, p->top)) return 0;
  s->y2 = y1;
  s->y1 = fb;
  m->fbnow = fb;
  m->vel = vel;
  m->error = error;
  s->events = (flags & POSCHK) != 0 ? servo_check_position(par, s, fb) : 0;
  int32_t i = p->kind <= SERVO_FILTER   ? narrow_pd(par, p, s, error)
              : p->kind < SERVO_TORQUE  ? narrow_sum(par, p, s, error)
              : p->kind == SERVO_TORQUE ? demand
                                        : servo_triangle(par, s);
  if ((flags & (COULCOMP | ADOFF)) != 0) {
    if ((flags & COULCOMP) != 0) i += narrow_friction(par, vel, i);
    if ((flags & ADOFF) != 0) i += m->adcvai;
  }
  *current = limit_narrow(par, p, s, i);
  m->inow = servo_inow(par, s, *current);
  return 1;
}

RARE static int32_t wide_step(const struct mc_param *par, struct servo_memory *s, int32_t setpoint,
                              struct mc_state *m) {
  return servo_step(par, s, setpoint, m);
}

int32_t servo_narrow_step(const struct mc_param *par, const struct servo_prepared *p,
                          struct servo_memory *s, int32_t setpoint, struct mc_state *m) {
  int32_t current;
  if (!s->narrow) {
    s->narrow = (uint8_t)(s->primed ? is_narrow(p, s) : starts_narrow(s, servo_feedback(par, m)));
  }
  if (s->narrow && narrow_step(par, p, s, setpoint, m, &current)) return current;
  return wide_step(par, s, setpoint, m);
}
