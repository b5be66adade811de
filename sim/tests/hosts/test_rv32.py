# SPDX-License-Identifier: Apache-2.0
"""The servo on the SoC's own processor: results as native, and what happens when it goes wrong."""

import numpy as np
import pytest
from needed import needs
from sick import PASSES, notes_of_sick

from mmcs import RunError, Session, load, machine, simulate
from studies.processors import cycles

pytestmark = [
    pytest.mark.slow,  # a model with a processor in it takes its time to compile
    needs("rv32"),
]
PANIC_S = 0.050

# What goes wrong in the servo's interrupt: (C statement, what the host is told)
WRONG = {
    "endless loop": ("for (;;) {}", None),
    "wild write": ("*(volatile int *)0x00123450 = 1;", "exception 7"),
    "wild read": ("(void)*(volatile int *)0xE0000000;", "exception 5"),
    "wild jump": ("((void (*)(void))0x00500000)();", "exception 1"),
    "illegal instruction": ('__asm__ volatile(".word 0");', "exception 2"),
}


@pytest.fixture(scope="module")
def lab500():
    return load("lab500")


@pytest.fixture(scope="module")
def rv32(lab500):
    return simulate(lab500, host="rv32")


@pytest.mark.req("SOC-3", "FW-1")
def test_every_sample_as_native(lab500, rv32):
    """Encoder, error and the demanded current of every sample, not only the last."""
    native = np.array(simulate(lab500).log)
    ours = np.array(rv32.log)
    rows = min(len(native), len(ours))
    assert rows >= len(native) - 2
    assert np.abs(native[:rows, 2] - ours[:rows, 2]).max() <= 1
    assert np.array_equal(native[:rows, 6], ours[:rows, 6]), "error codes"
    assert abs(native[rows - 1, 2] - ours[rows - 1, 2]) <= 1


@pytest.mark.req("SRV-7", "SOC-3")
def test_arithmetic_equals_native():
    """All option profiles on the core itself, which also counts its cycles."""
    cycles.build("rv32")
    native = cycles.native()
    for profile, (found, mean, _) in enumerate(cycles.on_rv32(50)):
        assert found == native(profile, 50), cycles.PROFILES[profile]
        assert 300 < mean < 10_000, cycles.PROFILES[profile]


@pytest.mark.req("SOC-3")
def test_the_same_again(lab500, rv32):
    again = simulate(lab500, host="rv32")
    assert again.hash == rv32.hash


@pytest.mark.req("SOC-3")
def test_withheld_clocks_change_nothing(lab500, rv32):
    """The build that clocks everything always, with its assertions live, runs the same course."""
    with machine(lab500, "trace", host="rv32") as sim:  # a build that test_again.py needs, too
        assert Session(sim, lab500, False).run(lambda _: None).hash == rv32.hash


@pytest.mark.req("SOC-2", "SOC-3")
@pytest.mark.parametrize("what", WRONG)
def test_firmware_gone_wrong_ends_in_panic(what, tmp_path, monkeypatch):
    statement, told = WRONG[what]
    notes = notes_of_sick("rv32", statement, load("lab500"), tmp_path, monkeypatch)
    high = [n["t"] for n in notes if n["kind"] == "panic" and "high" in n["text"]]
    low = [n["t"] for n in notes if n["kind"] == "panic" and "low" in n["text"]]
    died = [n for n in notes if "the firmware died" in n["text"]]
    assert len(low) == 1 and len(high) == 1
    # one pass a millisecond, the first of them a moment before the line went low
    assert low[0] + PASSES * 1e-3 <= high[0] <= low[0] + PASSES * 1e-3 + PANIC_S
    assert bool(died) == bool(told)
    if told:
        assert told in died[0]["text"] and high[0] - died[0]["t"] <= PANIC_S


@pytest.mark.req("SOC-2")
def test_bus_errors_as_on_the_vmebus():
    """Each is told and counted, and the driver takes them as it does natively."""
    setup = load("lab500", 'event=[{at=0.1003, input="bus_error", value=3}]')
    ends = []
    for host in ("native", "rv32"):
        with machine(setup, host=host) as sim:
            try:
                Session(sim, setup, False).run(lambda _: None)
                refused = 0
            except RunError as error:
                refused = str(error)
            told = [n for n in sim.notes() if n["kind"] == "bus"]
            assert len(told) == sim.stats()["bus_errors"] >= 1
            assert all("bus error at 0x" in n["text"] for n in told)
            ends.append((refused, len(told), sim.stats()["panics"]))
    assert ends[0] == ends[1]
