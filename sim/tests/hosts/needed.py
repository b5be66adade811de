# SPDX-License-Identifier: Apache-2.0
"""What tests of a host need."""

import importlib.util
import shutil

import pytest

HOSTS = {"m68020": ("m68k-linux-gnu-gcc", "machine68k")}  # cross compiler, model


def needs(*names: str, by: str = "make firmware"):
    """A mark: skipped where one of these hosts, compilers (with dashes) or packages is missing."""
    every = [one for name in names for one in HOSTS.get(name, (name,))]
    gone = [n for n in every if not (shutil.which(n) if "-" in n else importlib.util.find_spec(n))]
    return pytest.mark.skipif(bool(gone), reason=f"missing, install by {by}: {', '.join(gone)}")
