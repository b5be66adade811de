#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Says in one line what this machine lacks; silent when all is there.
# Usage: check_host.sh PYTHON CXX
case ${1:---help} in -h|--help) sed -n '3,4s/^# //p' "$0"; exit 0 ;; esac
python=$1
cxx=$2
say() { echo "mmcs: $1" >&2; exit 2; }
test -w . ||
  say "this folder cannot be written: copy it to where you may write, as by 'cp -r . ~/mmcs && make -C ~/mmcs sim'"
command -v "$python" >/dev/null 2>&1 ||
  say "no '$python' found: install Python 3.11 or newer, or name one with 'make PYTHON=/path/to/python3'"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null ||
  say "'$python' is $("$python" -V 2>&1), but Python 3.11 or newer is needed: name one with 'make PYTHON=/path/to/python3.11'"
"$python" -c 'import ensurepip, venv' 2>/dev/null ||
  say "'$python' has no venv module: install it (Debian, Ubuntu: apt-get install python3-venv)"
command -v "$cxx" >/dev/null 2>&1 ||
  say "no C++ compiler '$cxx' found: install one (Debian, Ubuntu: apt-get install g++), or name one with 'make CXX=...'"
echo 'int main() { if constexpr (true) return 0; }' | "$cxx" -std=c++17 -x c++ -fsyntax-only - 2>/dev/null ||
  say "the C++ compiler '$cxx' does not speak C++17: install g++ 9 or newer, or name one with 'make CXX=...'"
