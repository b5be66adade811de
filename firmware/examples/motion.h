/* SPDX-License-Identifier: Apache-2.0 */
/* Motions of several joints in rad and A, for programs that use /dev/mc0 (docs/use/device.md).
 *
 * A motion is a buffer of timed knots; between two of them every joint follows the polynomial of
 * fifth order that has their positions, velocities and accelerations. motion_step() waits for the
 * next servo sample and writes the setpoints of the one behind it, with feedforward. Angles are
 * those of the joint (metres of a linear one), times seconds since motion_open(). Functions give 0,
 * or -1 and errno. The table of the joints comes from the robot file:
 *
 *     mmcs exec --robot puma560 > puma560.h
 */
#ifndef MOTION_H
#define MOTION_H

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mcdef.h>
#include <sys/mmcs.h>
#include <unistd.h>

#define MOTION_AXES 32
#define MOTION_KNOTS 64

/* A joint, as its robot file describes it. */
struct motion_axis {
  const char *name;
  double counts;              /* per rad, signed as the gear */
  double per_ampere;          /* D/A units */
  double inertia, friction;   /* A per rad/s^2 and per rad/s */
  double speed, acceleration; /* rad/s, rad/s^2: the most that motions here ask for */
  double low, high;           /* stops; equal: none */
  int turn;                   /* counts from index to index; 0: no index */
  double mark;                /* counts that the disc is turned against the shaft */
  double pot, pot_zero;       /* rad per A/D unit; A/D value at 0 rad; pot 0: none */
  struct mc_param param;
};

struct motion_point {
  double position[MOTION_AXES], velocity[MOTION_AXES], acceleration[MOTION_AXES];
  double current[MOTION_AXES]; /* A, beside what the servo asks for; held until the next knot */
};

struct motion_knot {
  double time;
  struct motion_point at;
};

struct motion {
  int fd, axes;
  double interval; /* s between servo samples */
  const struct motion_axis *axis;
  int zero[MOTION_AXES];    /* the count at 0 rad */
  unsigned begin, sample;   /* number of the sample at time 0; of the last one */
  unsigned late;            /* samples that came while the program was busy */
  struct motion_point rest; /* before the first knot and behind the last */
  double drive[MOTION_AXES], ahead[MOTION_AXES]; /* of the last setpoints: D/A units, counts */
  unsigned first, used;
  struct motion_knot knot[MOTION_KNOTS];
};

/* --- units --------------------------------------------------------------------------- */

static inline double motion_position(const struct motion *m, int axis, int count) {
  return (count - m->zero[axis]) / m->axis[axis].counts;
}

/* Of the next sample, with feedforward: velocity, acceleration and `current` ask for a drive u; the
 * compensator b0 u + b1 u' = a0 e + a1 e' gives it for a setpoint that is e ahead. */
static inline int motion_setpoint(struct motion *m, int axis, const struct motion_point *p) {
  const struct motion_axis *x = &m->axis[axis];
  const struct mc_param *c = &x->param;
  double ampere =
      p->current[axis] + x->inertia * p->acceleration[axis] + x->friction * p->velocity[axis];
  double u = x->per_ampere * ampere, e = 0;
  if (abs(c->a1) < abs(c->a0))
    e = (c->b0 * u + c->b1 * m->drive[axis] - c->a1 * m->ahead[axis]) / c->a0;
  m->drive[axis] = u;
  m->ahead[axis] = e;
  return (int)floor(m->zero[axis] + x->counts * p->position[axis] + e + 0.5);
}

/* -1, and why. */
static inline int motion_refuse(int why) {
  errno = why;
  return -1;
}

/* Ends the program if a call has failed, and says which. */
static inline void motion_check(int result, const char *what) {
  if (result >= 0) return;
  perror(what);
  exit(1);
}

/* --- the device ------------------------------------------------------------------------ */

/* The next servo sample. */
static inline int motion_wait(struct motion *m) {
  unsigned now;
  if (ioctl(m->fd, MWAIT, &now) < 0) return -1;
  if (m->sample != 0) m->late += now - m->sample - 1;
  m->sample = now;
  return 0;
}

/* Where the joints are is where they rest. */
static inline int motion_rest(struct motion *m) {
  struct mc_state state[MOTION_AXES];
  if (read(m->fd, state, sizeof state[0] * (size_t)m->axes) < 0) return -1;
  memset(&m->rest, 0, sizeof m->rest);
  memset(m->drive, 0, sizeof m->drive);
  memset(m->ahead, 0, sizeof m->ahead);
  for (int i = 0; i < m->axes; i++) m->rest.position[i] = motion_position(m, i, state[i].encnow);
  m->used = 0;
  return 0;
}

/* Opens the device and gives it the table's parameters. Time 0 is the next servo sample. Who has no
 * handler of SIGUSR1 ignores it from now on: errors end motion_step(), too. */
