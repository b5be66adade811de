/* SPDX-License-Identifier: Apache-2.0 */
/* The driver's own state and what its files call of each other, §2.3. */
#ifndef MC_PRIV_H
#define MC_PRIV_H

#include "mc.h"
#include "mmcs_regs.h"
#include "sys/mmcs.h"
#include "servo_narrow.h"

#define MC_DAC_ZERO 0x800 /* D/A code of 0 V, offset binary */
#define MC_ENC_MODE 5     /* all four edges count */
#define MC_LIGHTS ((unsigned)(MMCS_CARD_PPI_A_LED1_bm | MMCS_CARD_PPI_A_LED2_bm))
#define MC_INTERVAL_US 2000    /* after open */
#define MC_INTERVAL_MIN_US 100 /* ruled */
#define MC_HEARTBEAT_US 60000  /* one-shot (50 ms) and a margin */
#define MC_SERVO_US 50000      /* longest servo period of several SCLOCKs: the one-shot's */
#define MC_SKIP_US 25000       /* so long no servo sample: the machine stops */
#define MC_CROWDED_US 50000    /* so long one pass after the other: the console is told */
#define MC_RELAY_US 2000       /* relay (1 ms) and a margin */
#define MC_QUIET_US 50000      /* so long no interrupt: something has turned them off */
#define MC_SPEED 4000000u      /* counts/s at most, if the configuration does not know */
#define MC_ADC_POLLS 40        /* port C reads of 1 us: conversion takes at most 35 us */

/* Accesses to a card: see hw_make_lists(). */
#define MC_SENSE 6u
#define MC_ANALOG 3u
#define MC_DRIVE 4u

enum mc_power {
  MC_IDLE,     /* not enabled: no D/A low byte is written, the joints are isolated */
  MC_STARTING, /* MENABLE waits for the first servo pass */
  MC_RUNNING   /* every pass writes every D/A */
};

/* What keeps write() and the servo from going on until MENABLE. */
enum mc_latch {
  MC_FREE,
  MC_LATCHED,
  MC_LATCHED_TOLD /* a write was refused, and told so */
};

/* What the console was told and is not told again, until a sample is published; MC_TOLD_CROWDED,
 * during which samples may come, until the next open. */
enum mc_told {
  MC_TOLD_FAULT = 1,  /* a bus error in a pass */
  MC_TOLD_QUIET = 2,  /* the end of the interrupts */
  MC_TOLD_CROWDED = 4 /* passes outlast SCLOCK */
};

/* The index latch of a card that calibrates. */
enum mc_rearm {
  MC_ARMED,
  MC_DROPPED,        /* at this sample */
  MC_DROPPED_EARLIER /* to be armed at the next one */
};

struct mc_axis {
  struct mc_param par;
  struct servo_memory servo;
  struct servo_prepared law; /* of `par` */
  struct mc_state state;     /* as read() gives it */
  int32_t setpoint;
  int32_t position; /* 32 bits, congruent to the counter */
  int32_t wait;     /* SCLOCKs until the next servo sample */
  uint16_t index;   /* count at the last index */
  uint16_t counter; /* the 16-bit counter at the last sample */
  uint16_t raw;     /* A/D at the last sample */
  uint16_t code;    /* D/A code written at every SCLOCK while enabled */
  uint8_t adopt;    /* at the next servo sample a position axis demands what is fed back */
  uint8_t calib;    /* waits for its index */
  uint8_t lost;     /* nobody knows its 32 bits: MSETENC or an index tells */
};

struct mc_card {
  uint16_t base; /* of its registers in the window */
  uint8_t dip;
  uint8_t a, b;   /* shadows of ports A and B */
  uint8_t late;   /* its A/Ds did not finish at the last sample */
  uint8_t silent; /* did not answer, and has not been looked at since */
  uint8_t rearm;  /* enum mc_rearm */
};

struct mc_client {
  uint8_t used, can_read, can_write;
  uint8_t has_read;
  uint8_t since[MC_MAX_AXES];  /* flags that came since its last read() */
  uint8_t untold[MC_MAX_AXES]; /* those that no read() of this axis has shown it */
  uint8_t again[MC_MAX_AXES];  /* those that a clear left, and signalled once more */
};

