/* SPDX-License-Identifier: Apache-2.0 */
/* The motion of sim/scenarios/puma560 as a program: six axes, which reads the states and writes the
 * setpoints of every sample. What lock-step costs beside the same motion as a scenario. */
#include <motion.h>
#include <stdio.h>

#include "robot.h"

int main(int ac, char **av) {
  static const int to[] = {5000, 6000, 4000, 6000, 5000, 6000};
  static struct motion m;
  struct mc_state state[ROBOT_AXES];
  int setpoint[ROBOT_AXES];
  if (motion_open(&m, robot, ROBOT_AXES, 1000) < 0 || motion_enable(&m) < 0)
    return perror("open"), 1;
  for (int n = 0; n < atoi(ac > 1 ? av[1] : "1400"); n++) {
    double s = fmin(fmax(n - 50, 0) / 800.0, 1), share = s * s * s * (10 + s * (6 * s - 15));
    if (motion_wait(&m) < 0 || read(m.fd, state, sizeof state) < 0) return perror("sample"), 1;
    for (int i = 0; i < ROBOT_AXES; i++)
      setpoint[i] = (int)lround(to[i] * share) + (n >= 1000 ? 200 : 0);
    if (write(m.fd, setpoint, sizeof setpoint) < 0) return perror("write"), 1;
  }
  return motion_close(&m) < 0;
}
