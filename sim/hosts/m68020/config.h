/* SPDX-License-Identifier: Apache-2.0 */
/* How Musashi's core is configured for a 68020 with interrupts acknowledged on the bus. What is not
 * named is off.
 *
 * The 010 and the EC020 stay on although they are not used: without them the core decodes the
 * 68020's addressing modes and builds its stack frames as a 68000 does, without a word. */
#ifndef MMCS_M68020_CONFIG_H
#define MMCS_M68020_CONFIG_H
#define M68KCONF__HEADER

#define OPT_ON 1
#define OPT_SPECIFY_HANDLER 2

#define M68K_EMULATE_010 OPT_ON
#define M68K_EMULATE_EC020 OPT_ON
#define M68K_EMULATE_020 OPT_ON
/* fetches come separately: they may hit the cache */
#define M68K_SEPARATE_READS OPT_ON
#define M68K_EMULATE_INT_ACK OPT_SPECIFY_HANDLER
#define M68K_INT_ACK_CALLBACK(A) mmcs_m68020_acknowledge(A)
#define M68K_USE_64_BIT OPT_ON

int mmcs_m68020_acknowledge(int level);

#endif
