/* SPDX-License-Identifier: Apache-2.0 */
/* Of the C library, what the test programs use: see free.c. */
#ifndef FREE_STDIO_H
#define FREE_STDIO_H

int printf(const char *format, ...);
int puts(const char *text);

#endif
