/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where are the joints? Potentiometers know the turn of the motor, indexes the place in it: home of
 * all joints, with the motion library; then to 0.1 rad each.
 *
 *	mmcs exec --robot puma560 > robot.h
 *	cc $(mmcs exec --cflags --modern) home.c -o home -lm
 *	mmcs exec --lockstep --scenario puma560_calibrate -- ./home
 */
#include <motion.h>
#include <stdio.h>
#include <stdlib.h>

#include "robot.h"

static struct motion m;

static void check(int result, const char *what) {
  if (result >= 0) return;
  perror(what);
  exit(1);
}

int main(void) {
  double to[ROBOT_AXES];
  check(motion_open(&m, robot, ROBOT_AXES, ROBOT_INTERVAL_US), "/dev/mc0");
  check(motion_enable(&m), "MENABLE");
  check(motion_home(&m, 0.25), "home");
  for (int i = 0; i < m.axes; i++) {
    printf("%s is at %.4f rad, 0 rad is count %d\n", robot[i].name, m.rest.position[i], m.zero[i]);
    to[i] = m.rest.position[i] + 0.1;
  }
  check(motion_quintic(&m, to, 0.2), "quintic");
  check(motion_run(&m), "run");
  check(motion_close(&m), "close");
  return 0;
}
