/* SPDX-License-Identifier: Apache-2.0 */
/* The wire between a program under `mmcs exec` and the simulator behind `mmcs serve`.
 *
 * Two kinds of connection to one Unix stream socket. A *file* is what open("/dev/mc0") returns: the
 * kernel gives it dup, fork, close and exit for free, and the server sees the last close as end of
 * file. It carries only the opening request, its reply, and then one byte that keeps it readable
 * for poll(). A *channel* is private to one thread and carries the calls; a call names its file by
 * the abstract address that the kernel gave to the file when it was bound.
 *
 * All numbers are little-endian, as on the machines that can run this; structures are packed by
 * construction.
 */
#ifndef MMCS_WIRE_H
#define MMCS_WIRE_H

#include <stdint.h>

#define WIRE_MAGIC 0x31434D4Du /* "MMC1" */
#define WIRE_NAME 16
#define WIRE_MAX 65536u /* most bytes that one call moves either way */

enum wire_op {
  WIRE_OPEN = 1,  /* on a file: a = open flags, b = the file's inode, data = device path */
  WIRE_IOCTL = 2, /* a = request, data = argument in; reply data = argument out */
  WIRE_READ = 3,  /* a = bytes wanted */
  WIRE_WRITE = 4, /* data = bytes */
  WIRE_LOAD = 5,  /* mapped read: a = offset, b = bytes (1, 2, 4); reply data = value */
  WIRE_STORE = 6, /* mapped write: a = offset, b = bytes, data = value */
  WIRE_HOLD = 7,  /* this process holds the file now (after fork or exec) */
};

struct wire_request {
  uint32_t magic;
  uint32_t op;
  char name[WIRE_NAME]; /* the file's address, without the leading zero; empty for WIRE_OPEN */
  uint64_t a, b;
  uint32_t length; /* bytes of data that follow */
  int32_t pid;
};

struct wire_reply {
  int32_t result; /* >= 0, or a negative errno; for LOAD and STORE a wire_bus number */
  uint32_t length;
};

enum wire_bus { WIRE_BUS_OK = 0, WIRE_BUS_TIMEOUT = 1, WIRE_BUS_ERROR = 2 };

/* wire.c: the client's end. */

/* Opens a device: a descriptor that stands for it, or a negative errno. */
int wire_open(const char *path, int flags);
/* The file's name if fd is one of ours (1, name filled), else 0. errno is kept. */
int wire_is_file(int fd, char name[WIRE_NAME]);
/* One call. out_length: in: room, out: bytes received. Returns the result or -EIO when the server
 * is gone. */
int wire_call(uint32_t op, const char name[WIRE_NAME], uint64_t a, uint64_t b, const void *data,
              uint32_t length, void *out, uint32_t *out_length);
/* Forgets the parent's channels; call in the child of a fork. */
void wire_after_fork(void);

/* vme_map.c: the mapped window of /dev/vme16. */
void *vme_map(void *address, uint64_t length, int prot, int64_t offset, const char name[WIRE_NAME]);
/* 1 if the range belonged to a window and was unmapped. */
int vme_unmap(void *address, uint64_t length);

#endif
