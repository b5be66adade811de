/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A path that is computed while it is driven: every 20 ms a knot with position, velocity and
 * acceleration goes into the buffer of the motion library, which makes a setpoint of every servo
 * sample, with feedforward.
 *
 *	mmcs exec --robot lab500 > robot.h
 *	cc $(mmcs exec --cflags --modern) stream.c -o stream -lm
 *	mmcs exec --lockstep --scenario lab500 -- ./stream
 */
#include <motion.h>
#include <stdio.h>
#include <stdlib.h>

#include "robot.h"

#define EVERY_S 0.02
#define TURNS 2
#define TURN_S 0.5
#define RAD 0.5

static struct motion m;

/* Swings of all joints, every other one the other way, that begin and end at standstill. */
static struct motion_point swing(const struct motion_point *rest, double t) {
  struct motion_point p = *rest;
  const double w = 6.283185307179586 / TURN_S;
  for (int i = 0; i < m.axes; i++) {
    double rad = i % 2 ? -RAD : RAD;
    p.position[i] += rad * (1 - cos(w * t));
    p.velocity[i] = rad * w * sin(w * t);
    p.acceleration[i] = rad * w * w * cos(w * t);
  }
  return p;
}

int main(void) {
  int knots = (int)(TURNS * TURN_S / EVERY_S + 0.5), next = 0, goes_on = 1;
  motion_check(motion_open(&m, robot, ROBOT_AXES, ROBOT_INTERVAL_US), "/dev/mc0");
  motion_check(motion_enable(&m), "MENABLE");
  struct motion_point rest = m.rest;
  double begin = motion_time(&m);
  while (goes_on) {
    struct mc_state state[ROBOT_AXES];
    while (next <= knots && m.used < 4) { /* four knots ahead are enough */
      struct motion_point p = swing(&rest, EVERY_S * next);
      motion_check(motion_put(&m, begin + EVERY_S * next++, &p), "put");
    }
    motion_check(goes_on = motion_step(&m), "step");
    motion_check((int)read(m.fd, state, sizeof state), "read");
    printf("%.3f", motion_time(&m) - begin);
    for (int i = 0; i < m.axes; i++) printf(",%.5f", motion_position(&m, i, state[i].encnow));
    printf("\n");
  }
  motion_check(motion_close(&m), "close");
  return 0;
}
