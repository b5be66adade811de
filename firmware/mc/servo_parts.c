/* SPDX-License-Identifier: Apache-2.0 */
/* What stands around the servo law: limits, the reported current, a change of parameters. §2.2 */
#include "servo.h"
#include "servo_math.h"

int32_t servo_extend(int32_t position, uint16_t from, uint16_t to) {
  int16_t moved = (int16_t)(uint16_t)(to - from);
  return (int32_t)((uint32_t)position + (uint32_t)moved);
}

uint8_t servo_check_position(const struct mc_param *par, struct servo_memory *s, int32_t fb) {
  uint8_t outside = 0;
  if (fb < par->plo) outside |= MERR_PLO;
  if (fb > par->phi) outside |= MERR_PHI;
  uint8_t crossed = (uint8_t)(outside & ~s->outside);
  s->outside = outside;
  return crossed;
}

int32_t servo_clip_limit(const struct mc_param *par) {
  if (par->ilim < 0) return 0;
  return par->ilim < SERVO_DAC_MAX ? par->ilim : SERVO_DAC_MAX;
}

int32_t servo_triangle(const struct mc_param *par, struct servo_memory *s) {
  int32_t limit = servo_clip_limit(par);
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

/* inow = p/F * inow + (F - p) * i is inow * F through a unity-gain pole at p/F. With F = 1024 no
 * product leaves 32 bits: 1023 * 1024 * 2048 < 2^31. */
int32_t servo_inow(const struct mc_param *par, struct servo_memory *s, int32_t current) {
  int32_t pole = par->ipole;
  if (pole == 0) {
    s->filtered = current * MC_FSCALE;
    return current;
  }
  s->filtered = pole * s->filtered / MC_FSCALE + (int16_t)(MC_FSCALE - pole) * (int16_t)current;
  return s->filtered;
}

void servo_reset(struct servo_memory *s) {
  *s = (struct servo_memory){0};
}

int32_t servo_shifted(int32_t y, int64_t by) {
  return sat32(y + by);
}

void servo_shift(struct servo_memory *s, int64_t by) {
  s->y1 = servo_shifted(s->y1, by);
  s->y2 = servo_shifted(s->y2, by);
  s->narrow = 0;
}

/* N = b0*u: another b0 with the same u. */
static int64_t rescale(int64_t n, int32_t from, int32_t to) {
  int32_t remainder;
  return sat_mul(divide(n, from, &remainder), to);
}

void servo_change(struct servo_memory *s, const struct mc_param *from, const struct mc_param *to) {
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
  s->narrow = 0;
}
