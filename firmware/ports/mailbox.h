/* SPDX-License-Identifier: Apache-2.0 */
/* The shared memory between a Unix host and the processor that runs the servo, §2.3.
 *
 * Everything but text is a 32-bit word in the processor's own byte order; the host turns them. The
 * host writes `request` while `posted == done` and then rings (MAILBOX_DOORBELL); the firmware
 * answers by setting `done` to `posted`. `stop` needs no request and waits for none: the host
 * counts it up and rings, the firmware stops the machine and makes `stopped` the same. `axis` and
 * `stats` are consistent whenever the firmware reports MAILBOX_SAMPLED or MAILBOX_DONE, and belong
 * to the firmware.
 */
#ifndef MAILBOX_H
#define MAILBOX_H

#include <stdint.h>

#define MAILBOX_VERSION 4
#define MAILBOX_MAGIC 0x4D4D4353 /* "MMCS", once the firmware is up */

/* Where things are; the linker scripts agree. */
#define MAILBOX_RAM_BYTES 0x20000
#define MAILBOX_BASE 0x1E000
#define MAILBOX_BYTES 0x1000
/* A block of three words beside the memory. */
#define MAILBOX_CONTROL 0x00F00000
#define MAILBOX_REPORT (MAILBOX_CONTROL + 0)   /* write: one of MAILBOX_SERVED... to the host */
#define MAILBOX_DOORBELL (MAILBOX_CONTROL + 4) /* write: the ring is noticed, level 2 ends */
#define MAILBOX_CLOCK_US (MAILBOX_CONTROL + 8) /* read: free-running microseconds */
/* From here on the VMEbus, the adaptor in it. */
#define MAILBOX_SHORT_IO 0xFFFF0000u

enum mailbox_report {
  MAILBOX_UP = 1,      /* initialised, requests are served */
  MAILBOX_SERVED = 2,  /* an interrupt ended without a servo sample */
  MAILBOX_SAMPLED = 3, /* an interrupt ended with a servo sample */
  MAILBOX_DONE = 4,    /* the request is answered */
  MAILBOX_SIGNAL = 5,  /* SIGUSR1 for `signal_client` */
  MAILBOX_LOG = 6,     /* one line is in `text` */
  MAILBOX_DEAD = 7     /* the firmware stops for good: `fault` says why */
};

enum mailbox_call {
  MAILBOX_OPEN = 1,  /* a = flags */
  MAILBOX_CLOSE = 2, /* client */
  MAILBOX_IOCTL = 3, /* client, a = request code; the argument is in data, if has_data */
  MAILBOX_READ = 4,  /* client, a = length */
  MAILBOX_WRITE = 5  /* client, a = length */
};

#define MAILBOX_AXES 32
#define MAILBOX_DATA_WORDS 224 /* 32 states of 28 bytes */
#define MAILBOX_TEXT 128

struct mailbox_axis {
  int32_t setpoint;
  int32_t state[7]; /* struct mc_state */
  int32_t current;  /* at the D/A */
};

struct mailbox {
  uint32_t magic, version;
  /* request */
  uint32_t posted, done;
  uint32_t call;
  int32_t client;
  uint32_t a;
  uint32_t has_data; /* 0: the process gave a null pointer */
  int32_t result;
  /* reports */
  int32_t signal_client;
  uint32_t fault; /* vector number */
  uint32_t fault_pc;
  int32_t joints;
  int32_t stats[6]; /* struct mc_stats */
  uint32_t stop, stopped;
  int32_t enabled, latched; /* mc_is_enabled(), mc_is_stopped() */
  uint32_t quiet_us;        /* set with a ring: mc_watch(), and 0 again */
  int32_t cause, cause_of;  /* mc_cause() */
  struct mailbox_axis axis[MAILBOX_AXES];
  int32_t mode[MAILBOX_AXES]; /* as the last answer or stop left it */
  uint32_t data[MAILBOX_DATA_WORDS];
  uint8_t text[MAILBOX_TEXT];
};

#ifndef __cplusplus
_Static_assert(sizeof(struct mailbox) <= MAILBOX_BYTES, "the mailbox outgrows its place");
#endif

#endif
