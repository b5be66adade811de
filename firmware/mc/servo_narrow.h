/* SPDX-License-Identifier: Apache-2.0 */
/* The servo law of servo.h in 32 bits, for processors to which 64 are slow. §1.3.1
 *
 * The same bits as servo_step(), which serves what 32 bits do not hold. A port that defines
 * SERVO_NARROW takes it. */
#ifndef SERVO_NARROW_H
#define SERVO_NARROW_H

#include "servo.h"

/* What a set of parameters asks for. */
enum servo_kind {
  SERVO_PD,         /* a2 = b1 = b2 = 0, b0 a power of two */
  SERVO_FILTER,     /* PD with a derivative filter: a2 = b2 = 0, -b0 < b1 < 0, b0 to 1024 */
  SERVO_SUM,        /* b1 = b2 = 0 */
  SERVO_INTEGRATOR, /* b1 = -b0, b2 = 0 */
  SERVO_RECURSION,  /* any others */
  SERVO_TORQUE,     /* MD_TORQ, MD_TEST1, MD_OFF: no compensator */
  SERVO_TRIANGLE,
  SERVO_OFF
};

/* What phi asks for. */
enum servo_phi {
  SERVO_PHI_WIDE,   /* 64 bits */
  SERVO_PHI_OFFSET, /* adc_a = 1: a sum */
  SERVO_PHI_LINE
};

/* What servo_prepare() works out. All zero: nothing is known, all samples are in 64 bits. */
struct servo_prepared {
  uint8_t kind;  /* enum servo_kind */
  uint8_t phi;   /* enum servo_phi */
  int32_t shift; /* b0 is 2 to this, or 32 */
  uint32_t top;  /* 32 bits are enough for errors of -top..top-1 */
  int32_t limit; /* largest current */
};

/* After every change of parameters, and of the memory by servo_change() or servo_reset(). */
void servo_prepare(struct servo_prepared *p, const struct mc_param *par);

/* As servo_phi() and servo_step(). */
int32_t servo_narrow_phi(const struct mc_param *par, const struct servo_prepared *p, uint16_t raw);
int32_t servo_narrow_step(const struct mc_param *par, const struct servo_prepared *p,
                          struct servo_memory *s, int32_t setpoint, struct mc_state *m);

/* What the driver calls. */
#ifdef SERVO_NARROW
#define SERVO_PHI(par, p, raw) servo_narrow_phi(par, p, raw)
#define SERVO_STEP(par, p, s, setpoint, m) servo_narrow_step(par, p, s, setpoint, m)
#else
#define SERVO_PHI(par, p, raw) servo_phi(par, raw)
#define SERVO_STEP(par, p, s, setpoint, m) servo_step(par, s, setpoint, m)
#endif

#endif
