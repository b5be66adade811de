/* SPDX-License-Identifier: Apache-2.0 */
/* Of the C library, what the test programs use: see free.c. */
#ifndef FREE_STDLIB_H
#define FREE_STDLIB_H

#include <stddef.h>

void *calloc(size_t n, size_t size);
void free(void *at);
void exit(int status) __attribute__((noreturn));
void abort(void) __attribute__((noreturn));

#endif
