/* SPDX-License-Identifier: Apache-2.0 */
/* What a process sees of /dev/mc: every call with its errors. §2.3, Table 2.3 */
#include "traffic.h"
#include "sys/mmcs.h"

static const struct {
  uint32_t code;
  int changes; /* not for a monitor */
} requests[] = {
#define REQUEST(name, number, argument, way, serve, changes, ...) {name, changes},
#include "requests.def"
};
#define HAS_ARGUMENT(code) (((code) >> 16 & 0x1FFF) != 0)

#define COUNT(a) (sizeof a / sizeof a[0])

TEST(test_defaults, "DRV-2") {
  struct mc *mc = mock_open(&m, 2);
  for (int axis = 0; axis < 4; axis++) {
    static const struct mc_param table = {.a0 = 1,
                                          .b0 = 1,
                                          .clkdivisor = 1,
                                          .ilim = 1024,
                                          .plo = INT32_MIN,
                                          .phi = INT32_MAX,
                                          .adc_a = 1};
    struct mc_param want = table, got = param_of(mc, axis);
    want.which = axis;
    CHECK(memcmp(&want, &got, sizeof want) == 0);
    CHECK_EQ(mc_setpoint(mc, axis), 0);
  }
  unsigned us = 0;
  int verbosity = -1;
  CHECK_EQ(mc_ioctl(mc, 0, MGETINTERVAL, &us), 0);
  CHECK_EQ(us, 2000);
  CHECK_EQ(mc_ioctl(mc, 0, MGETVERBOSITY, &verbosity), 0);
  CHECK_EQ(verbosity, 0);
}

TEST(test_bad_pointers, "DRV-3") {
  struct mc *mc = mock_open(&m, 1);
  char buf[32];
  m.bad_pointer = 1;
  for (unsigned i = 0; i < COUNT(requests); i++) {
    if (!HAS_ARGUMENT(requests[i].code)) continue;
    CHECK_EQ(mc_ioctl(mc, 0, requests[i].code, buf), -MC_EFAULT);
  }
  CHECK_EQ(mc_read(mc, 0, buf, 28), -MC_EFAULT);
  CHECK_EQ(mc_write(mc, 0, buf, 4), -MC_EFAULT);
}

TEST(test_unknown_requests_and_descriptors, "DRV-3") {
  struct mc *mc = mock_open(&m, 1);
  int arg = 0;
  CHECK_EQ(mc_ioctl(mc, 0, 0x5401, &arg), -MC_ENOTTY);
  CHECK_EQ(mc_ioctl(mc, 0, MSETENC ^ 0x80000000u, &arg), -MC_ENOTTY);
  CHECK_EQ(mc_ioctl(mc, 1, MGETNUMCARDS, &arg), -MC_EBADF);
  CHECK_EQ(mc_ioctl(mc, -1, MGETNUMCARDS, &arg), -MC_EBADF);
  CHECK_EQ(mc_ioctl(mc, 99, MGETNUMCARDS, &arg), -MC_EBADF);
  CHECK_EQ(mc_close(mc, 3), -MC_EBADF);
  CHECK_EQ(mc_open(mc, 3), -MC_EINVAL);
  for (int i = 1; i < MC_MAX_CLIENTS; i++) CHECK_EQ(mc_open(mc, MC_O_RDONLY), i);
  CHECK_EQ(mc_open(mc, MC_O_RDONLY), -MC_ENFILE);
}

TEST(test_read_only_may_look_only, "DRV-2 DRV-3") {
  struct mc *mc = mock_open(&m, 1);
  int monitor = mc_open(mc, MC_O_RDONLY), blind = mc_open(mc, MC_O_WRONLY);
  struct mc_stats stats;
  struct mc_param par = {.which = 0};
  struct mc_state state;
  int32_t zero = 0;
  for (unsigned i = 0; i < COUNT(requests); i++) {
    int got = mc_ioctl(mc, monitor, requests[i].code, &par);
    CHECK_EQ(got, requests[i].changes ? -MC_EBADF : 0);
    CHECK_EQ(requests[i].changes, !(requests[i].code & MC_ARG_OUT));  // who looks is told something
  }
  CHECK_EQ(mc_ioctl(mc, monitor, MGETSTATS, &stats), 0);
  CHECK_EQ(mc_write(mc, monitor, &zero, 4), -MC_EBADF);
  CHECK_EQ(mc_read(mc, monitor, &state, 28), 28);
  CHECK_EQ(mc_read(mc, blind, &state, 28), -MC_EBADF);
  CHECK_EQ(mc_write(mc, blind, &zero, 4), 4);
}

