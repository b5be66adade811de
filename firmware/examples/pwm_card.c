/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Moves the joint of the card of pwm_card.sv through the adaptor's window: a servo of its own, 1000 times a second.
 *   cc -o pwm_card pwm_card.c && mmcs exec --lockstep --scenario pwm_card.toml -- ./pwm_card 500
 */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#define WINDOW 0x6000 /* of the adaptor in VME A16 space */
#define PCCSR 0x409   /* the adaptor's register with PC address bits 9 to 5 */
#define CARDS 0x18    /* their value for PC address 0x300, where cards are */
#define SLOT 0        /* PC address bits 13 to 10 of the card */
#define REGISTER(n) ((SLOT << 6) | ((n) << 1) | 1)

enum { DUTY = REGISTER(0), CONTROL = REGISTER(1), COUNTS_LOW = REGISTER(0), COUNTS_HIGH = REGISTER(1) };
enum { RUN = 1, NO_VOLTAGE = 128, SAMPLES = 300, PERIOD_US = 1000 };
static volatile unsigned char *reg;

static int counts(void) {
  const int low = reg[COUNTS_LOW];
  return (short)(reg[COUNTS_HIGH] << 8 | low);
}

int main(int argc, char **argv) {
  const int goal = argc > 1 ? atoi(argv[1]) : 500;
  const int fd = open("/dev/vme16", O_RDWR);
  reg = mmap(NULL, 0x1000, PROT_READ | PROT_WRITE, MAP_SHARED, fd, WINDOW);
  if (reg == MAP_FAILED) {
    perror("/dev/vme16");
    return 1;
  }
  if ((reg[PCCSR] & 0x1F) != CARDS) reg[PCCSR] = CARDS; /* else the driver has, with its interrupts */
  reg[DUTY] = NO_VOLTAGE;
  reg[CONTROL] = RUN;
  int at = counts();
  for (int n = 0; n < SAMPLES; n++) {
    const int before = at;
    at = counts();
    const int duty = NO_VOLTAGE + (goal - at) - 12 * (at - before);
    reg[DUTY] = (unsigned char)(duty < 0 ? 0 : duty > 255 ? 255 : duty);
    usleep(PERIOD_US);
  }
  reg[CONTROL] = 0;
  printf("the joint is at %d of %d counts\n", at, goal);
  return abs(goal - at) > 15;
}
