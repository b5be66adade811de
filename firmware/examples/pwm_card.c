/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Drives the card of pwm_card.sv through the adaptor's window: sets the duty, lets the modulator run, and measures the
 * duty by reading its output. Run it alone, or beside a program that has opened /dev/mc0:
 *   cc -o pwm_card pwm_card.c && mmcs exec --lockstep --scenario pwm_card.toml -- ./pwm_card 64
 */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>

#define WINDOW 0x6000 /* of the adaptor in VME A16 space */
#define PCCSR 0x409   /* the adaptor's register with PC address bits 9 to 5 */
#define CARDS 0x18    /* their value for PC address 0x300, where cards are */
#define SLOT 14       /* PC address bits 13 to 10 of the card; Mark I cards count from 0 */
#define REGISTER(n) ((SLOT << 6) | ((n) << 1) | 1)

enum { DUTY = REGISTER(0), CONTROL = REGISTER(1), PULSES = REGISTER(0), STATUS = REGISTER(1) };
enum { RUN = 1, SAMPLES = 2000 };

int main(int argc, char **argv) {
  const int duty = argc > 1 ? atoi(argv[1]) : 64;
  const int fd = open("/dev/vme16", O_RDWR);
  if (fd < 0) {
    perror("/dev/vme16");
    return 1;
  }
  volatile unsigned char *const reg =
      mmap(NULL, 0x1000, PROT_READ | PROT_WRITE, MAP_SHARED, fd, WINDOW);
  if (reg == MAP_FAILED) {
    perror("mmap");
    return 1;
  }
  if ((reg[PCCSR] & 0x1F) != CARDS) reg[PCCSR] = CARDS; /* else the driver has, with its interrupts */
  reg[DUTY] = (unsigned char)duty;
  reg[CONTROL] = RUN;
  const unsigned char before = reg[PULSES];
  int high = 0;
  for (int n = 0; n < SAMPLES; n++) {
    high += reg[STATUS] & 1;
  }
  const int pulses = (unsigned char)(reg[PULSES] - before);
  reg[CONTROL] = 0;
  printf("duty %d of 256: output high in %d of %d reads, %d pulses\n", duty, high, SAMPLES, pulses);
  return pulses == 0;
}