static inline int motion_open(struct motion *m, const struct motion_axis *axis, int axes,
                              unsigned interval_us) {
  struct sigaction told;
  memset(m, 0, sizeof *m);
  if (sigaction(SIGUSR1, NULL, &told) == 0 && told.sa_handler == SIG_DFL)
    (void)signal(SIGUSR1, SIG_IGN);
  m->axis = axis;
  m->axes = axes;
  m->fd = open("/dev/mc0", O_RDWR);
  if (m->fd < 0 || ioctl(m->fd, MSETNUMJOINTS, &axes) < 0 ||
      ioctl(m->fd, MSETINTERVAL, &interval_us) < 0 || ioctl(m->fd, MGETINTERVAL, &interval_us) < 0)
    return -1;
  m->interval = interval_us * 1e-6;
  for (int i = 0; i < axes; i++) {
    struct mc_param param = axis[i].param;
    param.which = i;
    if (ioctl(m->fd, MSETPARAM, &param) < 0) return -1;
  }
  if (motion_wait(m) < 0) return -1;
  m->begin = m->sample;
  return motion_rest(m);
}

static inline int motion_enable(struct motion *m) {
  if (ioctl(m->fd, MENABLE) < 0) return -1;
  m->sample = 0; /* those of meanwhile are not late */
  return motion_wait(m) < 0 ? -1 : motion_rest(m);
}

static inline int motion_close(struct motion *m) {
  int result = ioctl(m->fd, MSTOP);
  return close(m->fd) < 0 ? -1 : result;
}

/* --- the buffer ------------------------------------------------------------------------ */

/* The time that the next setpoints are for. */
static inline double motion_time(const struct motion *m) {
  return (m->sample + 1 - m->begin) * m->interval;
}

static inline struct motion_knot *motion_knot(struct motion *m, unsigned n) {
  return &m->knot[(m->first + n) % MOTION_KNOTS];
}

/* Another knot behind those there are. EINVAL: it is earlier, or no number; EAGAIN: no room yet. */
static inline int motion_put(struct motion *m, double time, const struct motion_point *point) {
  double least = m->used > 0 ? motion_knot(m, m->used - 1)->time : motion_time(m);
  if (m->used == MOTION_KNOTS) return motion_refuse(EAGAIN);
  if (!(time >= least && isfinite(time))) return motion_refuse(EINVAL);
  for (int i = 0; i < m->axes; i++)
    if (!isfinite(point->position[i] + point->velocity[i] + point->acceleration[i] +
                  point->current[i]))
      return motion_refuse(EINVAL);
  motion_knot(m, m->used)->time = time;
  motion_knot(m, m->used++)->at = *point;
  return 0;
}

static inline void motion_between(const struct motion_knot *from, const struct motion_knot *to,
                                  int axis, double time, struct motion_point *out) {
  const struct motion_point *p = &from->at, *q = &to->at;
  double h = to->time - from->time, s = time - from->time;
  double v = p->velocity[axis], a = p->acceleration[axis];
  double d = q->position[axis] - p->position[axis] - v * h - a * h * h / 2;
  double dv = (q->velocity[axis] - v - a * h) * h, da = (q->acceleration[axis] - a) * h * h;
  double c3 = (10 * d - 4 * dv + da / 2) / (h * h * h);
  double c4 = (-15 * d + 7 * dv - da) / (h * h * h * h);
  double c5 = (6 * d - 3 * dv + da / 2) / (h * h * h * h * h);
  out->position[axis] = p->position[axis] + s * (v + s * (a / 2 + s * (c3 + s * (c4 + s * c5))));
  out->velocity[axis] = v + s * (a + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)));
  out->acceleration[axis] = a + s * (6 * c3 + s * (12 * c4 + s * 20 * c5));
  out->current[axis] = p->current[axis];
}

/* What the buffer asks for at a time, which is never earlier than that of the call before; knots
 * that are behind are forgotten. 1 until the last one has been reached. */
static inline int motion_at(struct motion *m, double time, struct motion_point *out) {
  while (m->used > 1 && motion_knot(m, 1)->time <= time) {
    m->first = (m->first + 1) % MOTION_KNOTS;
    m->used--;
  }
  if (m->used == 1 && motion_knot(m, 0)->time <= time) {
    m->rest = motion_knot(m, 0)->at;
    m->used = 0;
  }
  *out = m->rest;
  if (m->used == 0) return 0;
  if (motion_knot(m, 0)->time <= time)
    for (int i = 0; i < m->axes; i++)
      motion_between(motion_knot(m, 0), motion_knot(m, 1), i, time, out);
  return 1;
}

/* Waits for the next sample and writes the setpoints of the one behind it. 1: the motion goes on,
 * 0: it has ended. ETIME: it ended at a velocity, which the joints cannot keep. */
static inline int motion_step(struct motion *m) {
  struct motion_point point;
  int setpoint[MOTION_AXES], goes_on;
  if (motion_wait(m) < 0) return -1;
  goes_on = motion_at(m, motion_time(m), &point);
  for (int i = 0; i < m->axes; i++) {
    if (!goes_on && fabs(point.velocity[i] * m->axis[i].counts * m->interval) >= 0.5)
      return motion_refuse(ETIME);
    setpoint[i] = motion_setpoint(m, i, &point);
  }
  if (write(m->fd, setpoint, sizeof setpoint[0] * (size_t)m->axes) < 0) return -1;
  return goes_on;
}

