/* SPDX-License-Identifier: Apache-2.0 */
/* The window of /dev/vme16 mapped into a program: every access becomes VME cycles, §2.4.
 *
 * The window's pages are closed, so each access faults. The handler reads the value over the bus
 * into the page, opens it, lets the processor take one step over the instruction, closes the page
 * and sends what was written over the bus. Reads happen once per access, as on the bus, because
 * they have side effects. An access that the bus timer ends is given to the program's own SIGSEGV
 * handler, one that the device spoils to its SIGBUS handler (§2.4); a handler may longjmp out.
 *
 * While one thread is between fault and step, another thread could touch the open page unseen: a
 * program that maps registers into several threads must serialise its accesses.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include "device.h"

#define MAX_WINDOWS 8
#define A16_SIZE 0x10000

static struct window {
  uint8_t *base;
  uint64_t length;
  int writable;
  int fd;         /* keeps the file open when the program closes its own */
  int64_t offset; /* A16 address of the first byte */
  ino_t file;
} windows[MAX_WINDOWS];

static int caught;                /* our handlers are in place, for good */
static struct sigaction user[65]; /* what the program installed for the signals that we use */

/* An access between its fault and its single step. */
static __thread struct {
  struct window *window;
  uint8_t *at;
  uint32_t width;
  int writes;
  uintptr_t pc;
  sigset_t mask;
} step;

static struct window *window_of(const uint8_t *at) {
  for (struct window *w = windows; w < windows + MAX_WINDOWS; w++)
    if (w->base != NULL && at >= w->base && at < w->base + w->length) return w;
  return NULL;
}

#if defined(__x86_64__)
#include <ucontext.h>

#define TRAP_FLAG 0x100
#define FAULT_WRITE 2

/* Width in bytes of the memory operand of the instruction at `code`, and whether it only stores.
 * Knows the moves and arithmetic that compilers emit; anything else counts as 4 bytes wide. */
static uint32_t operand_width(const uint8_t *code, int *pure_store) {
  static const uint8_t prefixes[] = {0x66, 0xF2, 0xF3, 0x2E, 0x36, 0x3E, 0x26, 0x64, 0x65, 0xF0};
  static const uint8_t of_bytes[] = {0x80, 0x82, 0x84, 0x86, 0x88, 0x8A, 0xA4,
                                     0xAA, 0xC0, 0xC6, 0xD0, 0xD2, 0xF6, 0xFE};
  static const uint8_t stores[] = {0x88, 0x89, 0xC6, 0xC7, 0xAA, 0xAB};
  int wide16 = 0, rex_w = 0;
  uint8_t op;
  for (; memchr(prefixes, *code, sizeof(prefixes)) != NULL; code++) wide16 |= *code == 0x66;
  if ((*code & 0xF0) == 0x40) rex_w = *code++ & 8;
  op = *code;
  *pure_store = memchr(stores, op, sizeof(stores)) != NULL;
  if (op == 0x0F) {
    op = code[1];
    *pure_store = op == 0x11 || op == 0x29 || op == 0x7F || op == 0xD6 || op == 0x7E;
    if (op == 0xB6 || op == 0xBE || (op & 0xF0) == 0x90) return 1;
    if (op == 0xB7 || op == 0xBF) return 2;
    if (op == 0xD6 || (op == 0x7E && code[-1] == 0xF3)) return 8;
    if (op == 0x10 || op == 0x11 || op == 0x28 || op == 0x29 || op == 0x6F || op == 0x7F) return 16;
    return rex_w ? 8 : 4;
  }
  if (op == 0x63) return 4; /* movsxd */
  if (op < 0x40 ? (op & 5) == 0 : memchr(of_bytes, op, sizeof(of_bytes)) != NULL) return 1;
  return wide16 ? 2 : rex_w ? 8 : 4;
}

/* Moves `width` bytes over the bus, two at a time at even addresses, as a 68020 on a D16 bus. A
 * 16-bit value arrives as that value, and a 32-bit access is the high half first, whatever the byte
 * order of this machine. Returns a wire_bus number; WIRE_BUS_TIMEOUT too when the server is gone.
 */
