# SPDX-License-Identifier: Apache-2.0
"""What tests of a host need: its cross compiler and the model of its processor."""

import importlib.util
import shutil

import pytest

HOSTS = {
    "m68020": ("m68k-linux-gnu-gcc", "machine68k"),
}


def missing(*names: str) -> list[str]:
    """Of hosts, compilers (the names with dashes) and packages of Python."""
    every = [one for name in names for one in HOSTS.get(name, (name,))]
    return [n for n in every if not (shutil.which(n) if "-" in n else importlib.util.find_spec(n))]


def needs(*names: str, by: str = "make firmware"):
    """A mark: skipped where one of them is missing."""
    gone = missing(*names)
    return pytest.mark.skipif(bool(gone), reason=f"missing, install by {by}: {', '.join(gone)}")
