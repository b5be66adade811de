#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Makes sure a command is there, installing its Debian package when allowed.
# Usage: need_debian.sh COMMAND PACKAGE [PACKAGE...]
case ${1:---help} in -h|--help) sed -n '3,4s/^# //p' "$0"; exit 0 ;; esac
command=$1
shift
command -v "$command" >/dev/null 2>&1 && exit 0
if command -v apt-get >/dev/null 2>&1; then
  if [ "$(id -u)" = 0 ]; then sudo=; elif sudo -n true 2>/dev/null; then sudo=sudo; else sudo=no; fi
  if [ "$sudo" != no ]; then
    echo "mmcs: installing $*"
    log=$(mktemp)
    exec 9>"${TMPDIR:-/tmp}/mmcs-apt-$(id -u).lock"
    flock 9 # two suites may want packages at a time, and the system's own lock makes one of them fail
    { $sudo apt-get install -y -q "$@" || { $sudo apt-get update -q && $sudo apt-get install -y -q "$@"; }; } \
      >"$log" 2>&1 </dev/null && command -v "$command" >/dev/null 2>&1 && { rm -f "$log"; exit 0; }
    tail -n 3 "$log" >&2
    rm -f "$log"
  fi
fi
echo "mmcs: '$command' is missing; install it with: sudo apt-get install $*" >&2
exit 2
