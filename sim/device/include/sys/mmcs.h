/* SPDX-License-Identifier: Apache-2.0 */
/* For programs that are compiled with the flags of `mmcs exec --cflags`. */
#include "../../../../firmware/include/sys/mmcs.h"
