/* SPDX-License-Identifier: Apache-2.0 */
/* Where chapter 2 of the report includes it from. */
#include "../../../../firmware/include/mcdef.h"
