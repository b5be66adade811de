/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the preload library above the wire know of each other. */
#ifndef MMCS_DEVICE_H
#define MMCS_DEVICE_H

#include <signal.h>
#include <sys/types.h>

#include "wire.h"

/* wire.c: the client's end. */

/* Opens a device: a descriptor that stands for it, or a negative errno. */
int wire_open(const char *path, int flags);
/* The file's name if fd is one of ours (1, name filled), else 0. errno is kept. */
int wire_is_file(int fd, char name[WIRE_NAME]);
/* One call. out_length: in: room, out: bytes received, never more. Returns the result; -EIO when
 * the server is gone or answers nonsense; -EINTR when it answers nothing and a signal was handled.
 */
int wire_call(uint32_t op, const char name[WIRE_NAME], uint64_t a, uint64_t b, const void *data,
              uint32_t length, void *out, uint32_t *out_length);
/* Forgets the parent's channels; call in the child of a fork. */
void wire_after_fork(void);
pid_t wire_pid(void);
/* A connection to the server, or a negative errno; all of some bytes, or of a reply: 0, or less if
 * it is gone. */
int wire_connect(int cloexec);
int wire_send(int fd, const void *data, size_t length);
int wire_take(int fd, struct wire_reply *reply, void *out, uint32_t room);
/* What a call that takes long lets through, if not all that the program does (lockstep.c). */
extern const sigset_t *(*wire_late)(const sigset_t *before);
/* How many calls this process has made: each may have taken machine time. And but for write(). */
extern unsigned long wire_calls, wire_others;
/* Before each call, if it is there: its WIRE_ number and `a`. */
extern void (*wire_first)(uint32_t op, uint64_t a);

/* The C library's own. For who has included <dlfcn.h>. */
#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

/* preload.c: the calls of a program on an open device. */
ssize_t device_read(const char name[WIRE_NAME], void *buffer, size_t length);
ssize_t device_write(const char name[WIRE_NAME], const void *buffer, size_t length);
/* Of the program's memory, which may not be there: 0, or -EFAULT. */
int device_copy_in(void *to, const void *from, size_t length);
int device_copy_out(void *to, const void *from, size_t length);
int device_can_take(void *to, size_t length);
/* 1 if an open device is /dev/vme16. */
int device_is_vme(const char name[WIRE_NAME]);
/* 1 if the path names a device that may be opened here. */
int device_is_path(const char *path);
/* The result of a call, or -1 and errno from a negative one. */
int device_fail(int result);

/* lockstep.c, if it is there; else null. Before a descriptor is read or written: waits until that
 * does not block, for so many bytes. The next sample: its number, or a negative errno. */
extern size_t (*device_await)(int fd, short events);
extern int (*device_sample)(uint32_t *number);
/* The states that came with the sample, if that many did: their bytes, or 0. */
extern int (*device_states)(const char name[WIRE_NAME], void *data, uint32_t length);
/* 1: the server will find these bytes, and write() succeeds. */
extern int (*device_later)(const char name[WIRE_NAME], const void *data, uint32_t length);

/* vme_map.c: the mapped window of /dev/vme16. */
void *vme_map(void *address, uint64_t length, int prot, int fd, int64_t offset,
              const char name[WIRE_NAME]);
/* 1 if the range belonged to a window and was unmapped. */
int vme_unmap(void *address, uint64_t length);

#endif
