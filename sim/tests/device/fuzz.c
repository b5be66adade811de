/* SPDX-License-Identifier: Apache-2.0 */
/* Random calls with random arguments and pointers at /dev/mc0, §2.3.5: only documented errors, and
 * a rejected call changes no parameter.
 *
 *   fuzz SEED CALLS      prints "N calls", or what went wrong and exits with 1
 */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "mcdef.h"
#include "sys/mmcs.h"

static const unsigned requests[] = {
#define REQUEST(name, ...) name,
#include "../../../firmware/include/requests.def"
};
static unsigned long long seed;

static unsigned next(void) {
  seed = seed * 6364136223846793005ull + 1442695040888963407ull;
  return (unsigned)(seed >> 33);
}

/* Good memory with random numbers in it, small ones as often as any; or a pointer to nowhere. */
static void *argument(unsigned request) {
  static int data[1100];
  unsigned i, kind = next() % 8;
  if (kind == 0) return NULL;
  if (kind == 1) return (void *)(unsigned long)(next() % 4096);
  if (kind == 2) return (void *)(0x7000000000000000ul + next());
  for (i = 0; i < 36; i++)
    data[i] = next() % 2 ? (int)(next() % 5) - 1 : (int)(next() << 1 ^ next());
  /* no intervals of minutes: MENABLE waits for a servo pass */
  if (request == MSETINTERVAL) data[0] = (int)(next() % 8000);
  return data;
}

static int documented(int error) {
  return error == EINVAL || error == EFAULT || error == EBADF || error == ENOTTY || error == EIO ||
         error == EBUSY;
}

static int parameters(int fd, struct mc_param *p) {
  memset(p, 0, sizeof(*p));
  return ioctl(fd, MGETPARAM, p);
}

int main(int ac, char **av) {
  struct mc_param before, after;
  int fd[2], result, watch, cards = 0;
  long calls = 0, wanted;
  unsigned request;
  if (ac != 3) return 2;
  seed = strtoull(av[1], NULL, 0);
  (void)signal(SIGUSR1, SIG_IGN); /* random limits and overloads */
  fd[0] = open("/dev/mc0", O_RDWR);
  fd[1] = open("/dev/mc0", O_RDONLY);
  if (fd[0] < 0 || fd[1] < 0) return perror("/dev/mc0"), 1;
  wanted = atol(av[2]);
  while (calls < wanted) {
    int which = fd[next() % 4 == 0], kind = (int)(next() % 16);
    size_t length = next() % 2 ? next() % 4400 : next() % 300;
    watch = next() % 16 == 0;
    /* one in eight enabling calls is let through: each takes milliseconds of the machine's time */
    request = requests[next() % (sizeof(requests) / sizeof(requests[0]))];
    if (request == MENABLE && next() % 8 != 0) request = MSTOP;
    if (kind == 0) request ^= 1u << next() % 32;
    if (watch && (parameters(fd[0], &before) < 0) && errno != EINVAL) return perror("get"), 1;
    errno = 0;
    if (kind == 1)
      result = (int)read(which, argument(0), length);
    else if (kind == 2)
      result = (int)write(which, argument(0), length);
    else
      result = ioctl(which, request, argument(request));
    calls++;
    if (result < 0 && !documented(errno)) {
      printf("call %ld, request 0x%08x: errno %d\n", calls, request, errno);
      return 1;
    }
    if (watch && result < 0) {
      parameters(fd[0], &after);
      if (memcmp(&before, &after, sizeof(before)) != 0) {
        printf("call %ld, request 0x%08x: rejected, but changed a parameter\n", calls, request);
        return 1;
      }
    }
  }
  if (ioctl(fd[0], MGETNUMCARDS, &cards) < 0 || cards != 1) return printf("no card left\n"), 1;
  printf("%ld calls\n", calls);
  return 0;
}
