/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the preload library above the wire know of each other. */
#ifndef MMCS_DEVICE_H
#define MMCS_DEVICE_H

#include "wire.h"

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
