/* SPDX-License-Identifier: Apache-2.0 */
/* Lock-step: a cancelled thread that waits for a condition has its mutex again when its handler
 * runs; one that waits for a mutex gets it first. Prints a line of ones for each. */
#define _GNU_SOURCE
#include <pthread.h>
#include <stdio.h>
#include <unistd.h>

static pthread_mutex_t lock = PTHREAD_ERRORCHECK_MUTEX_INITIALIZER_NP;
static pthread_cond_t cond = PTHREAD_COND_INITIALIZER;

static void unlock(void *had) {
  *(int *)had = pthread_mutex_unlock(&lock) == 0; /* EPERM: it is another thread's */
}

static void *waits_for_condition(void *had) {
  pthread_mutex_lock(&lock);
  pthread_cleanup_push(unlock, had);
  for (;;) pthread_cond_wait(&cond, &lock);
  pthread_cleanup_pop(0);
}

static void *waits_for_mutex(void *had) {
  usleep(500);
  pthread_mutex_lock(&lock);
  unlock(had);
  pthread_testcancel();
  return NULL;
}

static void cancel(void *(*run)(void *)) {
  pthread_t thread;
  int had = 0;
  void *end;
  pthread_create(&thread, NULL, run, &had);
  usleep(100);
  pthread_mutex_lock(&lock);
  usleep(1000);
  pthread_cancel(thread);
  usleep(1000);
  pthread_mutex_unlock(&lock);
  pthread_join(thread, &end);
  printf("%d %d\n", had, end == PTHREAD_CANCELED);
}

int main(void) {
  cancel(waits_for_condition);
  cancel(waits_for_mutex);
  return 0;
}
