#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# gcc -wrapper: the compiler itself runs with the preload library, which gives it our header where a
# source, or a header of its own, includes "/usr/sys/sundev/mcdef.h" (Fig. 2.2); no -I redirects that.
# Usage: cc_wrapper.sh LIBRARY COMMAND...
top=$(cd "$(dirname "$0")/../.." && pwd)
library=$1
shift
MMCS_HEADER=$top/firmware/include/mcdef.h LD_PRELOAD=${LD_PRELOAD:+$LD_PRELOAD:}$library exec "$@"
