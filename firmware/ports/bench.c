/* SPDX-License-Identifier: Apache-2.0 */
/* The servo arithmetic of six axes alone, to be timed and to be compared between processors. §5.
 *
 * The caller puts profile and ticks into the parameter block and starts the image; each tick is
 * six times servo_phi() and servo_step(), which lie between the two writes to MARK, and six hash
 * updates. The same file is compiled natively for the comparison. */
#include "servo.h"

#define AXES 6

struct bench {
  uint32_t profile, ticks;
  uint32_t hash, done;
  uint32_t mark; /* 1 while the servo computes */
};

#ifdef BENCH_NATIVE
static struct bench block;
#define B (&block)
#else
#define B ((volatile struct bench *)0x1E000)
void bench_main(void);
void bench_dead(void);
#endif

static uint32_t hash;

static void mix(uint32_t word) {
  hash = (hash ^ word) * 0x01000193u;
  hash ^= hash >> 15;
}

/* Profiles add to each other: 0 P, 1 PD with limits, 2 PID with friction, filter and limits,
 * 3 velocity, 4 torque with offset from the A/D, 5 A/D feedback, second order, 6 triangle,
 * 7 open loop from the A/D with a divisor that is no power of two. */
static void choose(struct mc_param *par, uint32_t profile, int axis) {
  struct mc_param p = {0};
  p.which = axis;
  p.mode = MD_POS;
  p.a0 = 12 + axis;
  p.b0 = 8;
  p.clkdivisor = 1;
  p.ilim = 1024;
  p.plo = INT32_MIN;
  p.phi = INT32_MAX;
  p.adc_a = 1;
  if (profile >= 1) {
    p.a0 = 300 + axis;
    p.a1 = -280;
    p.b0 = 16;
    p.plo = -20000;
    p.phi = 20000;
    p.mode |= POSCHK | SOFTERR;
    p.ilimax = 50;
  }
  if (profile >= 2) {
    p.a2 = 13;
    p.b1 = -16;
    p.ic_pos = 50;
    p.ic_neg = 40;
    p.mode |= COULCOMP;
    p.ipole = 900;
    p.adc_a = 3;
    p.adc_b = -6144;
  }
  if (profile == 3) p.mode = (p.mode & ~MD_MASK) | MD_VEL;
  if (profile == 4) p.mode = (p.mode & ~MD_MASK) | MD_TORQ | ADOFF;
  if (profile == 5) {
    p.mode |= ADFB;
    p.b2 = 5;
  }
  if (profile == 6) p.mode = (p.mode & ~MD_MASK) | MD_TEST1;
  if (profile == 7) {
    p.mode |= ADDMD | ZEROFB;
    p.b0 = 19;
    p.b1 = -7;
  }
  *par = p;
}

static struct mc_param par[AXES];
static struct servo_state state[AXES];
static struct servo_input in[AXES];
static struct servo_output out[AXES];
static uint16_t raw[AXES];

static uint32_t run(uint32_t profile, uint32_t ticks, volatile uint32_t *mark) {
  uint32_t seed = 1 + profile;
  hash = 0x811C9DC5u;
  for (int axis = 0; axis < AXES; axis++) {
    choose(&par[axis], profile, axis);
    servo_reset(&state[axis]);
    servo_prepare(&state[axis], &par[axis]);
    in[axis].position = in[axis].setpoint = 0;
  }
  for (uint32_t tick = 0; tick < ticks; tick++) {
    for (int axis = 0; axis < AXES; axis++) {
      seed = seed * 1664525u + 1013904223u;
      uint16_t from = (uint16_t)in[axis].position;
      uint16_t to = (uint16_t)(from + (seed >> 20 & 0x3F) + (uint32_t)out[axis].current / 64u);
      in[axis].position = servo_extend(in[axis].position, from, to);
      raw[axis] = (uint16_t)(seed >> 8 & 0xFFF);
      if ((tick & 255) == 0) in[axis].setpoint = (int32_t)(seed >> 16) - 32768;
    }
    *mark = 1;
    for (int axis = 0; axis < AXES; axis++) {
      in[axis].phi = servo_phi(&par[axis], raw[axis]);
      servo_step(&par[axis], &state[axis], &in[axis], &out[axis]);
    }
    *mark = 0;
    for (int axis = 0; axis < AXES; axis++) {
      mix((uint32_t)out[axis].current);
      mix((uint32_t)out[axis].inow);
      mix((uint32_t)out[axis].error);
      mix((uint32_t)out[axis].vel);
      mix((uint32_t)in[axis].phi + out[axis].events + 256u * out[axis].clipped);
      mix((uint32_t)state[axis].n1);
      mix((uint32_t)((uint64_t)state[axis].n1 >> 32));
    }
  }
  return hash;
}

#ifdef BENCH_NATIVE
uint32_t bench(uint32_t profile, uint32_t ticks);
uint32_t bench(uint32_t profile, uint32_t ticks) {
  for (int axis = 0; axis < AXES; axis++) out[axis] = (struct servo_output){0};
  return run(profile, ticks, &B->mark);
}
#else
void bench_main(void) {
  B->hash = run(B->profile, B->ticks, &B->mark);
  B->done = 1;
}

void bench_dead(void) {
  B->done = 2;
}
#endif
