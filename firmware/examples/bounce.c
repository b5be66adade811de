/* SPDX-License-Identifier: Apache-2.0 */
/* clang-format off: written as in 1989 */
/*
 * Two axes in velocity mode bouncing between position limits, in the manner of chapter 2: the main
 * program sets up and sleeps; all control is done in the handler of SIGUSR1.
 *
 *	bounce [-v] [-t ms] [-n events]
 */
#include <stdio.h>
#include <sys/file.h>
#include "/usr/sys/sundev/mcdef.h"
#include <signal.h>

#define NAXIS	2
#define LIMIT	1500

int	fd, events, wanted = 20;
int	setp[NAXIS];

main(ac, av)
int	ac;
char	**av;
{
	struct mc_param param;
	struct mc_stats stats;
	int	i, naxis = NAXIS, interval = 1000, verbose = 0;
	void	bounced();

	while (--ac > 0 && **++av == '-')
		switch ((*av)[1]) {
		case 'v':
			verbose++;
			break;
		case 't':
			interval = 1000 * atoi(&(*av)[2]);
			break;
		case 'n':
			wanted = atoi(&(*av)[2]);
			break;
		default:
			fprintf(stderr, "usage: bounce [-v] [-tms] [-nevents]\n");
			exit(1);
		}

	if ((fd = open("/dev/mc0", O_RDWR)) < 0) {
		perror("/dev/mc0");
		exit(3);
	}
	signal(SIGUSR1, bounced);
	if (verbose) {
		i = M_VERBOSE;
		ioctl(fd, MSETVERBOSITY, &i);
	}
	if (ioctl(fd, MGETNUMCARDS, &i) < 0 || i < 1) {
		fprintf(stderr, "no cards\n");
		exit(3);
	}
	printf("%d cards in system\n", i);
	if (ioctl(fd, MSETNUMJOINTS, &naxis) < 0 || ioctl(fd, MSETINTERVAL, &interval) < 0) {
		perror("set up");
		exit(3);
	}
	for (i = 0; i < NAXIS; i++)
		ioctl(fd, MSETENC, &i);

	for (i = 0; i < NAXIS; i++) {
		param.which = i;
		ioctl(fd, MGETPARAM, &param);
		param.a0 = 100;
		param.mode = MD_VEL | SOFTERR | POSCHK;
		param.plo = -LIMIT;
		param.phi = LIMIT;
		ioctl(fd, MSETPARAM, &param);
	}
	if (ioctl(fd, MENABLE) < 0) {
		perror("can't enable");
		exit(3);
	}
	setp[0] = 10;
	setp[1] = -15;
	write(fd, setp, sizeof(setp));

	while (events < wanted)
		sigpause();

	ioctl(fd, MGETSTATS, &stats);
	ioctl(fd, MSTOP);
	printf("%d limit events, %d interrupts, %d missed\n", events, stats.total, stats.missed);
	exit(stats.missed != 0);
}

void
bounced()
{
	struct mc_state state[NAXIS];
	int	i, code;

	read(fd, state, sizeof(state));
	ioctl(fd, MCLEARERROR);
	for (i = 0; i < NAXIS; i++) {
		if ((code = state[i].errcode) == 0)
			continue;
		if (code & MERR_POSLIM) {
			events++;
			setp[i] = (code & MERR_PLO) ? abs(setp[i]) : -abs(setp[i]);
		} else
			printf("error code 0x%x on axis %d\n", code, i);
	}
	write(fd, setp, sizeof(setp));
}
