/* SPDX-License-Identifier: Apache-2.0 */
/* The servo law: see servo.h. §2.1-§2.2. */
#include "servo.h"

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
  if (n >= INT32_MIN && n <= INT32_MAX) {
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

int32_t servo_phi(const struct mc_param *par, int32_t raw) {
  return sat32((int64_t)par->adc_a * raw + par->adc_b);
}

int32_t servo_feedback(const struct mc_param *par, const struct servo_input *in) {
  return (par->mode & ADFB) != 0 ? servo_phi(par, in->raw) : in->position;
}

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
}

/* b * N / b0 without losing what N / b0 truncates: b*(N/b0) + b*(N mod b0)/b0. */
static int64_t feedback_term(int32_t b, int64_t n, int32_t b0) {
  int32_t remainder;
  if (b == 0 || n == 0) return 0;
  int64_t whole = sat_mul(b, divide(n, b0, &remainder));
  return sat_add(whole, (int64_t)b * remainder / b0);
}

/* D(z) = (a0 + a1/z + a2/z^2) / (b0 + b1/z + b2/z^2): from
 * b0*u + b1*u1 + b2*u2 = a0*e + a1*e1 + a2*e2 follows, with N = b0*u kept un-truncated,
 * N = a0*e + a1*e1 + a2*e2 - b1*N1/b0 - b2*N2/b0 and u = N/b0. */
static int64_t compensate(const struct mc_param *par, struct servo_state *s, int32_t e) {
  int32_t remainder;
  int64_t n = sat_add((int64_t)par->a0 * e, (int64_t)par->a1 * s->e1);
  n = sat_add(n, (int64_t)par->a2 * s->e2);
  n = sat_sub(n, feedback_term(par->b1, s->n1, par->b0));
  n = sat_sub(n, feedback_term(par->b2, s->n2, par->b0));
  s->e2 = s->e1;
  s->e1 = e;
  s->n2 = s->n1;
  s->n1 = n;
  return divide(n, par->b0, &remainder);
}

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

/* Coulomb feedforward. At rest the demand tells where the axis is about to go; on an axis whose
 * encoder runs against the torque (ic_pos < 0) that is the other way. */
static int64_t friction(const struct mc_param *par, int32_t vel, int64_t u) {
  int direction = (vel > 0) - (vel < 0);
  if (direction == 0) {
    direction = (u > 0) - (u < 0);
    if (par->ic_pos < 0) direction = -direction;
  }
  if (direction > 0) return par->ic_pos;
  if (direction < 0) return -(int64_t)par->ic_neg;
  return 0;
}

static int32_t limit_current(const struct mc_param *par, struct servo_state *s, int64_t i,
                             struct servo_output *out) {
  int32_t limit = par->ilimax == 0 ? clip_limit(par->ilim) : SERVO_DAC_MAX;
  if (par->ilimax != 0 && (i > par->ilim || i < -(int64_t)par->ilim)) {
    if (s->over < INT32_MAX) s->over++;
    if (s->over > par->ilimax) {
      out->events |= MERR_ILIM;
      s->over = 0;
    }
  } else {
    s->over = 0;
  }
  if (i <= limit && i >= -limit) return (int32_t)i;
  out->clipped = 1;
  return i > 0 ? limit : -limit;
}

/* Limits raise an event when they are crossed, not while the axis stays beyond them. */
static void check_position(const struct mc_param *par, struct servo_state *s,
                           struct servo_output *out) {
  uint8_t outside = 0;
  if ((par->mode & POSCHK) == 0) return;
  if (out->fb < par->plo) outside |= MERR_PLO;
  if (out->fb > par->phi) outside |= MERR_PHI;
  out->events |= (uint8_t)(outside & ~s->outside);
  s->outside = outside;
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

/* vel = (3y - 4y1 + y2) / 2, truncated toward zero. */
void servo_sense(const struct mc_param *par, struct servo_state *s, const struct servo_input *in,
                 struct servo_output *out) {
  int32_t y = servo_feedback(par, in);
  if (!s->primed) {
    s->y1 = s->y2 = y;
    s->primed = 1;
  }
  out->phi = servo_phi(par, in->raw);
  out->fb = y;
  out->vel = sat32((3 * (int64_t)y - 4 * (int64_t)s->y1 + s->y2) / 2);
  out->error = 0;
  out->current = 0;
  out->inow = 0;
  out->events = 0;
  out->clipped = 0;
  s->y2 = s->y1;
  s->y1 = y;
}

void servo_step(const struct mc_param *par, struct servo_state *s, const struct servo_input *in,
                struct servo_output *out) {
  int mode = par->mode & MD_MASK;
  servo_sense(par, s, in, out);
  check_position(par, s, out);
  if (mode < MD_POS || mode > MD_TEST1) {
    out->inow = servo_inow(par, s, 0);
    return;
  }
  int32_t fed = (par->mode & ZEROFB) != 0 ? 0 : mode == MD_VEL ? out->vel : out->fb;
  int32_t demand = (par->mode & ADDMD) != 0 ? out->phi : in->setpoint;
  out->error = sat32((int64_t)demand - fed);
  int64_t u;
  if (mode == MD_TORQ) {
    u = demand;
  } else if (mode == MD_TEST1) {
    u = triangle(par, s);
  } else {
    u = compensate(par, s, out->error);
  }
  if ((par->mode & COULCOMP) != 0) u = sat_add(u, friction(par, out->vel, u));
  if ((par->mode & ADOFF) != 0) u = sat_add(u, out->phi);
  out->current = limit_current(par, s, u, out);
  out->inow = servo_inow(par, s, out->current);
}
