# SPDX-License-Identifier: Apache-2.0
"""The table of requests, firmware/include/requests.def, and what stands beside it. Table 2.3"""

import re

import pytest

from mmcs import ROOT, mcdef
from tools import tables

REQUESTS = mcdef.requests()
SIZES = {"-": 0, "int": 4, "unsigned int": 4, "struct mc_param": 72, "struct mc_stats": 24,
         "struct mmcs_setpoint": 8}  # fmt: skip


@pytest.mark.req("DRV-3")
def test_rows_and_codes_agree():
    """As in 4.2BSD: bit 31 in, bit 30 out, bits 16 to 28 the length."""
    ways = {"none": 0, "in": 1 << 31, "out": 1 << 30, "both": 3 << 30}
    group = mcdef.MC_GROUP
    codes = {n: v for n, v in mcdef.constants().items() if v & 0xFF00 == group and v & 0xFF}
    others = {"MLEASE", "MWAIT", "MWHY", "MSTATUS"}  # the server's own
    assert set(REQUESTS) == set(codes) - others, "firmware/include: requests.def and sys/mmcs.h"
    for name, r in REQUESTS.items():
        assert codes[name] == ways[r.way] | SIZES[r.argument] << 16 | group | r.number, name
    assert len(REQUESTS) >= 21


@pytest.mark.req("DRV-3")
def test_tables_are_fresh():
    for path, whole in tables.pages().items():
        assert path.read_text() == whole, f"{path.relative_to(ROOT)} is stale; run `make generate`"


def test_every_request_has_an_example():
    page = (ROOT / "docs/use/driver.md").read_text()
    told = re.findall(r"\w+", " ".join(re.findall(r"^```c\n/\* ([^:]*):", page, re.M)))
    missing = sorted(set(REQUESTS) - set(told))
    assert not missing, f"docs/use/driver.md: no example of {', '.join(missing)}"
