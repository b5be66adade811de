#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# gcc -wrapper: lets a source include "/usr/sys/sundev/mcdef.h" (Fig. 2.2), which no -I can redirect.
# Replaces the C source among the compiler's arguments by a copy that names our header.
header=$(cd "$(dirname "$0")/../.." && pwd)/firmware/include/mcdef.h
for argument in "$@"; do
  case "$argument" in
    *.c)
      if grep -q '"/usr/sys/sundev/mcdef\.h"' "$argument" 2>/dev/null; then
        copy=$(mktemp "${TMPDIR:-/tmp}/mcdef-XXXXXX.c") || exit 1
        trap 'rm -f "$copy"' EXIT
        { printf '#line 1 "%s"\n' "$argument"
          sed "s|\"/usr/sys/sundev/mcdef\\.h\"|\"$header\"|" "$argument"; } >"$copy"
        folder=$(dirname "$argument")
      fi ;;
  esac
done
if [ -n "${copy:-}" ]; then
  first=1
  for argument in "$@"; do
    [ "$first" = 1 ] && set -- && first=0
    case "$argument" in
      *.c) grep -q '"/usr/sys/sundev/mcdef\.h"' "$argument" 2>/dev/null && argument=$copy ;;
    esac
    set -- "$@" "$argument"
  done
  set -- "$@" -iquote "$folder"
fi
"$@"
