# SPDX-License-Identifier: Apache-2.0
"""A particle hits a register: the bits flip at that instant, and what depends on them follows."""

import re

import pytest
from machines import event, ioctl, machine, notes, start

from mmcs import ensure_library, regs

PCCSR, VECTOR = regs.PCCSR, regs.VECTOR


@pytest.fixture(params=["speed", "trust"])
def sim(request):
    with machine(kind=request.param) as one:
        yield one


def rest(sim):
    """An enabled machine that holds still; the client."""
    client = start(sim)
    sim.run(sim.time + 0.02)
    return client


@pytest.mark.req("ENC-1")
def test_counter_flips_and_counts_on(sim):
    client = rest(sim)
    before = sim.encoder_register(1)
    event(sim, 0.0, "seu_encoder", 1 << 10, 1)
    sim.run(sim.time + 1e-6)
    assert sim.encoder_register(1) == before ^ 1 << 10
    sim.run(sim.time + 0.002)
    said = sim.read(client)
    assert abs(abs(said[1]["encnow"]) - 1024) < 20 and abs(said[0]["encnow"]) < 20


@pytest.mark.req("DAC-1")
def test_output_latch_moves_the_motor_until_the_next_update(sim):
    rest(sim)
    event(sim, 0.0, "seu_dac_output", 1 << 11, 0)
    sim.run(sim.time + 3e-4)
    assert abs(sim.true(0)["current"]) > 0.5
    assert abs(sim.true(1)["current"]) < 0.3
    sim.run(sim.time + 0.005)
    assert abs(sim.true(0)["current"]) < 0.5


@pytest.mark.req("HB-1", "PAN-1")
def test_heartbeat_that_stops_panics(sim):
    """At once, not after 50 ms: the one-shot itself has gone out."""
    rest(sim)
    began = sim.time
    event(sim, 1e-4, "seu_heartbeat", 1, 0)
    sim.run(sim.time + 2e-3)
    raised = [n["t"] for n in notes(sim, "panic") if n["t"] > began and "high" in n["text"]]
    assert raised and raised[0] - began < 2e-4


@pytest.mark.req("CSR-1")
def test_registers_of_the_adaptor(sim):
    sim.bus_write(PCCSR, 0x18)
    event(sim, 0.0, "seu_pccsr", 0x01)
    sim.run(sim.time + 1e-6)
    assert sim.bus_read(PCCSR) & 0x1F == 0x19


@pytest.mark.req("INT-2")
def test_wrong_vector_is_spurious_until_the_driver_is_asked_why_it_is_quiet():
    with machine() as sim:
        client = rest(sim)
        event(sim, 0.0, "seu_vector", 0x80)
        sim.run(sim.time + 0.005)
        assert sim.stats()["spurious"] >= 3
        sim.run(sim.time + 0.1)
        assert "mc: PANIC: no interrupts" in [n["text"] for n in notes(sim, "log")]
        samples, spurious = sim.samples, sim.stats()["spurious"]
        sim.run(sim.time + 0.05)
        assert sim.samples - samples > 40 and sim.stats()["spurious"] == spurious
        ioctl(sim, client, "MENABLE")


@pytest.mark.req("INT-2")
def test_interrupts_of_a_wrong_vector_leave_time_to_others():
    """Without latency one follows the other."""
    with machine(latency_max_us=0) as sim:
        rest(sim)
        event(sim, 0.0, "seu_vector", 0x80)
        sim.run(sim.time + 0.0012)
        assert sim.stats()["spurious"] >= 3


@pytest.mark.req("API-1")
def test_an_assertion_that_an_upset_breaks_is_told_and_ends_nothing():
    """A one-shot that runs with no clock left: no trigger can bring it there."""
    with machine(kind="trust") as sim:
        event(sim, 0.0, "seu_heartbeat", 1, 0)
        assert sim.run(sim.time + 0.002)
        told = [n["text"] for n in notes(sim, "assert")]
        assert len(told) == 1 and re.match("after an upset: .*u_heartbeat.PulseHasClocks", told[0])


@pytest.mark.req("API-1")
def test_an_upset_is_the_same_in_every_build(monkeypatch):
    import machines

    hashes = set()
    for kind, skip, two in (("speed", 0, 0), ("speed", 0, 1), ("trust", 0, 0), ("speed", 1, 0)):
        library = ensure_library(1, kind)
        monkeypatch.setattr(machines, "ensure_library", lambda *_, lib=library: lib)
        with machine(skip=skip, two_evals=two) as one:
            start(one)
            for n, name in enumerate(("seu_encoder", "seu_dac_input", "seu_dac_output",
                                      "seu_index_latch", "seu_pccsr")):  # fmt: skip
                event(one, 0.003 * n + 1e-5, name, 1, 0)
            one.run(one.time + 0.02)
            hashes.add(one.hash())
    assert len(hashes) == 1