TEST(test_rejected_parameters_change_nothing, "DRV-3") {
  struct mc *mc = mock_open(&m, 1);
  struct mc_param before = param_of(mc, 1), after;
  struct mc_param bad[11];
  for (int i = 0; i < 11; i++) {
    bad[i] = before;
    bad[i].a0 = 77;
  }
  bad[0].which = 2;
  bad[1].which = -1;
  bad[2].b0 = 0;
  bad[3].clkdivisor = 0;
  bad[4].clkdivisor = -5;
  bad[5].ipole = -1;
  bad[6].ipole = MC_FSCALE;
  bad[7].ilim = -1;
  bad[8].ilimax = INT32_MIN;
  bad[9].clkdivisor = 26; /* 52 ms: the heartbeats would live without a servo */
  bad[10].clkdivisor = INT32_MAX;
  for (int i = 0; i < 11; i++) {
    CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &bad[i]), -MC_EINVAL);
    after = param_of(mc, 1);
    CHECK(memcmp(&before, &after, sizeof before) == 0);
  }
  before.which = 2;
  CHECK_EQ(mc_ioctl(mc, 0, MGETPARAM, &before), -MC_EINVAL);
}

/* Several SCLOCKs last 50 ms at most; a single one may last longer, and panics by design. */
TEST(test_a_servo_is_no_slower_than_its_heartbeats, "DRV-3 HB-2") {
  struct mc *mc = mock_open(&m, 1);
  struct mc_param par = param_of(mc, 1);
  unsigned us = 2500, got;
  par.clkdivisor = 25;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), -MC_EINVAL);
  CHECK(strstr(m.last_log, "axis 1") != NULL);
  CHECK_EQ(mc_ioctl(mc, 0, MGETINTERVAL, &got), 0);
  CHECK_EQ(got, 2000);
  us = 100;
  CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), 0);
  par.clkdivisor = 501;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), -MC_EINVAL);
  par.clkdivisor = 500;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
  par.clkdivisor = 1;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
  us = 60000;
  CHECK_EQ(mc_ioctl(mc, 0, MSETINTERVAL, &us), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
}

TEST(test_axes_out_of_range, "DRV-3") {
  struct mc *mc = mock_open(&m, 2);
  int n = 5, axis = 3;
  unsigned word = 3;
  CHECK_EQ(mc_ioctl(mc, 0, MSETNUMJOINTS, &n), -MC_EINVAL);
  n = -1;
  CHECK_EQ(mc_ioctl(mc, 0, MSETNUMJOINTS, &n), -MC_EINVAL);
  CHECK_EQ(mc_joints(mc), 4);
  call(mc, MSETNUMJOINTS, 2);
  CHECK_EQ(mc_ioctl(mc, 0, MSETENC, &word), -MC_EINVAL);
  CHECK_EQ(mc_ioctl(mc, 0, MSETLED, &word), -MC_EINVAL);
  CHECK_EQ(mc_ioctl(mc, 0, MSETDAC, &word), -MC_EINVAL);
  CHECK_EQ(mc_ioctl(mc, 0, MCALIB, &axis), -MC_EINVAL);
}

