/* SPDX-License-Identifier: Apache-2.0 */
/* Mapped accesses of every width and kind, §2.4; prints one line each for the test to compare. */
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

static jmp_buf env;

static void caught(int number) {
  printf("%s\n", number == SIGSEGV ? "SIGSEGV" : "SIGBUS");
  longjmp(env, 1);
}

int main(void) {
  int fd = open("/dev/vme16", O_RDWR), i;
  char *want = aligned_alloc(4096, 4096);
  volatile uint8_t *reg = mmap(want, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0x6000);
  if (reg == MAP_FAILED) return perror("mmap"), 1;
  printf("where asked %d\n", (char *)reg == want);
  printf("beyond A16 %d\n", mmap(NULL, 8192, PROT_READ, MAP_SHARED, fd, 0xF000) == MAP_FAILED);
  signal(SIGSEGV, caught);
  signal(SIGBUS, caught);
  reg[0x409] = 0x18;
  printf("byte %02x\n", reg[0x409]);
  printf("word %04x\n", *(volatile uint16_t *)(reg + 0x408));
  *(volatile uint16_t *)(reg + 0x408) = 0xAB38;
  printf("word written %02x\n", reg[0x409] & 0x1F);
  printf("long %08x\n", *(volatile uint32_t *)(reg + 0x408));
  reg[0x409] |= 0x07;
  printf("read-modify-write %02x\n", reg[0x409] & 0x1F);
  for (i = 0; i < 50; i++)
    if (setjmp(env) == 0) printf("%02x\n", reg[0x408 + 2 * (i % 4)]);
  if (setjmp(env) == 0) reg[0x400] = 1;
  if (setjmp(env) == 0) printf("%02x\n", reg[0x801]);
  printf("still %02x\n", reg[0x409] & 0x1F);
  if (munmap((void *)reg, 4096) != 0) return 1;
  return 0;
}
