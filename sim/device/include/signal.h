/* SPDX-License-Identifier: Apache-2.0 */
/* <signal.h> for programs of 1989: sigpause() took 4.2BSD's mask, often left out (Fig. 2.4). */
#ifndef MMCS_COMPAT_SIGNAL_H
#define MMCS_COMPAT_SIGNAL_H
#include_next <signal.h>

static inline __attribute__((unused)) int mmcs_sigpause(int mask) {
  sigset_t set;
  int number;
  sigemptyset(&set);
  for (number = 1; number <= 31; number++)
    if (mask & (1 << (number - 1))) sigaddset(&set, number);
  return sigsuspend(&set);
}
#undef sigpause
#define sigpause(...) mmcs_sigpause(__VA_ARGS__ + 0)

#endif
