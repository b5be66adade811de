/* SPDX-License-Identifier: Apache-2.0 */
/* The mc driver, §2.4, as a Linux program on a mapped VME window:
 * user [DEVICE ADDRESS [PRIORITY]]. main() is for a program of your own to replace.
 *
 *   cc -Ifirmware/mc -Ifirmware/include -o user firmware/ports/linux/user.c \
 *     firmware/mc/[a-z]*.c -lm
 *   mmcs exec --lockstep --scenario lab500 -- ./user
 */
#define _GNU_SOURCE
#include <err.h>
#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include "mc.h"
#include "mmcs_regs.h"

#define SAMPLES 400
#define POLL_US 100
#define LATE_S 1 /* a program that has waited so long for a sample ends */
#define ENABLES (MMCS_PCCSR_SCLOCK_EN_bm | MMCS_PCCSR_PANIC_EN_bm)
#define LATCHES (MMCS_PCCSR_SCLOCK_LATCHED_bm | MMCS_PCCSR_PANIC_LATCHED_bm)

static uint64_t memory[MC_WORDS];
static struct mc *const mc = (struct mc *)memory;
static volatile uint8_t *window;
static pthread_mutex_t level; /* the interrupt level: held at every access to the window */
static pthread_cond_t sampled = PTHREAD_COND_INITIALIZER;
static sigjmp_buf after_fault;
static volatile sig_atomic_t accessing;

/* A fault of an access to the window fails that access; any other one ends the program. */
static void bus_fault(int number) {
  if (accessing) siglongjmp(after_fault, number == SIGBUS ? MC_BUS_ERROR : MC_BUS_TIMEOUT);
  (void)signal(number, SIG_DFL);
}

static enum mc_bus_result read8(void *ctx, uint16_t offset, uint8_t *value) {
  (void)ctx;
  int fault = sigsetjmp(after_fault, 0);
  accessing = fault == 0;
  if (fault == 0) *value = window[offset];
  accessing = 0;
  return (enum mc_bus_result)fault;
}

/* Nobody takes interrupts: they stay disabled. */
static enum mc_bus_result write8(void *ctx, uint16_t offset, volatile uint8_t value) {
  (void)ctx;
  int fault = sigsetjmp(after_fault, 0);
  accessing = fault == 0;
  if (offset == MMCS_PCCSR) value &= (uint8_t)~ENABLES;
  if (fault == 0) window[offset] = value;
  accessing = 0;
  return (enum mc_bus_result)fault;
}

static unsigned mask(void *ctx) {
  (void)ctx;
  return (unsigned)pthread_mutex_lock(&level);
}

static void unmask(void *ctx, unsigned previous) {
  (void)ctx, (void)previous;
  (void)pthread_mutex_unlock(&level);
}

static void signal_client(void *ctx, int client) {
  (void)ctx;
  warnx("client %d: an axis has an error, read() shows it", client);
}

static void log_line(void *ctx, const char *text) {
  (void)ctx;
  warnx("%s", text);
}

static void compute(void *ctx, unsigned axes) {
  (void)ctx, (void)axes;
}

static void delay_us(void *ctx, uint32_t us) {
  (void)ctx;
  (void)usleep(us);
}

static int copy(void *ctx, void *to, const void *from, size_t length) {
  (void)ctx;
  if (to == NULL || from == NULL) return -MC_EFAULT;
  memcpy(to, from, length);
  return 0;
}

/* Serves the latches, and bus errors, as the interrupt would; mc_watch() reports interrupts that do
 * not come. */
static void *servo(void *unused) {
  uint64_t quiet_us = 0;
  uint8_t latches;
  for (;;) {
    (void)usleep(POLL_US);
    (void)mask(NULL);
    int due = read8(NULL, MMCS_PCCSR, &latches) != MC_BUS_OK || (latches & LATCHES) != 0;
    quiet_us = due ? 0 : quiet_us + POLL_US;
    if (due && mc_interrupt(mc)) (void)pthread_cond_broadcast(&sampled);
    if (!due) (void)mc_watch(mc, quiet_us);
    unmask(NULL, 0);
  }
  return unused;
}