/* What one SCLOCK found on the cards. */
struct mc_sample {
  uint16_t counter[MC_MAX_AXES];
  uint16_t raw[MC_MAX_AXES];
  uint16_t index[MC_MAX_AXES]; /* counter at the index, if `indexed` */
  uint8_t indexed[MC_MAX_AXES];
  uint8_t port_c[MC_MAX_CARDS];
};

/* What every pass accesses, card after card: offsets. */
struct mc_lists {
  uint16_t sense[MC_SENSE * MC_MAX_CARDS];
  uint16_t analog[MC_ANALOG * MC_MAX_CARDS];
  uint16_t drive[MC_DRIVE * MC_MAX_CARDS];
};

struct mc {
  struct mc_bus bus;
  struct mc_os os;
  struct mc_config config;
  struct mc_client client[MC_MAX_CLIENTS];
  struct mc_axis axis[MC_MAX_AXES];
  struct mc_card card[MC_MAX_CARDS];
  struct mc_sample sample;
  struct mc_lists list;
  struct mc_stats stats;
  int opens, cards, axes, joints;
  enum mc_power power;
  uint32_t n0, n1;       /* counts of timers 0 and 1, */
  uint32_t interval_us;  /* and what they make */
  uint16_t rises;        /* SCLOCKs up to the last one served, by timer 2 */
  uint8_t synced;        /* `rises` is valid */
  uint8_t pccsr;         /* shadow */
  uint8_t fault;         /* a bus access failed since it was cleared */
  uint8_t double_buffer; /* as MDACMODE asked */
  uint8_t buffered;      /* as it is in force: never while stopping */
  uint8_t drive;         /* D/As are connected to the joints */
  uint8_t diag;
  uint8_t calibrates; /* 0: no axis waits for its index, no card is to be armed again */
  uint8_t stopped;    /* enum mc_latch: of a stop */
  uint8_t shut;       /* enum mc_latch: of an error that shut the machine down */
  uint8_t cause;      /* of that, MCAUSE_... */
  uint8_t cause_of;   /* 1 + its axis or card; 0: none */
  uint8_t silent;     /* a card is */
  uint8_t told;       /* enum mc_told */
  uint32_t skipped;   /* SCLOCKs since the last pass with a sample */
  uint32_t grace;     /* SCLOCKs during which our own stop may raise PANIC */
  int verbosity;
  uint32_t crowded; /* passes in a row that outlasted an SCLOCK */
  uint32_t overran; /* stats.total at the last of them */
  int adc_timeouts; /* samples of a card whose old A/D values stayed; told on the console */
};

/* hw.c: bytes and ports. Reads that fail give 0xFF and set mc->fault. */
uint8_t hw_get(struct mc *mc, uint16_t offset);
void hw_put(struct mc *mc, uint16_t offset, uint8_t value);
uint8_t hw_card_get(struct mc *mc, int card, unsigned reg);
void hw_card_put(struct mc *mc, int card, unsigned reg, uint8_t value);
/* Registers one after the other; n may be 0. */
void hw_get_list(struct mc *mc, const uint16_t *offsets, uint8_t *values, unsigned n);
void hw_put_list(struct mc *mc, const uint16_t *offsets, const uint8_t *values, unsigned n);
/* Fills mc->list for the cards found. */
void hw_make_lists(struct mc *mc);
void hw_set_pccsr(struct mc *mc, uint8_t set, uint8_t clear);
/* Ports B as power, diagnostic and buffer modes want them. */
void hw_apply_modes(struct mc *mc);
/* Reads and clears the interrupt latches: PCCSR as it was. */
uint8_t hw_take_latches(struct mc *mc);
/* Puts the PPI of a card into its working state from the shadows. */
void hw_init_ppi(struct mc *mc, int card);
/* Writes a pattern to port A and reads it back, then restores it. 1 if the card is there. */
int hw_answers(struct mc *mc, int card);
uint16_t hw_counter(struct mc *mc, int axis);
/* All, in the order of such writes. */
void hw_write_dacs(struct mc *mc);
/* Bits of port C, which has those of joint 2 two places above those of joint 1. */
#define HEARTBEAT_BM(axis) (MMCS_CARD_PPI_C_HEARTBEAT1_bm << 2 * ((axis) & 1))
#define INDEX_BM(axis) (MMCS_CARD_PPI_C_INDEX1_bm << 2 * ((axis) & 1))

