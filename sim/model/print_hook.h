// SPDX-License-Identifier: Apache-2.0
// Verilator's runtime prints through this when assertions are compiled in: a library does not
// write to the console; the text becomes the note of the failed assertion.
#pragma once

#ifdef __cplusplus
extern "C"
#endif
    int mmcs_model_print(const char *format, ...);

#define VL_PRINTF mmcs_model_print
