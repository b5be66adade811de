/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the servo law over arrays of inputs, for the comparison with servo_reference.py; and beside
 * it the law in 32 bits, which must do the same, memory included. SRV-7. */
#include "servo_narrow.h"

#include <stddef.h>
#include <string.h>

struct axis {
  struct mc_param par;
  struct servo_memory servo, twin;
  struct servo_prepared law;
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
  servo_reset(&x->twin);
  servo_prepare(&x->law, par);
}

void axis_change(struct axis *x, const struct mc_param *par) {
  servo_change(&x->servo, &x->par, par);
  servo_change(&x->twin, &x->par, par);
  servo_prepare(&x->law, par);
  x->par = *par;
}

/* Whether the next sample begins in 64 bits. */
int axis_wide(const struct axis *x) {
  return !x->twin.narrow;
}

/* 1: the memories differ in more than what servo_narrow.c knows of them. */
static int differs(const struct servo_memory *a, const struct servo_memory *b) {
  return a->n1 != b->n1 || a->n2 != b->n2 || a->y1 != b->y1 || a->y2 != b->y2 || a->e1 != b->e1 ||
         a->e2 != b->e2 || a->filtered != b->filtered || a->over != b->over ||
         a->triangle != b->triangle || a->falling != b->falling || a->primed != b->primed ||
         a->outside != b->outside || a->events != b->events || a->clipped != b->clipped;
}

/* Columns: counter, raw A/D, setpoint -> position, phi, fb, vel, error, current, inow, events,
 * clipped; where the twin does anything else, 0x7A11 as the last. */
void axis_run(struct axis *x, int n, const int32_t (*in)[3], int32_t (*out)[9]) {
  for (int i = 0; i < n; i++) {
    uint16_t counter = (uint16_t)in[i][0];
    struct mc_state m = {0};
    x->position = servo_extend(x->position, x->counter, counter);
    x->counter = counter;
    m.encnow = x->position;
    struct mc_state other = m;
    m.adcvai = servo_phi(&x->par, (uint16_t)in[i][1]);
    other.adcvai = servo_narrow_phi(&x->par, &x->law, (uint16_t)in[i][1]);
    int32_t current = servo_step(&x->par, &x->servo, in[i][2], &m);
    int32_t same = servo_narrow_step(&x->par, &x->law, &x->twin, in[i][2], &other);
    const int32_t row[9] = {m.encnow, m.adcvai, m.fbnow,         m.vel,           m.error,
                            current,  m.inow,   x->servo.events, x->servo.clipped};
    for (int k = 0; k < 9; k++) out[i][k] = row[k];
    if (current != same || memcmp(&m, &other, sizeof m) != 0 || differs(&x->servo, &x->twin)) {
      out[i][8] = 0x7A11;
    }
  }
}
