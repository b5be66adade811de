/* SPDX-License-Identifier: Apache-2.0 */
/* Of the C library, what the test program uses: see free.c. */
#ifndef FREE_LIBC_H
#define FREE_LIBC_H

#include <stddef.h>

int printf(const char *format, ...);
int puts(const char *text);

void *calloc(size_t n, size_t size);
void free(void *at);
void exit(int status) __attribute__((noreturn));
void abort(void) __attribute__((noreturn));

void *memcpy(void *to, const void *from, size_t n);
void *memmove(void *to, const void *from, size_t n);
void *memset(void *at, int value, size_t n);
int memcmp(const void *a, const void *b, size_t n);
size_t strlen(const char *text);
int strcmp(const char *a, const char *b);
int strncmp(const char *a, const char *b, size_t n);
char *strncpy(char *to, const char *from, size_t n);
char *strcat(char *to, const char *from);
char *strchr(const char *text, int c);
char *strstr(const char *text, const char *part);

#endif
