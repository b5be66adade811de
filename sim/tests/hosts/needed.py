# SPDX-License-Identifier: Apache-2.0
"""What tests of the 68020 need."""

import importlib.util
import shutil

import pytest

HAVE = shutil.which("m68k-linux-gnu-gcc") and importlib.util.find_spec("machine68k")
m68020 = pytest.mark.skipif(not HAVE, reason="missing: m68k-linux-gnu-gcc or machine68k")
