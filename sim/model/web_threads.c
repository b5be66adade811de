/* SPDX-License-Identifier: Apache-2.0 */
/* What Verilator's run-time library asks about processors: in a page, no answer. Linked into no
 * other build (sim/Makefile, KIND=web). */
#include <errno.h>
#include <sched.h>
#include <stddef.h>

int pthread_getaffinity_np(void *thread, size_t size, void *set);
int pthread_setaffinity_np(void *thread, size_t size, const void *set);
int sched_getcpu(void);

int pthread_getaffinity_np(void *thread, size_t size, void *set) {
  (void)thread, (void)size, (void)set;
  return ENOSYS;
}

int pthread_setaffinity_np(void *thread, size_t size, const void *set) {
  (void)thread, (void)size, (void)set;
  return ENOSYS;
}

int sched_getcpu(void) {
  return -1;
}
