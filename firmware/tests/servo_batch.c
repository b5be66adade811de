/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the servo law over arrays of inputs, for the comparison with servo_reference.py. */
#include "servo.h"

#include <stddef.h>

struct axis {
  struct mc_param par;
  struct servo_state servo;
  int32_t position;
  uint16_t counter;
};

size_t axis_size(void);
void axis_start(struct axis *x, const struct mc_param *par, uint16_t counter);
void axis_change(struct axis *x, const struct mc_param *par);
int axis_wide(const struct axis *x);
void axis_run(struct axis *x, int n, const int32_t (*in)[3], int32_t (*out)[9]);

size_t axis_size(void) {
  return sizeof(struct axis);
}

void axis_start(struct axis *x, const struct mc_param *par, uint16_t counter) {
  x->par = *par;
  x->counter = counter;
  x->position = (int16_t)counter;
  servo_reset(&x->servo);
  servo_prepare(&x->servo, par);
}

void axis_change(struct axis *x, const struct mc_param *par) {
  servo_change(&x->servo, &x->par, par);
  x->par = *par;
}

/* Whether the next sample begins in 64 bits. */
int axis_wide(const struct axis *x) {
  return x->servo.wide;
}

/* Columns: counter, raw A/D, setpoint -> position, phi, fb, vel, error, current, inow, events,
 * clipped. */
void axis_run(struct axis *x, int n, const int32_t (*in)[3], int32_t (*out)[9]) {
  for (int i = 0; i < n; i++) {
    uint16_t counter = (uint16_t)in[i][0];
    struct mc_state m = {0};
    x->position = servo_extend(x->position, x->counter, counter);
    x->counter = counter;
    m.encnow = x->position;
    m.adcvai = servo_phi(&x->par, &x->servo, (uint16_t)in[i][1]);
    int32_t current = servo_step(&x->par, &x->servo, in[i][2], &m);
    const int32_t row[9] = {m.encnow, m.adcvai, m.fbnow,         m.vel,           m.error,
                            current,  m.inow,   x->servo.events, x->servo.clipped};
    for (int k = 0; k < 9; k++) out[i][k] = row[k];
  }
}
