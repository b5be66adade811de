# SPDX-License-Identifier: Apache-2.0
"""The servo on a 68020 equals native: its arithmetic to the bit, a scenario within a count. §5."""

import re
import tomllib

import pytest
from needed import needs

from mmcs import ROOT, load, simulate
from studies.processors import cycles as bench

pytestmark = needs("m68020", "riscv64-unknown-elf-gcc")


@pytest.fixture(scope="module", autouse=True)
def built():
    bench.build()


@pytest.mark.req("SRV-7", "FW-1")
@pytest.mark.parametrize("profile", range(len(bench.PROFILES)))
def test_arithmetic_equals_native(profile):
    assert bench.on_68020(profile, 20_000)[0] == bench.native()(profile, 20_000)


@pytest.mark.req("FW-1")
def test_pd_of_six_axes_takes_0_26_ms_at_most():
    """Ideal cache; with the gains that ship, which the image has a copy of."""
    source = (ROOT / "firmware" / "ports" / "bench.c").read_text()
    table = source[source.index("puma[AXES][4] = {") :].split(";")[0].split("=")[1]
    robot = tomllib.loads((ROOT / "sim" / "robots" / "puma560.toml").read_text())
    shipped = [(axis["servo"]["pd_1000us"] + [0])[:4] for axis in robot["axis"]]
    assert [int(n) for n in re.findall(r"-?\d+", table)] == sum(shipped, [])
    for profile, name in enumerate(bench.PROFILES):
        if name.startswith("PD") and "32 bits" not in name:
            _, cycles, _ = bench.on_68020(profile, 100)
            assert cycles / bench.MHZ <= 260, name


@pytest.mark.req("FW-1")
def test_lab500_ends_as_native():
    finals = [simulate(load("lab500"), host=h).log[-1] for h in ("native", "m68020")]
    assert abs(finals[0][2] - finals[1][2]) <= 1