TEST(test_read_and_write_sizes, "DRV-4") {
  struct mc *mc = mock_open(&m, 2);
  struct mc_state state[8];
  int32_t set[5] = {1, 2, 3, 4, 5};
  CHECK_EQ(mc_read(mc, 0, state, 27), -MC_EINVAL);
  CHECK_EQ(mc_read(mc, 0, state, 28), 28);
  CHECK_EQ(mc_read(mc, 0, state, 83), 56);
  CHECK_EQ(mc_read(mc, 0, state, sizeof state), 4 * 28);
  CHECK_EQ(mc_write(mc, 0, set, 20), -MC_EINVAL);
  CHECK_EQ(mc_write(mc, 0, set, 6), -MC_EINVAL);
  CHECK_EQ(mc_setpoint(mc, 0), 0);
  CHECK_EQ(mc_write(mc, 0, set, 8), 8);
  CHECK_EQ(mc_setpoint(mc, 1), 2);
  CHECK_EQ(mc_setpoint(mc, 2), 0);
}

TEST(test_state_follows_the_axis_while_off, "DRV-11 SRV-1") {
  struct mc *mc = mock_open(&m, 1);
  mock_run(&m, 5000);
  m.card[0].count[1] = 30;
  m.card[0].adc[1] = 100;
  mock_run(&m, 2000);
  const struct mc_state *state = mc_state_of(mc, 1);
  CHECK_EQ(state->encnow, 30);
  CHECK_EQ(state->fbnow, 30);
  CHECK_EQ(state->vel, 45);
  CHECK_EQ(state->adcvai, 100);
  CHECK_EQ(state->inow, 0);
}

TEST(test_set_dac, "DRV-12") {
  struct mc *mc = mock_open(&m, 1);
  int arg = 0xABC << 8 | 1, position;
  struct mc_param par = param_of(mc, 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSETDAC, &arg), -MC_EIO);
  CHECK_EQ(mc_ioctl(mc, 0, MENABLE, NULL), 0);
  CHECK_EQ(mc_ioctl(mc, 0, MSETDAC, &arg), 0);
  mock_run(&m, 2100);
  CHECK_EQ(mock_dac(&m, 1), 0xABC);
  CHECK_EQ(mc_state_of(mc, 1)->inow, 0xABC - 2048);
  par.mode = MD_TORQ;
  CHECK_EQ(mc_ioctl(mc, 0, MSETPARAM, &par), 0);
  position = 0x123 << 8;
  CHECK_EQ(mc_ioctl(mc, 0, MSETDAC, &position), -MC_EINVAL);
  CHECK_EQ(mc_ioctl(mc, 0, MSTOP, NULL), 0);
  CHECK_EQ(mock_dac(&m, 1), 0x800);
}

/* Any call with any argument: documented errors only, and nothing for the sanitizers. */
TEST(test_fuzz, "DRV-3 DRV-4") {
  struct mc *mc = mock_open(&m, 2);
  unsigned seed = 12345;
  union {
    struct mc_param par;
    uint32_t word[18];
    struct mc_state state[9];
  } arg = {0};
  (void)mc_open(mc, MC_O_RDONLY);
  for (int i = 0; i < 20000; i++) {
    for (int k = 0; k < 18; k++) {
      seed = seed * 1664525u + 1013904223u;
      arg.word[k] = (seed >> 28) < 8 ? seed >> 16 & 7 : seed ^ seed >> 15;
    }
    seed = seed * 1664525u + 1013904223u;
    unsigned pick = (seed >> 16 & 0xFF) % (COUNT(requests) + 10);
    int client = (int)(seed >> 8 & 3) - 1, got;
    if (pick < COUNT(requests)) {
      if (requests[pick].code == MSETINTERVAL) arg.word[0] = 200 + arg.word[0] % 4000;
      got = mc_ioctl(mc, client, requests[pick].code,
                     HAS_ARGUMENT(requests[pick].code) ? &arg : NULL);
    } else if (pick < COUNT(requests) + 3) {
      got = mc_read(mc, client, &arg, seed >> 24);
    } else {
      got = mc_write(mc, client, &arg, (seed >> 24) % 70);
    }
    CHECK(got >= 0 || got == -MC_EINVAL || got == -MC_EBADF || got == -MC_EIO ||
          got == -MC_ENOTTY || got == -MC_EBUSY);
    mock_run(&m, seed >> 20 & 127);
  }
}

MAIN
