/* SPDX-License-Identifier: Apache-2.0 */
/* What programs may ask of the devices here that the report does not have. */
#ifndef MMCS_H
#define MMCS_H

/* int, by pointer: 1 takes the lease, 0 gives it up, as the end of the open does. Who has it
 * changes things, nobody else does but by a stop. EBUSY: another has it; EBADF: not open for
 * writing. */
#define MLEASE 0x80044D40

/* int, by pointer: waits for the next servo sample and gives its number since power-on. */
#define MWAIT 0x40044D41

/* char[MWHY_SIZE]: why this thread's last call on an open device was refused, as one sentence;
 * empty if its errno says all there is. */
#define MWHY_SIZE 128
#define MWHY 0x40804D42

#endif
