# SPDX-License-Identifier: Apache-2.0
"""A second opinion of the language: slang parses and elaborates the testbench of sim/dpi and all of
rtl/, which its list names; any error fails. Started at the top of the checkout."""

import argparse

from pyslang import driver

BENCH = "-f sim/dpi/mmcs_tb.f"  # every module that nobody instantiates is a top of its own


def elaborates(words: str = BENCH) -> bool:
    """Whether slang finds no error; what it finds goes to the error output."""
    slang = driver.Driver()
    slang.addStandardArgs()
    words = f"slang --timescale 1ns/1ps -Wnone {words}"
    if not slang.parseCommandLine(words) or not slang.processOptions():
        return False
    return slang.parseAllSources() and slang.runFullCompilation(True)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    raise SystemExit(not elaborates())
