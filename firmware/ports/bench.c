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
static const int32_t profiles[][7] = {
    /* mode, a0, a1, a2, b0, b1, b2 */
    {MD_POS, 12, 0, 0, 8},
    {MD_POS},
    {MD_POS, 300, -280, 13, 16, -16},
    {MD_VEL, 300, -280, 13, 16, -16},
    {MD_TORQ | ADOFF, 300, -280, 13, 16, -16},
    {MD_POS | ADFB, 300, -280, 13, 16, -16, 5},
    {MD_TEST1, 300, -280, 13, 16, -16},
    {MD_POS | ADDMD | ZEROFB, 300, -280, 13, 19, -7},
    {MD_POS, 300, -280, 0, 16},
    {MD_POS, 200000000, -190000000, 0, 1 << 20},
    {MD_POS, 63339, -60879, 0, 64},
};

static void choose(struct mc_param *par, uint32_t profile, int axis) {
  const int32_t *row = profiles[profile];
  int limited = profile >= 2 && profile < 10, whole = limited && profile < 8;
  int limits = limited ? POSCHK | SOFTERR : 0, friction = whole ? COULCOMP : 0;
  *par = (struct mc_param){.which = axis,
                           .mode = row[0] | limits | friction,
                           .a0 = profile == 1 ? puma[axis][0] : row[1] + axis,
                           .a1 = profile == 1 ? puma[axis][1] : row[2],
                           .a2 = row[3],
                           .b0 = profile == 1 ? puma[axis][2] : row[4],
                           .b1 = profile == 1 ? puma[axis][3] : row[5],
                           .b2 = row[6],
                           .clkdivisor = 1,
                           .ilim = 1024,
                           .ilimax = limited ? 50 : 0,
                           .plo = limited ? -20000 : INT32_MIN,
                           .phi = limited ? 20000 : INT32_MAX,
                           .ic_pos = whole ? 50 : 0,
                           .ic_neg = whole ? 40 : 0,
                           .ipole = whole ? 900 : 0,
                           .adc_a = whole ? 3 : 1,
                           .adc_b = whole ? -6144 : 0};
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