static const struct mc_bus bus = {.read8 = read8, .write8 = write8};
static const struct mc_os os = {NULL, signal_client, log_line, compute, delay_us,
                                mask, unmask,        copy,     copy};
static const struct mc_config config = {.sysclk_hz = 8000000, .vector = 0x40};

static int check(int result, const char *what) {
  if (result < 0) errx(1, "%s: %s", what, strerror(-result));
  return result;
}

/* Maps the window, opens the driver, starts the servo thread. priority: of SCHED_FIFO, 0: none. */
static int start(const char *device, long address, int priority) {
  const struct sigaction fault = {.sa_handler = bus_fault, .sa_flags = SA_NODEFER};
  const struct sched_param fifo = {.sched_priority = priority};
  pthread_mutexattr_t nested;
  pthread_t thread;
  int fd = open(device, O_RDWR | O_SYNC);
  window = fd < 0 ? MAP_FAILED : mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, address);
  if (window == MAP_FAILED) err(2, "%s at 0x%lx", device, address);
  (void)sigaction(SIGBUS, &fault, NULL);
  (void)sigaction(SIGSEGV, &fault, NULL);
  (void)pthread_mutexattr_init(&nested);
  (void)pthread_mutexattr_settype(&nested, PTHREAD_MUTEX_RECURSIVE);
  (void)pthread_mutexattr_setprotocol(&nested, PTHREAD_PRIO_INHERIT);
  (void)pthread_mutex_init(&level, &nested);
  check(mc_attach(mc, &bus, &os, &config), "attach");
  int client = check(mc_open(mc, MC_O_RDWR), "open");
  check(-pthread_create(&thread, NULL, servo, NULL), "servo thread");
  if (priority > 0) check(-pthread_setschedparam(thread, SCHED_FIFO, &fifo), "SCHED_FIFO");
  return client;
}

/* A sine on axis 0. */
int main(int argc, char **argv) {
  struct mc_param param = {.which = 0};
  struct mc_state state;
  struct timespec late;
  int joints = 1, interval = 2000, worst = 0;
  if (argc == 2) errx(2, "usage: %s [DEVICE ADDRESS [PRIORITY]]", argv[0]);
  int client =
      start(argc > 2 ? argv[1] : "/dev/vme16", argc > 2 ? strtol(argv[2], NULL, 0) : 0x6000,
            argc > 3 ? (int)strtol(argv[3], NULL, 0) : 0);
  check(mc_ioctl(mc, client, MSETNUMJOINTS, &joints), "MSETNUMJOINTS");
  check(mc_ioctl(mc, client, MSETINTERVAL, &interval), "MSETINTERVAL");
  check(mc_ioctl(mc, client, MGETPARAM, &param), "MGETPARAM");
  param.mode = MD_POS;
  param.a0 = 1912; /* of sim/robots/lab500.toml */
  param.a1 = -1777;
  param.b0 = 64;
  check(mc_ioctl(mc, client, MSETPARAM, &param), "MSETPARAM");
  check(mc_ioctl(mc, client, MENABLE, NULL), "MENABLE");
  for (int n = 0; n < SAMPLES; n++) {
    int setpoint = (int)lround(200 * sin(6.283185307179586 * 3 * n * interval * 1e-6));
    (void)clock_gettime(CLOCK_REALTIME, &late);
    late.tv_sec += LATE_S;
    (void)mask(NULL);
    check(-pthread_cond_timedwait(&sampled, &level, &late), "sample");
    unmask(NULL, 0);
    check(mc_write(mc, client, &setpoint, sizeof setpoint), "write");
    check(mc_read(mc, client, &state, sizeof state), "read");
    if (abs(state.error) > worst) worst = abs(state.error);
  }
  printf("%d samples, %d missed, worst error %d\n", SAMPLES, mc_stats_of(mc)->missed, worst);
  return check(mc_close(mc, client), "close");
}
