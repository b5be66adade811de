/* SPDX-License-Identifier: Apache-2.0 */
/* The servo arithmetic of six axes alone, to be timed and to be compared between processors. §5.
 *
 * The caller puts profile and ticks into the parameter block and starts the image; each tick is
 * six times SERVO_PHI() and SERVO_STEP(), which lie between the two writes to MARK, and six hash
 * updates. The same file is compiled natively for the comparison. */
#include "servo_narrow.h"

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

/* pd_1000us of the axes of sim/robots/puma560.toml: a0, a1, b0, b1. */
static const int32_t puma[AXES][4] = {{40935, -39719, 512, -431}, {43696, -42057, 256, -177},
                                      {41596, -39934, 256, -124}, {4820, -4583, 32, 0},
                                      {18309, -17407, 128, 0},    {20155, -19173, 128, 0}};

/* 0 P; 1 PD with the gains of the PUMA, three of them with a derivative filter; 2 PID with
 * friction, filter and limits, and from it 3 velocity, 4 torque with offset from the A/D, 5 A/D
 * feedback, second order, 6 triangle, 7 open loop from the A/D with a divisor that is no power of
 * two; 8 PD with limits, 9 PD of numbers that leave 32 bits, 10 PD of a high gain. The
 * setpoints of 0, 1 and 10 stay near, all others saturate the current. */
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
  if (profile == 1) {
    p.a0 = puma[axis][0];
    p.a1 = puma[axis][1];
    p.b0 = puma[axis][2];
    p.b1 = puma[axis][3];
  }
  if (profile == 10) {
    p.a0 = 63339 + axis;
    p.a1 = -60879;
    p.b0 = 64;
  }
  if (profile >= 2 && profile < 10) {
    p.a0 = 300 + axis;
    p.a1 = -280;
    p.b0 = 16;
    p.plo = -20000;
    p.phi = 20000;
    p.mode |= POSCHK | SOFTERR;
    p.ilimax = 50;
  }
  if (profile >= 2 && profile < 8) {
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
  if (profile == 9) {
    p.a0 = 200000000 + axis;
    p.a1 = -190000000;
    p.b0 = 1 << 20;
  }
  *par = p;
}

struct axis {
  struct mc_param par;
  struct servo_memory state;
  struct servo_prepared law;
  struct mc_state m;
  int32_t setpoint, current;
  uint16_t raw;
};

static struct axis axes[AXES];
#define EACH(x)          \
  struct axis *x = axes; \
  x < axes + AXES;       \
  x++

/* Encoder counts and A/D values that follow the current a little, and chance. */
static void move(struct axis *x, uint32_t profile, uint32_t chance, int new_setpoint) {
  uint16_t from = (uint16_t)x->m.encnow;
  uint16_t to = (uint16_t)(from + (chance >> 20 & 0x3F) + (uint32_t)x->current / 64u);
  x->m.encnow = servo_extend(x->m.encnow, from, to);
  x->raw = (uint16_t)(chance >> 8 & 0xFFF);
  if (profile < 2 || profile == 10) {
    x->setpoint = x->m.encnow + (int32_t)(chance >> 12 & 31) - 16;
  } else if (new_setpoint) {
    x->setpoint = (int32_t)(chance >> 16) - 32768;
  }
}

static uint32_t run(uint32_t profile, uint32_t ticks, volatile uint32_t *mark) {
  uint32_t seed = 1 + profile;
  hash = 0x811C9DC5u;
  (void)mark;
  for (int n = 0; n < AXES; n++) {
    choose(&axes[n].par, profile, n);
    servo_reset(&axes[n].state);
    servo_prepare(&axes[n].law, &axes[n].par);
    axes[n].m.encnow = axes[n].setpoint = 0;
    axes[n].current = 0;
  }
  for (uint32_t tick = 0; tick < ticks; tick++) {
    for (EACH(x)) {
      seed = seed * 1664525u + 1013904223u;
      move(x, profile, seed, (tick & 255) == 0);
    }
    *mark = 1;
    for (EACH(x)) {
      x->m.adcvai = SERVO_PHI(&x->par, &x->law, x->raw);
      x->current = SERVO_STEP(&x->par, &x->law, &x->state, x->setpoint, &x->m);
    }
    *mark = 0;
    for (EACH(x)) {
      mix((uint32_t)x->current);
      mix((uint32_t)x->m.inow);
      mix((uint32_t)x->m.error);
      mix((uint32_t)x->m.vel);
      mix((uint32_t)x->m.adcvai + x->state.events + 256u * x->state.clipped);
      mix((uint32_t)x->state.n1);
      mix((uint32_t)((uint64_t)x->state.n1 >> 32));
    }
  }
  return hash;
}

#ifdef BENCH_NATIVE
uint32_t bench(uint32_t profile, uint32_t ticks);
uint32_t bench(uint32_t profile, uint32_t ticks) {
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
