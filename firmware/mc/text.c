/* SPDX-License-Identifier: Apache-2.0 */
/* One line for the console, without a libc. */
#include "mc_priv.h"

#define LINE 80

static unsigned append(char *line, unsigned at, const char *text) {
  while (*text != '\0' && at < LINE - 1) line[at++] = *text++;
  line[at] = '\0';
  return at;
}

static unsigned append_number(char *line, unsigned at, int number) {
  char digits[12];
  unsigned n = sizeof digits;
  digits[--n] = '\0';
  do {
    digits[--n] = (char)('0' + number % 10);
    number /= 10;
  } while (number > 0);
  return append(line, at, &digits[n]);
}

void text_log(struct mc *mc, const char *what, int number, const char *more) {
  char line[LINE];
  unsigned at = append(line, 0, "mc: ");
  at = append(line, at, what);
  if (number >= 0) at = append_number(line, append(line, at, " "), number);
  (void)append(line, at, more);
  mc->os.log(mc->os.ctx, line);
}
