# SPDX-License-Identifier: Apache-2.0
"""A request of the driver stands in every place that needs it. Table 2.3"""

import re

import pytest

from mmcs import ROOT, mcdef
from mmcs.campaign.faults import REQUESTS as CAMPAIGN
from mmcs.device.machine import READS, WAITS
from mmcs.scenario.scenario import Request

TABLE = dict(re.findall(r"^ +\{(M\w+), \w+, (\d, \d)\},$",
                        (ROOT / "firmware/mc/ioctl.c").read_text(), re.M))  # fmt: skip
REQUESTS = [
    name
    for name, value in mcdef.constants().items()
    if name.startswith("M") and value & 0xFF00 == mcdef.MC_GROUP and value & 0xFF
]
HEADER = (ROOT / "firmware/include/sys/mmcs.h").read_text()
EXTRA = set(re.findall(r"^#define (M\w+) 0x", HEADER, re.M))
REQUESTS += sorted(EXTRA & set(TABLE))  # others are the server's own
# file: how it names a request NAME
PLACES = {
    "firmware/mc/ioctl.c": r"^    \{NAME, ",
    "firmware/tests/test_calls.c": r"\bNAME\b",  # bad pointers, files that are not open
    "firmware/tests/random_calls.c": r"\bNAME\b",
    "sim/tests/device/fuzz.c": r"\bNAME\b",
    "mmcs/device/client.py": r"\bNAME\b",
    "docs/use/driver.md": r"^\| NAME \|",
    "docs/use/first_hour.md": r"^\| `.*\bNAME\b",
    "docs/man/mc.4": r"^\.It Dv .*\bNAME\b",
}


def test_there_are_requests():
    unknown = sorted(set(TABLE) - set(REQUESTS))
    assert not unknown, f"firmware/include/mcdef.h has no {unknown}"
    assert len(REQUESTS) >= 21


@pytest.mark.req("DRV-3")
@pytest.mark.parametrize("place", PLACES)
def test_the_place_names_every_request(place):
    text = (ROOT / place).read_text()
    missing = [n for n in REQUESTS if not re.search(PLACES[place].replace("NAME", n), text, re.M)]
    assert not missing, f"{place} has no {', '.join(missing)}"


def test_every_request_has_an_example():
    page = (ROOT / "docs/use/driver.md").read_text()
    told = re.findall(r"\w+", " ".join(re.findall(r"^```c\n/\* ([^:]*):", page, re.M)))
    missing = sorted(set(REQUESTS) - set(told))
    assert not missing, f"docs/use/driver.md: no example of {', '.join(missing)}"


@pytest.mark.parametrize("place", ["mmcs/device/machine.py", "web/engine/server.js"])
def test_who_may_ask_and_what_waits_are_those_of_the_driver(place):
    """A monitor may ask what changes nothing; a request that waits is served apart."""
    reads = sorted(name for name, row in TABLE.items() if row.startswith("0"))
    waits = sorted(name for name, row in TABLE.items() if row.endswith("1"))
    if place.endswith(".py"):
        assert sorted(READS) == reads, f"{place}: READS"
        assert sorted(WAITS) == waits, f"{place}: WAITS"
    else:
        told = re.search(r"reads = \[(.*?)\]", (ROOT / place).read_text(), re.S)[1]
        assert sorted(re.findall(r"M\w+", told)) == reads, f"{place}: reads"


def test_a_scenario_a_campaign_and_a_page_call_the_same():
    """What [[call]] may name is what campaigns draw, and what a page's record can hold."""
    calls = sorted(Request.__args__)
    assert sorted(CAMPAIGN) == calls, "mmcs/campaign/faults.py: REQUESTS"
    page = (ROOT / "web/engine/server.js").read_text()
    told = re.findall(r"M\w+", re.search(r"RECORDED = \[(.*?)\]", page, re.S)[1])
    assert sorted(told) == sorted(set(calls) - {"MSETPARAM"}), "web/engine/server.js: RECORDED"