/* --- a profile ----------------------------------------------------------------------------- */

/* From rest to rest on one polynomial of fifth order, behind what is in the buffer: all joints
 * begin and end together, each within `share` of its limits. */
static inline int motion_quintic(struct motion *m, const double *to, double share) {
  const struct motion_knot *last = m->used > 0 ? motion_knot(m, m->used - 1) : NULL;
  struct motion_point point = last != NULL ? last->at : m->rest;
  double begin = last != NULL ? last->time : motion_time(m), speed = INFINITY, rise = INFINITY;
  for (int i = 0; i < m->axes; i++) {
    double way = fabs(to[i] - point.position[i]);
    if (!isfinite(way) || !(share > 0)) return motion_refuse(EINVAL);
    speed = fmin(speed, share * m->axis[i].speed / way);
    rise = fmin(rise, share * m->axis[i].acceleration / way);
    point.velocity[i] = point.acceleration[i] = 0;
  }
  if (isinf(speed)) return 0; /* there already */
  if (MOTION_KNOTS - m->used < 2) return motion_refuse(EAGAIN);
  if (motion_put(m, begin, &point) < 0) return -1;
  memcpy(point.position, to, sizeof to[0] * (size_t)m->axes);
  double takes = fmax(1.875 / speed, sqrt(5.773502691896258 / rise)); /* 15/8; 10/sqrt(3) */
  return motion_put(m, begin + takes, &point);
}

/* --- where the joints are ---------------------------------------------------------------- */

/* The count at 0 rad, by the potentiometer, which knows the turn, and the count at the index, which
 * knows the place in it. */
static inline int motion_zero(const struct motion_axis *x, int adc, int encoder, int index) {
  double rough = (adc - x->pot_zero) * x->pot * x->counts - encoder;
  double turns = floor((rough + x->mark + index) / x->turn + 0.5);
  return (int)floor(x->mark + 0.5) - ((int)turns * x->turn - index);
}

/* Takes the indexes that have come. How many joints still wait for theirs. */
static inline int motion_index(struct motion *m, const struct mc_state *before, char *waits,
                               int *zero) {
  struct mc_state state[MOTION_AXES];
  int left = 0, found = 0;
  if (read(m->fd, state, sizeof state[0] * (size_t)m->axes) < 0) return -1;
  for (int i = 0; i < m->axes; i++) {
    int code = state[i].errcode, index = state[i].encnow;
    if (waits[i] && (code & MERR_ZINDEX) != 0) {
      index += (short)(((unsigned)code >> 16) - (unsigned)index); /* 16 bits, near where it is */
      zero[i] = motion_zero(&m->axis[i], before[i].adcvai, before[i].encnow, index);
      waits[i] = 0;
      found = 1;
    }
    left += waits[i];
  }
  return found && ioctl(m->fd, MCLEARERROR) < 0 ? -1 : left;
}

/* Finds out where all joints are: each turns its motor once and a quarter, away from the nearer
 * stop, and looks for its index. From then on angles are those of the robot file. ENODEV: a joint
 * has no index or no potentiometer, or its index did not come. */
static inline int motion_home(struct motion *m, double share) {
  struct mc_state before[MOTION_AXES];
  double to[MOTION_AXES];
  char waits[MOTION_AXES];
  int zero[MOTION_AXES], left = m->axes, goes_on = 1;
  for (int i = 0; i < 3; i++)
    if (motion_step(m) < 0) return -1; /* the A/D values are those of the potentiometers now */
  if (read(m->fd, before, sizeof before[0] * (size_t)m->axes) < 0) return -1;
  memcpy(zero, m->zero, sizeof zero);
  for (int i = 0; i < m->axes; i++) {
    const struct motion_axis *x = &m->axis[i];
    double at = (before[i].adcvai - x->pot_zero) * x->pot;
    if (x->turn == 0 || x->pot == 0) return motion_refuse(ENODEV);
    to[i] = m->rest.position[i] +
            (at > (x->low + x->high) / 2 ? -1.25 : 1.25) * fabs(x->turn / x->counts);
    waits[i] = 1;
    if (ioctl(m->fd, MCALIB, &i) < 0) return -1;
  }
  if (motion_quintic(m, to, share) < 0) return -1;
  while (goes_on > 0 && left >= 0) {
    goes_on = motion_step(m);
    if (goes_on >= 0) left = motion_index(m, before, waits, zero);
  }
  for (int i = 0; i < m->axes; i++)
    if (waits[i]) (void)ioctl(m->fd, MCALIBEND, &i);
  if (goes_on < 0 || left < 0) return -1;
  memcpy(m->zero, zero, sizeof zero);
  if (motion_rest(m) < 0) return -1;
  return left > 0 ? motion_refuse(ENODEV) : 0;
}

#endif