/* scan.c */
void mc_scan(struct mc *mc);

/* timer.c */
/* Finds counts for an interval: 0, or -MC_EINVAL. */
int timer_counts(const struct mc *mc, uint32_t us, uint32_t *n0, uint32_t *n1);
/* Starts SCLOCK with mc->n0, mc->n1; the latches are held clear meanwhile. */
void timer_start(struct mc *mc);
/* Of mc->n0 and mc->n1; a division, which no stop and no pass can afford: mc->interval_us. */
uint32_t timer_interval_us(const struct mc *mc);
/* SCLOCKs during which our own stop may raise PANIC. */
uint32_t timer_grace(const struct mc *mc);
/* SCLOCKs since the last one served; that becomes the one being served. */
unsigned timer_enter(struct mc *mc);
/* 1 if another SCLOCK rose since timer_enter(). */
int timer_moved(struct mc *mc);

/* sample.c */
/* Reads every card. 1 if all answered and no bus access failed. */
int sample_read(struct mc *mc, struct mc_sample *s);
/* The A/D values before there is a sample: the start of SCLOCK has begun a conversion. */
void sample_first(struct mc *mc);

/* power.c: the level is masked but in power_enable(). */
int power_enable(struct mc *mc);
/* Zero current on all axes, then silence: PANIC and brakes follow within 50 ms. */
void power_stop(struct mc *mc);
/* MSTOP, and what the last writer leaves behind: the same, and all modes off. */
void power_rest(struct mc *mc);
void power_panic(struct mc *mc);
/* A PANIC of our own, with one line that says why. */
void power_trip(struct mc *mc, int cause, const char *what);
/* Remembers what shuts the machine down: MCAUSE_..., axis or card. */
void power_blame(struct mc *mc, int cause, int number);

/* revive.c */
/* 1: the card answers, and is as the driver wants it. */
int revive_card(struct mc *mc, int card);
void revive_note(struct mc *mc);
void revive_cards(struct mc *mc);

/* watch.c */
void watch_bus_error(struct mc *mc);
/* 1: not told yet, enum mc_told; it is from now on. */
int watch_tell(struct mc *mc, uint8_t what);

/* calib.c */
int calib_disturbs(const struct mc_param *par);
void calib_start(struct mc *mc, int axis);
void calib_cancel(struct mc *mc);
void calib_end(struct mc *mc, int axis);
void calib_serve(struct mc *mc, const struct mc_sample *s);

/* axis.c */
/* The demand is 0, and what a position axis has fed back at its next sample. */
void axis_forget_demand(struct mc_axis *x);
/* Setpoints of n axes from one on; the level is masked. 0, or -MC_EIO after a stop. */
int axis_demand(struct mc *mc, int axis, int n, const int32_t *values);
int axis_is_off(const struct mc_param *par);
int axis_needs_encoder(const struct mc_param *par);
int axis_needing_encoder(const struct mc *mc);      /* or -1 */
int axis_with_lost_count(const struct mc *mc);      /* or -1 */
int axis_calibrates(const struct mc *mc, int card); /* one of the card's */

/* errors.c */
void error_raise(struct mc *mc, int axis, uint8_t flags);
void error_raise_index(struct mc *mc, int axis, uint16_t count);
void error_show(struct mc *mc, int client, int axes, struct mc_state *states);
void error_unseen(struct mc *mc, int client, int axes, const struct mc_state *shown);
void error_clear(struct mc *mc, int client);
void error_signal(struct mc *mc);
void mc_count(int *counter, unsigned by);

/* text.c: one line for the console out of words and a number; "" and -1 leave out. */
void text_log(struct mc *mc, const char *what, int number, const char *more);

#endif
