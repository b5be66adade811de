/* SPDX-License-Identifier: Apache-2.0 */
/* In front of a program that holds its own machine: names its set-up file (`mmcs compile
 * --cflags`). */
#ifdef __cplusplus
extern "C"
#endif
    __attribute__((weak)) const char mmcs_setup_file[] = MMCS_SETUP_FILE;
