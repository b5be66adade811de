/* SPDX-License-Identifier: Apache-2.0 */
/* The interface of /dev/mc, §2.3 and Tables 2.1-2.3: structures, mode words, errors, requests.
 *
 * Compiles as old-style C and as C11, on the host and freestanding; includes nothing. */
#ifndef MCDEF_H
#define MCDEF_H

/* Per joint parameters. Units: D/A units are 1/2048 of full scale; feedback units are encoder
 * counts, or phi = adc_a * raw + adc_b with ADFB. */
struct mc_param {
  int which;                  /* axis these belong to */
  int a2, a1, a0, b2, b1, b0; /* compensator coefficients, b0 != 0 */
  int ic_pos, ic_neg;         /* Coulomb feedforward, D/A units */
  int mode, clkdivisor;       /* mode word; SCLOCKs per servo sample, >= 1 */
  int ilim, ilimax;           /* current limit, D/A units; samples above it before an error */
  int plo, phi;               /* position limits, feedback units */
  int adc_a, adc_b;           /* A/D conversion law */
  int ipole;                  /* pole of the filter on inow, times MC_FSCALE */
};

/* Table 2.1: the parameters of an axis after the first open; members not named are 0. */
#define MC_PARAM_INITIAL   \
  {.a0 = 1,                \
   .b0 = 1,                \
   .mode = 0,              \
   .clkdivisor = 1,        \
   .ilim = 1024,           \
   .plo = -2147483647 - 1, \
   .phi = 2147483647,      \
   .adc_a = 1}

/* Per joint state and status. */
struct mc_state {
  int adcvai;  /* latest A/D value (processed) */
  int encnow;  /* latest encoder value, 32 bits */
  int inow;    /* last current command; times MC_FSCALE when ipole is not 0 */
  int error;   /* latest error value */
  int fbnow;   /* latest value of the feedback quantity */
  int vel;     /* latest velocity estimate d/dt {fbnow}, per servo sample */
  int errcode; /* current errors: flags 0-7, axis 8-15, count at the index 16-31 */
};

/* What the driver counted about interrupts since open or MZEROSTATS. */
struct mc_stats {
  int total;    /* interrupts taken */
  int missed;   /* SCLOCKs that were never served */
  int overrun;  /* servo passes that lasted beyond the next SCLOCK */
  int panics;   /* PANICs noticed */
  int spurious; /* interrupts without a cause */
  int clips;    /* servo samples whose current was clipped */
};

/* Mode word: one of */
#define MD_OFF 0x000   /* not servoed */
#define MD_POS 0x001   /* position control */
#define MD_VEL 0x002   /* velocity control */
#define MD_TORQ 0x003  /* torque (current) control */
#define MD_TEST1 0x004 /* triangle waveform */
#define MD_MASK 0x00F  /* the mode without the switches below */
/* and any of */
#define COULCOMP 0x010 /* Coulomb friction feedforward (S3) */
#define ADFB 0x020     /* feedback comes from the A/D (S4) */
#define ZEROFB 0x040   /* zero feedback, open loop (S5) */
#define ADDMD 0x080    /* demand comes from the A/D (S1) */
#define ADOFF 0x100    /* torque offset comes from the A/D */
#define POSCHK 0x200   /* check position limits on the feedback signal */
#define SOFTERR 0x400  /* don't shut motors down when an error is detected */

/* Error code: flags */
#define MERR_PLO 0x01    /* low position limit crossed */
#define MERR_PHI 0x02    /* high position limit crossed */
#define MERR_POSLIM 0x03 /* either limit */
#define MERR_POSERR 0x03 /* the same under its other name */
#define MERR_ILIM 0x04   /* sustained current overload */
#define MERR_PANIC 0x08  /* hardware panic detected */
#define MERR_ZINDEX 0x10 /* zero index detected while calibrating */
#define MERR_MASK 0xFF   /* the flags */

/* MSETVERBOSITY */
#define M_VERBOSE 0x1    /* additional diagnostics */
#define M_ERRORPRINT 0x2 /* print in error situations only */

/* MDIAGMODE */
#define M_ANDIAG 0x1 /* analog loopback: D/A to A/D */
#define M_ENDIAG 0x2 /* encoders see the artificial signals */

#define MC_FSCALE 1024 /* scale of ipole and of a filtered inow */

/* Requests (Table 2.3); an argument is passed by a pointer to the type given. As in 4.2BSD bit 31:
 * the argument goes in; bit 30: it comes out; bits 16-28: its length. */
#define MC_ARG_IN 0x80000000
#define MC_ARG_OUT 0x40000000
#define MC_INT 0x40000    /* 4 bytes << 16 */
#define MC_PARAM 0x480000 /* 72 bytes << 16 */
#define MC_STATS 0x180000 /* 24 bytes << 16 */
#define MC_GROUP 0x4D00

/* generated: requests of requests.def */
#define MGETNUMCARDS (MC_ARG_OUT | MC_INT | MC_GROUP | 1)            /* int */
#define MSETNUMJOINTS (MC_ARG_IN | MC_INT | MC_GROUP | 2)            /* int */
#define MGETPARAM (MC_ARG_IN | MC_ARG_OUT | MC_PARAM | MC_GROUP | 3) /* struct mc_param */
#define MSETPARAM (MC_ARG_IN | MC_PARAM | MC_GROUP | 4)              /* struct mc_param */
#define MSTOP (MC_GROUP | 5)                                         /* none */
#define MENABLE (MC_GROUP | 6)                                       /* none */
#define MSETVERBOSITY (MC_ARG_IN | MC_INT | MC_GROUP | 7)            /* int */
#define MGETVERBOSITY (MC_ARG_OUT | MC_INT | MC_GROUP | 8)           /* int */
#define MCLEARERROR (MC_GROUP | 9)                                   /* none */
#define MSETINTERVAL (MC_ARG_IN | MC_INT | MC_GROUP | 10)            /* unsigned int */
#define MGETINTERVAL (MC_ARG_OUT | MC_INT | MC_GROUP | 11)           /* unsigned int */
#define MSETENC (MC_ARG_IN | MC_INT | MC_GROUP | 12)                 /* unsigned int */
#define MSETLED (MC_ARG_IN | MC_INT | MC_GROUP | 13)                 /* int */
#define MDIAGMODE (MC_ARG_IN | MC_INT | MC_GROUP | 14)               /* int */
#define MSETDAC (MC_ARG_IN | MC_INT | MC_GROUP | 15)                 /* int */
#define MDACMODE (MC_ARG_IN | MC_INT | MC_GROUP | 16)                /* int */
#define MGETSTATS (MC_ARG_OUT | MC_STATS | MC_GROUP | 17)            /* struct mc_stats */
#define MZEROSTATS (MC_GROUP | 18)                                   /* none */
#define MCALIB (MC_ARG_IN | MC_INT | MC_GROUP | 19)                  /* int */
/* end of requests */

#endif