static int transfer(struct window *w, uint8_t *at, uint32_t width, int store) {
  uint64_t address = (uint64_t)w->offset + (uint64_t)(at - w->base);
  uint32_t done = 0;
  while (done < width) {
    uint32_t n = width - done >= 2 && ((address + done) & 1) == 0 ? 2 : 1, room = n;
    uint8_t *half = at + (width == 4 && n == 2 ? done ^ 2 : done);
    int result = wire_call(store ? WIRE_STORE : WIRE_LOAD, w->file, address + done, n, half,
                           store ? n : 0, half, store ? NULL : &room);
    if (result != WIRE_BUS_OK) return result < 0 ? WIRE_BUS_TIMEOUT : result;
    if (!store && room != n) return WIRE_BUS_TIMEOUT; /* half an answer is none */
    done += n;
  }
  return WIRE_BUS_OK;
}

/* Gives the signal to the program as if we were not there. */
static void pass_on(int number, siginfo_t *info, void *context) {
  struct sigaction *act = &user[number];
  if (act->sa_flags & SA_SIGINFO) {
    act->sa_sigaction(number, info, context);
  } else if (act->sa_handler != SIG_DFL && act->sa_handler != SIG_IGN) {
    act->sa_handler(number);
  } else {
    struct sigaction plain = {.sa_handler = SIG_DFL};
    (void)REAL(sigaction)(number, &plain, NULL);
    (void)raise(number);
  }
}

static void refuse(int bus, siginfo_t *info, void *context) {
  pass_on(bus == WIRE_BUS_ERROR ? SIGBUS : SIGSEGV, info, context);
}

static long page_protect(const struct window *w, const uint8_t *at, int prot) {
  uintptr_t page = (uintptr_t)at & ~(uintptr_t)0xFFF;
  uintptr_t end = (uintptr_t)w->base + w->length;
  return syscall(SYS_mprotect, page, page + 0x2000 <= end ? 0x2000 : 0x1000, prot);
}

extern const char device_copying[] __attribute__((visibility("hidden")));

static void on_fault(int number, siginfo_t *info, void *context) {
  ucontext_t *uc = context;
  uint8_t *at = info->si_addr;
  struct window *w = window_of(at);
  int bus, pure_store = 0;
  if (uc->uc_mcontext.gregs[REG_RIP] == (greg_t)device_copying) { /* it ends, short of some bytes */
    uc->uc_mcontext.gregs[REG_RIP] += 2;
    return;
  }
  if (w == NULL || number != SIGSEGV) {
    pass_on(number, info, context);
    return;
  }
  step.at = at;
  step.pc = (uintptr_t)uc->uc_mcontext.gregs[REG_RIP];
  step.width = operand_width((const uint8_t *)step.pc, &pure_store);
  step.writes = (uc->uc_mcontext.gregs[REG_ERR] & FAULT_WRITE) != 0;
  (void)page_protect(w, at, PROT_READ | PROT_WRITE);
  bus = step.writes && !w->writable ? WIRE_BUS_TIMEOUT : WIRE_BUS_OK;
  if (bus == WIRE_BUS_OK && !(step.writes && pure_store)) bus = transfer(w, at, step.width, 0);
  if (bus != WIRE_BUS_OK) {
    (void)page_protect(w, at, PROT_NONE);
    refuse(bus, info, context);
    return;
  }
  step.window = w;
  /* no other signal between fault and step: its handler might use the window too */
  step.mask = uc->uc_sigmask;
  sigfillset(&uc->uc_sigmask);
  sigdelset(&uc->uc_sigmask, SIGTRAP);
  sigdelset(&uc->uc_sigmask, SIGSEGV);
  uc->uc_mcontext.gregs[REG_EFL] |= TRAP_FLAG;
}

static void on_step(int number, siginfo_t *info, void *context) {
  ucontext_t *uc = context;
  struct window *w = step.window;
  int bus;
  if (w == NULL) {
    pass_on(number, info, context);
    return;
  }
  step.window = NULL;
  uc->uc_mcontext.gregs[REG_EFL] &= ~TRAP_FLAG;
  uc->uc_sigmask = step.mask;
  bus = step.writes ? transfer(w, step.at, step.width, 1) : WIRE_BUS_OK;
  (void)page_protect(w, step.at, PROT_NONE);
  if (bus != WIRE_BUS_OK) {
    info->si_addr = step.at;
    uc->uc_mcontext.gregs[REG_RIP] = (greg_t)step.pc;
    (void)pthread_sigmask(SIG_SETMASK, &step.mask, NULL); /* the handler may leave by longjmp */
    refuse(bus, info, context);
  }
}

