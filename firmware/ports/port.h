/* SPDX-License-Identifier: Apache-2.0 */
/* What a processor must provide to the common part of a port. */
#ifndef PORT_H
#define PORT_H

#include <stdint.h>

#include "mc.h"

/* Byte accesses to the adaptor's window, as struct mc_bus has them. In assembler. The processor
 * sees one kind of bus error, whoever ended the cycle. */
enum mc_bus_result port_read8(void *ctx, uint16_t offset, uint8_t *value);
enum mc_bus_result port_write8(void *ctx, uint16_t offset, uint8_t value);
#ifdef __m68k__
enum mc_bus_result port_read_list(void *ctx, const uint16_t *offsets, uint8_t *values, unsigned n);
enum mc_bus_result port_write_list(void *ctx, const uint16_t *offsets, const uint8_t *values,
                                   unsigned n);
#define PORT_READ_LIST port_read_list
#define PORT_WRITE_LIST port_write_list
#else
#define PORT_READ_LIST NULL
#define PORT_WRITE_LIST NULL
#endif
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
