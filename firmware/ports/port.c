/* SPDX-License-Identifier: Apache-2.0 */
/* The mc driver on a processor of its own: mailbox in, interrupts in, bus out. §2.3. */
#include "port.h"

#include "mailbox.h"
#include "mc_priv.h"

#define BOX ((volatile struct mailbox *)MAILBOX_BASE)
#define CONTROL(address) (*(volatile uint32_t *)(address))

static struct mc driver;

static void report(enum mailbox_report what) {
  CONTROL(MAILBOX_REPORT) = what;
}

/* --- what the driver calls ------------------------------------------------------------------- */

static void signal(void *ctx, int client) {
  (void)ctx;
  BOX->signal_client = client;
  report(MAILBOX_SIGNAL);
}

static void log(void *ctx, const char *text) {
  (void)ctx;
  int n = 0;
  for (; n < MAILBOX_TEXT - 1 && text[n] != 0; n++) BOX->text[n] = (uint8_t)text[n];
  BOX->text[n] = 0;
  report(MAILBOX_LOG);
}

static void compute(void *ctx, unsigned axes) {
  (void)ctx;
  (void)axes;
}

static void delay_us(void *ctx, uint32_t us) {
  uint32_t start = CONTROL(MAILBOX_CLOCK_US);
  (void)ctx;
  /* one more, as the first may have been nearly over */
  while (CONTROL(MAILBOX_CLOCK_US) - start <= us) {
  }
}

static unsigned mask(void *ctx) {
  (void)ctx;
  return port_mask();
}

static void unmask(void *ctx, unsigned previous) {
  (void)ctx;
  port_unmask(previous);
}

/* The memory of the process is the mailbox's data; its pointer is that or null. */
static int copy(void *ctx, void *to, const void *from, size_t len) {
  (void)ctx;
  if (to == NULL || from == NULL) return -MC_EFAULT;
  uint32_t *out = to;
  const uint32_t *in = from;
  for (size_t n = 0; n < (len + 3) / 4; n++) out[n] = in[n];
  return 0;
}

static const struct mc_bus bus = {NULL, port_read8, port_write8, PORT_READ_LIST, PORT_WRITE_LIST};
static const struct mc_os os = {NULL, signal, log, compute, delay_us, mask, unmask, copy, copy};

/* --- what the host sees ---------------------------------------------------------------------- */

/* The seven words of a struct mc_state, on addresses that count up. */
static inline volatile uint32_t *put_state(volatile uint32_t *to, const void *from) {
  const uint32_t *in = from;
  *to++ = *in++;
  *to++ = *in++;
  *to++ = *in++;
  *to++ = *in++;
  *to++ = *in++;
  *to++ = *in++;
  *to++ = *in++;
  return to;
}

static void publish(void) {
  volatile uint32_t *to = (volatile uint32_t *)BOX->stats;
  const uint32_t *stats = (const uint32_t *)mc_stats_of(&driver);
  for (const uint32_t *end = stats + 6; stats < end; stats++) *to++ = *stats;
  int joints = mc_joints(&driver);
  BOX->joints = joints;
  BOX->enabled = mc_is_enabled(&driver);
  to = (volatile uint32_t *)BOX->axis;
  for (int axis = 0; axis < joints; axis++) {
    *to++ = (uint32_t)mc_setpoint(&driver, axis);
    to = put_state(to, mc_state_of(&driver, axis));
    *to++ = (uint32_t)mc_current(&driver, axis);
  }
}

/* What no servo pass changes. */
static void publish_modes(void) {
  int number;
  BOX->latched = mc_is_stopped(&driver);
  BOX->cause = mc_cause(&driver, &number);
  BOX->cause_of = number;
  int joints = mc_joints(&driver);
  for (int axis = 0; axis < joints; axis++) {
    BOX->mode[axis] = mc_param_of(&driver, axis)->mode;
  }
}

void port_servo_interrupt(void) {
  int sampled = mc_interrupt(&driver);
  publish();
  if (!sampled || !mc_is_enabled(&driver)) publish_modes();
  report(sampled ? MAILBOX_SAMPLED : MAILBOX_SERVED);
}

void port_spurious_interrupt(void) {
  mc_spurious(&driver);
  publish();
  report(MAILBOX_SERVED);
}

/* A stop, or a look after interrupts that do not come, is served here, whatever request is under
 * way; else this only wakes, and the request is served in process context. */
void port_doorbell_interrupt(void) {
  CONTROL(MAILBOX_DOORBELL) = 1;
  uint32_t quiet_us = BOX->quiet_us;
  BOX->quiet_us = 0;
  if (quiet_us != 0 && mc_watch(&driver, quiet_us)) {
    publish();
    publish_modes();
    report(MAILBOX_SERVED);
  }
  uint32_t stop = BOX->stop;
  if (stop == BOX->stopped) return;
  (void)mc_halt(&driver);
  BOX->stopped = stop;
  publish();
  publish_modes();
  report(MAILBOX_SERVED);
}

void port_dead(uint32_t vector, uint32_t pc) {
  BOX->fault = vector;
  BOX->fault_pc = pc;
  report(MAILBOX_DEAD);
}

static int32_t serve(void) {
  int client = BOX->client;
  uint32_t a = BOX->a;
  void *data = BOX->has_data ? (void *)(uintptr_t)BOX->data : NULL;
  switch (BOX->call) {
    case MAILBOX_OPEN:
      return mc_open(&driver, (int)a);
    case MAILBOX_CLOSE:
      return mc_close(&driver, client);
    case MAILBOX_IOCTL:
      return mc_ioctl(&driver, client, a, data);
    case MAILBOX_READ:
      return mc_read(&driver, client, data, a);
    case MAILBOX_WRITE:
      return mc_write(&driver, client, data, a);
    default:
      return -MC_EINVAL;
  }
}

/* Entered with everything masked. */
void port_main(void) {
  struct mc_config config = {.sysclk_hz = 8000000, .vector = PORT_VECTOR};
  (void)mc_attach(&driver, &bus, &os, &config);
  BOX->posted = BOX->done = 0;
  BOX->stop = BOX->stopped = 0;
  BOX->quiet_us = 0;
  BOX->version = MAILBOX_VERSION;
  BOX->magic = MAILBOX_MAGIC;
  report(MAILBOX_UP);
  for (;;) {
    while (BOX->posted == BOX->done) port_idle();
    port_unmask(0);
    int32_t result = serve();
    (void)port_mask();
    BOX->result = result;
    if (BOX->call != MAILBOX_WRITE && BOX->call != MAILBOX_READ) {
      publish();
      publish_modes();
    }
    BOX->done = BOX->posted;
    report(MAILBOX_DONE);
  }
}
