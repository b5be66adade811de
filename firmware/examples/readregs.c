/* SPDX-License-Identifier: Apache-2.0 */
/* clang-format off: written as in 1989 */
/*
 * Maps the hardware into the process (Fig. 2.5) and reads the registers of the adaptor and of the
 * first card; shows what an access to an address without a device does.
 */
#include <stdio.h>
#include <setjmp.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/types.h>

#define WINDOW	0x6000		/* of the adaptor in VME A16 space */

jmp_buf	env;

void
buserr(sig)
int	sig;
{
	printf("%s\n", sig == SIGSEGV ? "time-out" : "BUS ERROR");
	longjmp(env, 1);
}

main()
{
	int	fd, len, i;
	caddr_t	addr, valloc();
	volatile unsigned char *reg;
	volatile unsigned short *word;

	len = getpagesize();
	if ((fd = open("/dev/vme16", O_RDWR)) < 0) {
		perror("/dev/vme16");
		exit(1);
	}
	addr = valloc(len);
	if ((long) mmap(addr, len, PROT_READ|PROT_WRITE, MAP_SHARED, fd, WINDOW) == -1) {
		perror("mmap");
		exit(1);
	}
	signal(SIGBUS, buserr);
	signal(SIGSEGV, buserr);

	reg = (unsigned char *) addr;
	word = (unsigned short *) addr;
	printf("PCCSR as found   0x%02x\n", reg[0x409]);
	reg[0x409] = 0x18;
	printf("PCCSR as written 0x%02x\n", reg[0x409]);
	printf("as a short       0x%04x\n", word[0x408 / 2]);
	reg[0x007] = 0x89;		/* card 0: ports A and B out, C in */
	reg[0x001] = 0x15;		/* port A */
	printf("card 0 port A    0x%02x\n", reg[0x001]);
	for (i = 0; i < 3; i++)
		if (setjmp(env) == 0) {
			printf("even byte 0x%03x: ", 0x408 + 2 * i);
			printf("0x%02x\n", reg[0x408 + 2 * i]);
		}
	exit(0);
}
