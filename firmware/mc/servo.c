/* SPDX-License-Identifier: Apache-2.0 */
/* The servo law: see servo.h. §2.1-§2.2. S1 to S5 are the switches of Fig. 2.1. */
#include "servo.h"

#include "servo_math.h"

int32_t servo_phi(const struct mc_param *par, uint16_t raw) {
  return sat32((int64_t)par->adc_a * raw + par->adc_b);
}

int32_t servo_feedback(const struct mc_param *par, const struct mc_state *m) {
  return (par->mode & ADFB) != 0 ? m->adcvai : m->encnow; /* S4 */
}

/* vel = (3y - 4y1 + y2) / 2, truncated toward zero; an axis begins at rest. */
void servo_sense(const struct mc_param *par, struct servo_memory *s, struct mc_state *m) {
  int32_t y = m->fbnow = servo_feedback(par, m);
  if (!s->primed) s->y1 = s->y2 = y;
  m->vel = sat32((3 * (int64_t)y - 4 * (int64_t)s->y1 + s->y2) / 2);
  m->error = m->inow = 0;
  s->y2 = s->y1;
  s->y1 = y;
  s->primed = 1;
  s->narrow = s->events = s->clipped = 0;
}

/* b * N / b0 without losing what N / b0 truncates: b*(N/b0) + b*(N mod b0)/b0. */
static int64_t term(int32_t b, int64_t n, int32_t b0) {
  int32_t remainder;
  if (b == 0 || n == 0) return 0;
  int64_t whole = sat_mul(b, divide(n, b0, &remainder));
  return sat_add(whole, (int64_t)b * remainder / b0);
}

/* D(z) = (a0 + a1/z + a2/z^2) / (b0 + b1/z + b2/z^2): from
 * b0*u + b1*u1 + b2*u2 = a0*e + a1*e1 + a2*e2 follows, with N = b0*u kept un-truncated,
 * N = a0*e + a1*e1 + a2*e2 - b1*N1/b0 - b2*N2/b0 and u = N/b0. */
static int64_t compensate(const struct mc_param *par, struct servo_memory *s, int32_t e) {
  int32_t remainder;
  int64_t n = sat_add((int64_t)par->a0 * e, (int64_t)par->a1 * s->e1);
  n = sat_add(n, (int64_t)par->a2 * s->e2);
  n = sat_sub(n, term(par->b1, s->n1, par->b0));
  n = sat_sub(n, term(par->b2, s->n2, par->b0));
  s->e2 = s->e1;
  s->e1 = e;
  s->n2 = s->n1;
  s->n1 = n;
  return divide(n, par->b0, &remainder);
}

/* S3. At rest the demand u tells where the axis is about to go; on an axis whose encoder runs
 * against the torque (ic_pos < 0) that is the other way. */
static int64_t overcome_friction(const struct mc_param *par, int32_t vel, int64_t u) {
  int way = (vel > 0) - (vel < 0);
  if (vel == 0) way = par->ic_pos < 0 ? (u < 0) - (u > 0) : (u > 0) - (u < 0);
  if (way > 0) return sat_add(u, par->ic_pos);
  return way < 0 ? sat_sub(u, par->ic_neg) : u;
}

/* With ilimax an overload of more than so many samples is an error, and only the D/A clips. */
static int32_t limit_current(const struct mc_param *par, struct servo_memory *s, int64_t i) {
  int64_t size = i < 0 ? sat_sub(0, i) : i;
  int32_t limit = par->ilimax == 0 ? servo_clip_limit(par) : SERVO_DAC_MAX;
  if (par->ilimax == 0 || size <= par->ilim) {
    s->over = 0;
  } else if (s->over >= par->ilimax) {
    s->events |= MERR_ILIM;
    s->over = 0;
  } else {
    s->over++;
  }
  s->clipped = size > limit;
  return size <= limit ? (int32_t)i : i < 0 ? -limit : limit;
}

int32_t servo_step(const struct mc_param *par, struct servo_memory *s, int32_t setpoint,
                   struct mc_state *m) {
  int mode = par->mode & MD_MASK;
  int32_t current = 0;
  servo_sense(par, s, m);
  if ((par->mode & POSCHK) != 0) s->events = servo_check_position(par, s, m->fbnow);
  if (mode >= MD_POS && mode <= MD_TEST1) {
    int32_t demand = (par->mode & ADDMD) != 0 ? m->adcvai : setpoint;                 /* S1 */
    int32_t fed = (par->mode & ZEROFB) != 0 ? 0 : mode == MD_VEL ? m->vel : m->fbnow; /* S5 */
    m->error = sat32((int64_t)demand - fed);
    int64_t u = mode == MD_TORQ    ? demand /* S2 */
                : mode == MD_TEST1 ? servo_triangle(par, s)
                                   : compensate(par, s, m->error);
    if ((par->mode & COULCOMP) != 0) u = overcome_friction(par, m->vel, u);
    if ((par->mode & ADOFF) != 0) u = sat_add(u, m->adcvai);
    current = limit_current(par, s, u);
  }
  m->inow = servo_inow(par, s, current);
  return current;
}
