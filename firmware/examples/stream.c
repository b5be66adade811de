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

static void check(int result, const char *what) {
  if (result >= 0) return;
  perror(what);
  exit(1);
}

/* Of a circle that begins at rest: the phase goes from 0 to whole turns with 1 - cos. */
static struct motion_point circle(const struct motion_point *rest, double t) {
  struct motion_point p = *rest;
  double long_s = TURNS * TURN_S, w = 3.141592653589793 / long_s, all = TURNS * 3.141592653589793;
  double phase = all * (1 - cos(w * t)), rate = all * w * sin(w * t);
  double rise = all * w * w * cos(w * t);
  for (int i = 0; i < m.axes; i++) {
    double c = i % 2 ? sin(phase) : 1 - cos(phase), d = i % 2 ? cos(phase) : sin(phase);
    double e = i % 2 ? -sin(phase) : cos(phase);
    p.position[i] += RAD * c;
    p.velocity[i] = RAD * d * rate;
    p.acceleration[i] = RAD * (e * rate * rate + d * rise);
  }
  return p;
}

int main(void) {
  int knots = (int)(TURNS * TURN_S / EVERY_S + 0.5), next = 0, goes_on = 1;
  double begin;
  check(motion_open(&m, robot, ROBOT_AXES, ROBOT_INTERVAL_US), "/dev/mc0");
  check(motion_enable(&m), "MENABLE");
  struct motion_point rest = m.rest;
  begin = motion_time(&m);
  while (goes_on) {
    struct mc_state state[ROBOT_AXES];
    while (next <= knots && m.used < 4) { /* four knots ahead are enough */
      struct motion_point p = circle(&rest, EVERY_S * next);
      check(motion_put(&m, begin + EVERY_S * next++, &p), "put");
    }
    check(goes_on = motion_step(&m), "step");
    check((int)read(m.fd, state, sizeof state), "read");
    printf("%.3f", motion_time(&m) - begin);
    for (int i = 0; i < m.axes; i++) printf(",%.5f", motion_position(&m, i, state[i].encnow));
    printf("\n");
  }
  check(motion_close(&m), "close");
  return 0;
}
