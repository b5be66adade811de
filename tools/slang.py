# SPDX-License-Identifier: Apache-2.0
"""A second opinion of the language: slang parses and elaborates the testbenches of sim/dpi and all
of rtl/; any error fails. Started at the top of the checkout."""

import argparse
import sys
from pathlib import Path

from pyslang import driver

from tools.sources import sources

ROOT = Path(__file__).resolve().parent.parent


def elaborates(arguments: list) -> bool:
    """Whether slang finds no error; what it finds goes to the error output."""
    slang = driver.Driver()
    slang.addStandardArgs()
    words = ["slang", "--timescale", "1ns/1ps", "-Wnone", *map(str, arguments)]
    if not slang.parseCommandLine(" ".join(words)) or not slang.processOptions():
        return False
    return slang.parseAllSources() and slang.runFullCompilation(True)


def jobs() -> dict[str, list]:
    """By name, what slang is given: without a top, every module that nobody instantiates is one."""
    bench = ["-f", ROOT / "sim/dpi/mmcs_tb.f"]
    return {
        "mmcs_tb": bench,
        "rtl": [f"-I{ROOT / 'rtl'}", *sources("rtl")],
    }


def main() -> int:
    argparse.ArgumentParser(description=__doc__).parse_args()
    failed = [name for name, arguments in jobs().items() if not elaborates(arguments)]
    if failed:
        print(f"slang: {', '.join(failed)}: see above", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
