/* SPDX-License-Identifier: Apache-2.0 */
/* Random calls of the driver, right and wrong ones, on the mock machine, with sanitizers:
 * `random_calls N [SEED]`. Each must answer with what the manual says of it; afterwards an orderly
 * program works. */
#include "harness.h"
#include "mc_priv.h"
#include "mock.h"
#include "sys/mmcs.h"

static struct mock m;
static uint64_t state;

static uint32_t chance(uint32_t below) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (uint32_t)(state >> 33) % below;
}

/* Small numbers, corners and any others. */
static int32_t number(void) {
  static const int32_t corners[] = {0,         1,         -1,   2,    1023,  1024, 2047, 4095,
                                    INT32_MAX, INT32_MIN, 2000, 1000, 30000, -256, 255,  65536};
  uint32_t kind = chance(4);
  if (kind == 0) return corners[chance(16)];
  if (kind == 1) return (int32_t)chance(64) - 8;
  return (int32_t)(kind == 2 ? chance(1u << 16) : chance(1u << 31) * 2u + chance(2));
}

static void expect(int result, const char *what, uint32_t detail, const int *errors, unsigned n) {
  if (result >= 0) return;
  for (unsigned i = 0; i < n; i++) {
    if (-result == errors[i]) return;
  }
  printf("%s 0x%x: error %d is not in the manual\n", what, detail, -result);
  exit(1);
}

#define EXPECT_OF(result, what, detail, ...)                                   \
  do {                                                                         \
    static const int errors_[] = {__VA_ARGS__};                                \
    expect(result, what, detail, errors_, sizeof errors_ / sizeof errors_[0]); \
  } while (0)

static void random_ioctl(struct mc *mc, int client) {
  static const uint32_t requests[] = {
#define REQUEST(name, ...) name,
#include "requests.def"
  };
  union {
    struct mc_param param;
    struct mc_stats stats;
    int32_t words[18];
  } arg;
  uint32_t request = requests[chance(sizeof requests / sizeof requests[0])];
  if (request == MENABLE && chance(50) != 0) return; /* it waits for milliseconds */
  if (request == MDIAGMODE && chance(8) != 0) return;
  for (int i = 0; i < 18; i++) arg.words[i] = number();
  if (request == MSETPARAM && chance(2) != 0) { /* one that may pass */
    arg.param.which = (int)chance(4);
    arg.param.mode = (int)chance(0x800);
    arg.param.b0 = number() | 1;
    arg.param.clkdivisor = 1 + (int)chance(4);
    arg.param.ilim = (int)chance(3000);
    arg.param.ipole = (int)chance(1024);
  }
  if (request == MSETINTERVAL && chance(2) != 0) arg.words[0] = 200 + (int32_t)chance(3000);
  if ((request == MCALIB || request == MSETLED || request == MSETDAC || request == MSETENC) &&
      chance(2) != 0) {
    arg.words[0] = (int32_t)chance(1u << 24 | 0xFF) & ~0xF8;
  }
  if (chance(100) == 0) request ^= 1u << chance(32);
  void *pointer = chance(100) == 0 ? NULL : &arg;
  EXPECT_OF(mc_ioctl(mc, client, request, pointer), "ioctl", request, MC_EINVAL, MC_EBADF,
            MC_EFAULT, MC_ENOTTY, MC_EIO, MC_EBUSY);
}

static void disturb(void) {
  struct mock_card *c = &m.card[chance(2)];
  switch (chance(10)) {
    case 0:
      m.estop_open = chance(4) == 0;
      break;
    case 1:
      c->present = chance(8) != 0;
      break;
    case 2:
      m.adaptor_dead = chance(8) == 0;
      break;
    case 3:
      c->index[chance(2)] = 1;
      break;
    case 4:
      c->adc[chance(2)] = (uint16_t)chance(4096);
      break;
    case 5:
      m.latency_us = (int64_t)chance(200);
      break;
    case 6:
      if (chance(4) == 0) c->a = c->b = 0;
      break;
    case 7:
      m.dac_errors = (int)chance(5);
      break;
    default:
      c->count[chance(2)] = (uint16_t)(c->count[0] + chance(2000));
  }
}

static void random_call(struct mc *mc) {
  static int32_t buffer[MC_MAX_AXES * 7 + 8];
  int client = (int)chance(5) - (chance(100) == 0 ? 2 : 0);
  size_t len = chance(3) != 0 ? 4 * chance(6) : chance(sizeof buffer);
  void *memory = chance(100) == 0 ? NULL : buffer;
  switch (chance(32)) {
    case 0:
      EXPECT_OF(mc_open(mc, (int)chance(4)), "open", 0, MC_EINVAL, MC_ENFILE, MC_ENXIO);
      break;
    case 1:
      if (chance(3) == 0) EXPECT_OF(mc_close(mc, client), "close", 0, MC_EBADF);
      break;
    case 2:
      if (chance(20) == 0) EXPECT_OF(mc_halt(mc), "halt", 0, MC_EIO);
      break;
    case 3:
      mock_run(&m, (int64_t)chance(400));
      break;
    case 4:
      disturb();
      break;
    case 5:
    case 6:
    case 7:
    case 8:
      for (int i = 0; i < 8; i++) buffer[i] = number();
      EXPECT_OF(mc_write(mc, client, memory, len), "write", (uint32_t)len, MC_EINVAL, MC_EBADF,
                MC_EFAULT, MC_EIO);
      break;
    case 9:
    case 10:
    case 11:
    case 12:
      EXPECT_OF(mc_read(mc, client, memory, len), "read", (uint32_t)len, MC_EINVAL, MC_EBADF,
                MC_EFAULT);
      break;
    default:
      random_ioctl(mc, client);
  }
  CHECK(!m.masked);
}

/* Whatever was before: the next program finds a machine that works. */
static void orderly(struct mc *mc) {
  int32_t set[4] = {0};
  m.estop_open = m.adaptor_dead = m.dac_errors = 0;
  m.latency_us = 0;
  for (int i = 0; i < 2; i++) m.card[i].present = 1;
  for (int i = 0; i < MC_MAX_CLIENTS; i++) (void)mc_close(mc, i);
  mock_run(&m, 70000);
  CHECK_EQ(mc_open(mc, MC_O_RDWR), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  CHECK_EQ(mc_write(mc, 0, set, sizeof set), (int)sizeof set);
  mock_run(&m, 10000);
  CHECK(mc_is_enabled(mc) && !mock_panic(&m));
  CHECK_EQ(mc_close(mc, 0), 0);
}

int main(int argc, char **argv) {
  long calls = argc > 1 ? atol(argv[1]) : 100000;
  state = argc > 2 ? (uint64_t)atol(argv[2]) : 1;
  struct mc *mc = mock_start(&m, 2);
  for (long i = 1; i <= calls; i++) {
    random_call(mc);
    if (i % 50000 == 0 || i == calls) orderly(mc);
  }
  printf("%ld calls\n", calls);
  return 0;
}
