/* SPDX-License-Identifier: Apache-2.0 */
/* What a processor must provide to the common part of a port. */
#ifndef PORT_H
#define PORT_H

#include <stdint.h>

/* Byte accesses that may end in a bus error: 0, or 1 if they did. In assembler. */
int port_read8(uint32_t address, uint8_t *value);
int port_write8(uint32_t address, uint8_t value);
/* Masks the servo's interrupt and the doorbell; returns what port_unmask() wants back. */
unsigned port_mask(void);
void port_unmask(unsigned previous);
/* Sleeps until an interrupt has been served, which may have come before the call; enters and
 * leaves with everything masked. */
void port_idle(void);
/* The interrupt vector for the adaptor. */
#define PORT_VECTOR 0x40

/* What the common part provides to the vector table. */
void port_main(void);
void port_servo_interrupt(void);
void port_spurious_interrupt(void);
void port_doorbell_interrupt(void);
void port_dead(uint32_t vector, uint32_t pc);

#endif