/* SA_NODEFER: a handler that leaves by longjmp can be entered again, as under 4.2BSD. */
static void catch_faults(void) {
  struct sigaction act = {.sa_flags = SA_SIGINFO | SA_NODEFER | SA_ONSTACK};
  if (caught) return;
  caught = 1;
  act.sa_sigaction = on_fault;
  (void)REAL(sigaction)(SIGSEGV, &act, &user[SIGSEGV]);
  (void)REAL(sigaction)(SIGBUS, &act, &user[SIGBUS]);
  act.sa_sigaction = on_step;
  (void)REAL(sigaction)(SIGTRAP, &act, &user[SIGTRAP]);
}

__attribute__((noinline)) int device_copy(void *to, const void *from, size_t length) {
  catch_faults();
  __asm__ volatile("device_copying: rep movsb" : "+D"(to), "+S"(from), "+c"(length) : : "memory");
  return length == 0 ? 0 : -EFAULT;
}
#else
int device_copy(void *to, const void *from, size_t length) {
  struct iovec local = {to, length}, remote = {(void *)(uintptr_t)from, length};
  return process_vm_readv(wire_pid, &local, 1, &remote, 1, 0) == (ssize_t)length ? 0 : -EFAULT;
}
#endif

int sigaction(int number, const struct sigaction *act, struct sigaction *old) {
  if (!caught || (number != SIGSEGV && number != SIGBUS && number != SIGTRAP))
    return REAL(sigaction)(number, act, old);
  if (old != NULL) *old = user[number];
  if (act != NULL) user[number] = *act;
  return 0;
}

sighandler_t signal(int number, sighandler_t handler) {
  struct sigaction act = {.sa_flags = SA_RESTART}, old;
  act.sa_handler = handler;
  if (sigaction(number, &act, &old) < 0) return SIG_ERR;
  return old.sa_handler;
}

void *vme_map(void *address, uint64_t length, int prot, int fd, int64_t offset, ino_t file) {
#if defined(__x86_64__)
  struct window *w = NULL;
  long got;
  int fixed;
  for (int i = 0; i < MAX_WINDOWS && w == NULL; i++)
    if (windows[i].base == NULL) w = &windows[i];
  length = (length + 0xFFF) & ~(uint64_t)0xFFF;
  if (w == NULL || length == 0 || offset < 0 || (offset & 0xFFF) != 0 ||
      (uint64_t)offset + length > A16_SIZE) {
    errno = w == NULL ? ENOMEM : EINVAL;
    return MAP_FAILED;
  }
  /* SunOS put the window at the page-aligned address asked for, without MAP_FIXED too */
  fixed = address != NULL && ((uintptr_t)address & 0xFFF) == 0 ? MAP_FIXED : 0;
  got = syscall(SYS_mmap, address, length, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | fixed, -1, 0L);
  if (got == -1) return MAP_FAILED;
  w->fd = (int)syscall(SYS_fcntl, fd, F_DUPFD_CLOEXEC, 3);
  if (w->fd < 0) {
    (void)syscall(SYS_munmap, got, length);
    return MAP_FAILED;
  }
  w->length = length;
  w->offset = offset;
  w->writable = (prot & PROT_WRITE) != 0;
  w->file = file;
  w->base = (uint8_t *)got;
  catch_faults();
  return w->base;
#else
  (void)address, (void)length, (void)prot, (void)fd, (void)offset, (void)file;
  errno = ENODEV; /* needs the instruction decoder above for this processor */
  return MAP_FAILED;
#endif
}

int vme_unmap(void *address, uint64_t length) {
  struct window *w = window_of(address);
  if (w == NULL || w->base != address) return 0;
  w->base = NULL;
  (void)syscall(SYS_close, w->fd);
  (void)syscall(SYS_munmap, address, length);
  return 1;
}
