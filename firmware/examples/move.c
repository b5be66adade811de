/* SPDX-License-Identifier: Apache-2.0 */
/*
 * All joints of a robot at once, with the motion library. Where are they? Potentiometers know the
 * turn of the motor, indexes the place in it. Then there and back on polynomials of fifth order;
 * and how far they were off.
 *
 *	mmcs exec --robot puma560 > robot.h
 *	cc $(mmcs exec --cflags --modern) move.c -o move -lm
 *	mmcs exec --lockstep --scenario puma560 -- ./move
 */
#include <motion.h>
#include <stdio.h>
#include <stdlib.h>

#include "robot.h"

static struct motion m;

/* Plays the buffer to its end; the farthest that each joint was off its demand, counts. */
static void play(const char *name) {
  struct mc_state state[ROBOT_AXES];
  int most[ROBOT_AXES] = {0}, goes_on;
  double began = motion_time(&m);
  do {
    motion_check(goes_on = motion_step(&m), "step");
    motion_check((int)read(m.fd, state, sizeof state), "read");
    for (int i = 0; i < m.axes; i++)
      if (abs(state[i].error) > most[i]) most[i] = abs(state[i].error);
  } while (goes_on);
  printf("%s: %.3f s;", name, motion_time(&m) - began);
  for (int i = 0; i < m.axes; i++) printf(" %s %d", robot[i].name, most[i]);
  printf(" counts off\n");
}

int main(void) {
  double to[ROBOT_AXES], back[ROBOT_AXES];
  motion_check(motion_open(&m, robot, ROBOT_AXES, ROBOT_INTERVAL_US), "/dev/mc0");
  motion_check(motion_enable(&m), "MENABLE");
  motion_check(motion_home(&m, 0.25), "home");
  for (int i = 0; i < m.axes; i++) {
    printf("%s is at %.4f rad, 0 rad is count %d\n", robot[i].name, m.rest.position[i], m.zero[i]);
    back[i] = m.rest.position[i];
    to[i] = back[i] + 1.0 / (2 + i); /* rad */
  }
  motion_check(motion_quintic(&m, to, 0.2), "there");
  play("there");
  motion_check(motion_quintic(&m, back, 0.2), "back");
  play("back");
  motion_check(motion_close(&m), "close");
  return 0;
}
