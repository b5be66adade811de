/* SPDX-License-Identifier: Apache-2.0 */
/* A test program without a host: test_processors.py puts the name of a test into `wanted`, runs
 * from free_start() to free_end(), and finds `status` and what was printed in `told`. */
#include <stdarg.h>
#include <stdint.h>

#include "libc.h"

char wanted[128], told[1024];
int status;
int main(int argc, char **argv);
void free_start(void);
void free_end(void);

__attribute__((noinline)) void free_end(void) {
  __asm__ volatile("" ::: "memory");
}

void exit(int result) {
  status = result;
  for (;;) free_end();
}

void abort(void) {
  exit(134);
}

void free_start(void) {
  static char program[] = "program";
  char *arguments[] = {program, wanted, NULL};
  exit(main(2, arguments));
}

/* --- memory ---------------------------------------------------------------------------------- */

static _Alignas(8) unsigned char heap[1 << 20];
static size_t used, newest;

void *calloc(size_t n, size_t size) {
  size_t length = (n * size + 7) & ~(size_t)7;
  if (length > sizeof heap - used) abort();
  newest = used;
  used += length;
  return memset(heap + newest, 0, length);
}

/* What was taken last comes back, which is all that the mock needs. */
void free(void *at) {
  if (at == heap + newest) used = newest;
}

void *memmove(void *to, const void *from, size_t n) {
  unsigned char *out = to;
  const unsigned char *in = from;
  if (out <= in) return memcpy(to, from, n);
  while (n-- > 0) out[n] = in[n];
  return to;
}

/* --- text ------------------------------------------------------------------------------------ */

char *strncpy(char *to, const char *from, size_t n) {
  size_t length = strlen(from) < n ? strlen(from) : n;
  memset(to, 0, n);
  return memcpy(to, from, length);
}

char *strcat(char *to, const char *from) {
  memcpy(to + strlen(to), from, strlen(from) + 1);
  return to;
}

char *strchr(const char *text, int c) {
  for (;; text++) {
    if (*text == (char)c) return (char *)(uintptr_t)text;
    if (*text == 0) return NULL;
  }
}

char *strstr(const char *text, const char *part) {
  for (;; text++) {
    if (strncmp(text, part, strlen(part)) == 0) return (char *)(uintptr_t)text;
    if (*text == 0) return NULL;
  }
}

int strncmp(const char *a, const char *b, size_t n) {
  for (; n > 0; n--, a++, b++) {
    if (*a != *b || *a == 0) return (unsigned char)*a - (unsigned char)*b;
  }
  return 0;
}

int strcmp(const char *a, const char *b) {
  return strncmp(a, b, SIZE_MAX);
}

size_t strlen(const char *text) {
  size_t n = 0;
  while (text[n] != 0) n++;
  return n;
}

int memcmp(const void *a, const void *b, size_t n) {
  const unsigned char *x = a, *y = b;
  for (; n > 0; n--, x++, y++) {
    if (*x != *y) return *x - *y;
  }
  return 0;
}

int puts(const char *text) {
  if (strlen(told) + strlen(text) + 2 > sizeof told) return -1;
  strcat(strcat(told, text), "\n");
  return 0;
}

/* The texts and the format say enough of what failed. */
int printf(const char *format, ...) {
  va_list list;
  va_start(list, format);
  if (strncmp(format, "%s:%d:", 6) == 0) (void)puts(va_arg(list, const char *));
  va_end(list);
  return puts(format);
}
