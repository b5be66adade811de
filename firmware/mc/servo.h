/* SPDX-License-Identifier: Apache-2.0 */
/* The servo law of one axis, §2.1-§2.2: parameters + memory + inputs -> outputs.
 *
 * Pure integer arithmetic: no hardware, no time, no floating point, no undefined overflow. The
 * same inputs give the same bits on every machine. */
#ifndef SERVO_H
#define SERVO_H

#include <stdint.h>

#include "mcdef.h"

#define SERVO_DAC_MAX 2047 /* largest current either way, D/A units */

/* What the law remembers between samples. All zero: at rest, wherever the axis then is. */
struct servo_memory {
  int64_t n1, n2;   /* un-truncated numerators N = b0*u of the last two samples */
  int32_t y1, y2;   /* feedback quantity (S4) of the last two samples */
  int32_t e1, e2;   /* errors of the last two samples */
  int32_t filtered; /* current through the ipole filter, times MC_FSCALE */
  int32_t over;     /* consecutive samples above ilim */
  int32_t triangle; /* MD_TEST1: the next value */
  uint8_t falling;  /* MD_TEST1: on the way down */
  uint8_t primed;   /* y1, y2 hold samples */
  uint8_t outside;  /* limits that the feedback was beyond at the last check: MERR_PLO, MERR_PHI */
  uint8_t narrow;   /* servo_narrow.c has found all of this within its bounds */
  /* of the last sample: */
  uint8_t events;  /* MERR_PLO, MERR_PHI, MERR_ILIM that happened */
  uint8_t clipped; /* the current met a limit */
};

/* A 32-bit position followed over a 16-bit counter: right while the axis moves less than 32768
 * counts between two samples. */
int32_t servo_extend(int32_t position, uint16_t from, uint16_t to);

/* The processed A/D value: adc_a * raw + adc_b, saturated; raw is offset binary, 0-4095. */
int32_t servo_phi(const struct mc_param *par, uint16_t raw);

/* The feedback quantity (S4). */
int32_t servo_feedback(const struct mc_param *par, const struct mc_state *m);

/* Forgets all history; the next sample starts at rest wherever the axis then is. */
void servo_reset(struct servo_memory *s);

/* The feedback is counted from another place, `by` units away: velocity and error go on. The same
 * of one position: */
void servo_shift(struct servo_memory *s, int64_t by);
int32_t servo_shifted(int32_t y, int64_t by);

/* Adapts the memory to a change of parameters: histories restart when the mode or the source of the
 * feedback changes, and keep the output where it is when only coefficients do. */
void servo_change(struct servo_memory *s, const struct mc_param *from, const struct mc_param *to);

/* Of `m`, encnow and adcvai are what was measured; fbnow, vel, error and inow are found. Only
 * sensed: no current, for an axis that is not servoed. */
void servo_sense(const struct mc_param *par, struct servo_memory *s, struct mc_state *m);

/* One whole servo sample: the current, -2047..2047 D/A units. s->events and s->clipped tell what
 * happened. With MD_OFF the current is 0 and only limits are checked. */
int32_t servo_step(const struct mc_param *par, struct servo_memory *s, int32_t setpoint,
                   struct mc_state *m);

/* Parts of a step. The reported current after `current` D/A units were commanded (SRV-5): */
int32_t servo_inow(const struct mc_param *par, struct servo_memory *s, int32_t current);
/* the limits that are crossed, not while the axis stays beyond them: */
uint8_t servo_check_position(const struct mc_param *par, struct servo_memory *s, int32_t fb);
/* MD_TEST1: 0, 1, ... ilim, ilim-1, ... -ilim, ... one D/A unit per sample: */
int32_t servo_triangle(const struct mc_param *par, struct servo_memory *s);
/* the largest current without ilimax. */
int32_t servo_clip_limit(const struct mc_param *par);

#endif
