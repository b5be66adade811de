/* SPDX-License-Identifier: Apache-2.0 */
/* The servo law of one axis, §2.1-§2.2: parameters + state + inputs -> outputs.
 *
 * Pure integer arithmetic: no hardware, no time, no floating point, no undefined overflow. The
 * same inputs give the same bits on every machine. */
#ifndef SERVO_H
#define SERVO_H

#include <stdint.h>

#include "mcdef.h"

#define SERVO_DAC_MAX 2047 /* largest current either way, D/A units */
#define SERVO_NO_SHIFT 32

/* What parameters ask for, as servo_prepare() tells it. */
enum servo_kind {
  SERVO_PD,         /* a2 = b1 = b2 = 0, b0 a power of two */
  SERVO_SUM,        /* b1 = b2 = 0 */
  SERVO_FILTER,     /* PD with a derivative filter: a2 = b2 = 0, -b0 < b1 < 0, b0 to 1024 */
  SERVO_INTEGRATOR, /* b1 = -b0, b2 = 0 */
  SERVO_RECURSION,  /* any others */
  SERVO_TORQUE,     /* MD_TORQ, MD_TEST1, MD_OFF: no compensator */
  SERVO_TRIANGLE,
  SERVO_OFF
};

/* What the law remembers between samples. */
struct servo_state {
  int64_t n1, n2;   /* un-truncated numerators N = b0*u of the last two samples */
  int32_t y1, y2;   /* feedback quantity (S4) of the last two samples */
  int32_t e1, e2;   /* errors of the last two samples */
  int32_t filtered; /* current through the ipole filter, times MC_FSCALE */
  int32_t over;     /* consecutive samples above ilim */
  int32_t triangle; /* MD_TEST1: the next value */
  uint8_t falling;  /* MD_TEST1: on the way down */
  uint8_t primed;   /* y1, y2 hold samples */
  uint8_t outside;  /* limits that the feedback was beyond at the last check: MERR_PLO, MERR_PHI */
  uint8_t wide;     /* the histories may be beyond 32-bit arithmetic */
  /* of the last sample: */
  uint8_t events;  /* MERR_PLO, MERR_PHI, MERR_ILIM that happened */
  uint8_t clipped; /* the current met a limit */
  /* what servo_prepare() works out: */
  uint8_t kind;       /* enum servo_kind */
  uint8_t narrow_phi; /* adc_a and adc_b need 32 bits only */
  int32_t shift;      /* b0 is 2 to this, or SERVO_NO_SHIFT */
  uint32_t top;       /* 32 bits are enough for errors of -top..top-1 */
  int32_t limit;      /* largest current */
};

/* A 32-bit position followed over a 16-bit counter: right while the axis moves less than 32768
 * counts between two samples. */
int32_t servo_extend(int32_t position, uint16_t from, uint16_t to);

/* The processed A/D value: adc_a * raw + adc_b, saturated; raw is offset binary, 0-4095. */
int32_t servo_phi(const struct mc_param *par, const struct servo_state *s, uint16_t raw);

/* The feedback quantity (S4). */
int32_t servo_feedback(const struct mc_param *par, const struct mc_state *m);

/* Works out what a set of parameters means for the samples to come. Before the first of them. */
void servo_prepare(struct servo_state *s, const struct mc_param *par);

/* Forgets all history; the next sample starts at rest wherever the axis then is. */
void servo_reset(struct servo_state *s);

/* Adapts the state to a change of parameters: histories restart when the mode or the source of the
 * feedback changes, and keep the output where it is when only coefficients do. Prepares. */
void servo_change(struct servo_state *s, const struct mc_param *from, const struct mc_param *to);

/* Of `m`, encnow and adcvai are what was measured; fbnow, vel, error and inow are found. Only
 * sensed: no current, for an axis that is not servoed. */
void servo_sense(const struct mc_param *par, struct servo_state *s, struct mc_state *m);

/* One whole servo sample: the current, -2047..2047 D/A units. s->events and s->clipped tell what
 * happened. With MD_OFF the current is 0 and only limits are checked. */
int32_t servo_step(const struct mc_param *par, struct servo_state *s, int32_t setpoint,
                   struct mc_state *m);

/* The reported current after `current` D/A units were commanded (SRV-5). */
int32_t servo_inow(const struct mc_param *par, struct servo_state *s, int32_t current);

#endif
