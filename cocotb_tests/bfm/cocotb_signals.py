# SPDX-License-Identifier: Apache-2.0
"""Encoders and analog pins without a design: edges at their times, faults, volts; red cases."""

import math

import cocotb
from cocotb.triggers import Timer
from cocotb.utils import get_sim_time
from cocotbext.analog import AnalogSink, AnalogSource
from cocotbext.mmcs import Pins
from cocotbext.quadrature import QuadratureDecoder, QuadratureSource

from cocotb_tests.bfm.cases import raises, refused

TOPLEVEL = "bench_wires"
SOURCES = ["bench_wires.sv"]


async def pins(dut) -> list[Pins]:
    shared = [Pins(handle) for handle in (dut.enc_a, dut.enc_b, dut.enc_i)]
    await Timer(10, "ns")
    return shared


class Edges:
    """The ns of every edge of a lane."""

    def __init__(self, dut, lane: int):
        self.ns: list[float] = []
        self.named: list[tuple[str, float]] = []
        for name in ("enc_a", "enc_b"):
            cocotb.start_soon(self._watch(name, getattr(dut, name), lane))

    async def _watch(self, name, handle, lane):
        was = int(handle.value) >> lane & 1
        while True:
            await handle.value_change
            now = int(handle.value) >> lane & 1
            if now != was:
                self.ns.append(get_sim_time("ns"))
                self.named.append((f"{name}{now}", self.ns[-1]))
            was = now


@cocotb.test()
async def three_axes_on_shared_pins(dut):
    """Moves at the same time, each its own way; the decoders agree with the sources."""
    shared = await pins(dut)
    sources = [QuadratureSource(*shared, axis, lines=3) for axis in range(3)]
    decoders = [QuadratureDecoder(*shared, axis, shortest_ns=90) for axis in range(3)]
    await Timer(10, "ns")
    moves = [cocotb.start_soon(s.move(n, ns))
             for s, n, ns in zip(sources, (40, -25, 7), (100, 130, 333), strict=True)]  # fmt: skip
    for move in moves:
        await move
    assert [s.count for s in sources] == [40, -25, 7] == [d.count for d in decoders]
    assert [count for ns, count in decoders[0].indices] == [12, 24, 36]
    assert decoders[0].shortest_ns == 100 and decoders[0].edges == 40


@cocotb.test()
async def edges_of_a_profile_are_where_they_belong(dut):
    """Uniform acceleration: the n-th edge at sqrt(2 (n + 1/2) / a); there and back ends at 0."""
    source = QuadratureSource(*(await pins(dut)), 1)
    edges, begin = Edges(dut, 1), get_sim_time("ns")
    await source.profile([(100e-6, 0, 800e3)])  # 40 counts, 8e9 counts/s^2
    assert get_sim_time("ns") == begin + 100e3 and source.count == 40
    for n, ns in enumerate(edges.ns):
        assert abs(ns - begin - 1e9 * math.sqrt(2 * (n + 0.5) / 8e9)) < 0.01
    await source.profile([(200e-6, 800e3, -800e3)])  # turns in the midst of it
    assert source.count == 40 and len(edges.ns) == 40 + 2 * 40
    await source.profile([(1e-6, -300e3, -300e3)] * 10 + [(37e-6, -1e6, -1e6)])
    assert source.count == 0, "thirds of a count add up"


@cocotb.test()
async def a_position_is_followed(dut):
    source = QuadratureSource(*(await pins(dut)), 2)
    decoder = QuadratureDecoder(dut.enc_a, dut.enc_b, lane=2)
    await Timer(10, "ns")
    extremes = []

    def position(t: float) -> float:
        extremes.append(source.count)
        return 50 * math.sin(2 * math.pi * 5e3 * t)

    await source.follow(position, 200e-6, 1e-6)
    assert (max(extremes), min(extremes)) == (50, -50) and source.count == decoder.count == 0
    assert decoder.edges == 200


@cocotb.test()
async def phase_and_duty_errors(dut):
    """B late by 27 degrees, 0.3 counts, and 9 degrees of duty: the same places both ways."""
    source = QuadratureSource(*(await pins(dut)), phase_error_deg=27, duty_error_deg=9)
    decoder, edges = QuadratureDecoder(dut.enc_a, dut.enc_b), Edges(dut, 0)
    await Timer(10, "ns")
    await source.move(40, 1000)
    at = dict(edges.named[-8:-4])
    late = {name: ns - at["enc_a1"] for name, ns in at.items()}
    assert late == {"enc_a1": 0, "enc_b1": 1300, "enc_a0": 2100, "enc_b0": 3400}
    await source.profile([(40e-6, -1e6, -1e6)])
    at = dict(edges.named[-8:-4])
    late = {name: round(ns - at["enc_b1"]) for name, ns in at.items()}
    assert late == {"enc_b1": 0, "enc_a1": 1300, "enc_b0": 2100, "enc_a0": 3400}
    assert decoder.count == source.count == 0 and not decoder.errors


@cocotb.test()
async def faults_are_seen(dut):
    """A glitch is two edges and no count, a jump an error; so is what comes too soon."""
    source = QuadratureSource(*(await pins(dut)))
    decoder = QuadratureDecoder(dut.enc_a, dut.enc_b, shortest_ns=50, fail=False)
    await Timer(10, "ns")
    for line in ("a", "b"):
        await source.glitch(60, line)
        await Timer(100, "ns")
    assert (decoder.count, decoder.edges, decoder.errors) == (0, 4, [])
    await source.glitch(20)
    assert len(decoder.errors) == 0
    await Timer(100, "ns")
    assert len(decoder.errors) == 1
    source.jump()
    await Timer(100, "ns")
    assert len(decoder.errors) == 2 and decoder.count == 0 and source.count == 2


@cocotb.test(expect_error=AssertionError)
async def an_illegal_transition_fails_the_test(dut):
    source = QuadratureSource(*(await pins(dut)))
    QuadratureDecoder(dut.enc_a, dut.enc_b)
    await Timer(10, "ns")
    source.jump()
    await Timer(10, "ns")


@cocotb.test()
async def volts_on_shared_pins(dut):
    """Each channel its own; full scale, its opposite, the nearest number between."""
    shared = Pins(dut.volts, width=16)
    sources = [AnalogSource(shared, n) for n in range(3)]
    sinks = [AnalogSink(dut.volts, n) for n in range(3)]
    for volts, raw in ((0, 0), (10, 32767), (-10, -32768), (2.5, 8192), (1e-4, 0), (2e-4, 1)):
        for n, source in enumerate(sources):
            source.set(volts if n == 1 else -1.25)
        await Timer(1, "ns")
        assert [s.raw() for s in sinks] == [-4096, raw, -4096]
    sources[2].raw(-5)
    await Timer(1, "ns")
    assert sinks[2].raw() == -5 and abs(sinks[2].volts() + 5 * 10 / 32768) < 1e-12
    other = AnalogSource(dut.volts, width=12, full_v=5.0)
    other.set(-2.5)
    await Timer(1, "ns")
    assert AnalogSink(dut.volts, width=12, full_v=5.0).volts() == -2.5


@cocotb.test()
async def ramps_records_and_noise(dut):
    source, sink = AnalogSource(dut.volts), AnalogSink(dut.volts)
    await Timer(1, "ns")
    sink.record()
    cocotb.start_soon(source.ramp(5, 10e-6, 1e-6))
    assert 5900 < await sink.reaches(3, within=0.01, ns=20e3) <= 6100
    await Timer(10, "us")
    assert [round(v, 2) for ns, v in sink.history] == [n / 2 for n in range(11)]
    with raises(AssertionError, "5 V after 100 ns, not 0 V within 1 V"):
        await sink.reaches(0, within=1, ns=100)
    both = []
    for seed in (1, 1, 2):
        noisy, seen = AnalogSource(dut.volts, noise_v=0.1, seed=seed), []
        for _ in range(200):
            noisy.set(9.9)
            seen.append(noisy.pins.value)
        both.append(seen)
    assert both[0] == both[1] != both[2]
    assert 32767 in both[0] and max(both[0]) <= 32767, "clipped at full scale"


@cocotb.test()
async def wrong_arguments_end_in_one_sentence(dut):
    shared = await pins(dut)
    source, analog = QuadratureSource(*shared), AnalogSource(dut.volts)
    for coroutine, kind, words in (
        (source.move(1.5, 100), TypeError, "counts is a whole number, not 1.5"),
        (source.move(1, 0), ValueError, "ns_per_count is 0.002 to"),
        (source.glitch(5, "c"), ValueError, "line is one of a, b, i, not 'c'"),
        (source.profile([(1, 2)]), TypeError, "segment 0 is (seconds, speed, speed)"),
        (source.profile([(1, 2, float("nan"))]), ValueError, "speed of segment 0"),
        (source.follow(5, 1, 1), TypeError, "position is a function of the time"),
        (source.follow(lambda t: t, 1.0, 2.0), ValueError, "step_s is"),
        (analog.ramp(11, 1, 1), ValueError, "volts is -10 to 10, not 11"),
        (analog.sine(9, 1, 1, 1, offset=2), ValueError, "amplitude and offset is 0 to 10"),
    ):
        with raises(kind, words):
            await coroutine
    refused(
        (ValueError, "lane is 0 to 2, not 3", lambda: QuadratureSource(*shared, 3)),
        (ValueError, "lines, the index's, needs the signal i", lambda: QuadratureSource(
            *shared[:2], lines=5)),
        (ValueError, "phase and duty error together", lambda: QuadratureSource(
            *shared, phase_error_deg=30, duty_error_deg=-20)),
        (ValueError, "direction is one of 1, -1, not 2", lambda: source.step(2)),
        (ValueError, "volts is -10 to 10, not 10.5", lambda: analog.set(10.5)),
        (TypeError, "volts is a number, not '1'", lambda: analog.set("1")),
        (ValueError, "value is -32768 to 0x7fff, not 0x8000", lambda: analog.raw(0x8000)),
        (ValueError, "pins of 1 lines a channel, not 16", lambda: AnalogSource(shared[0])),
        (ValueError, "lane is 0 to 2, not 3", lambda: AnalogSink(dut.volts, 3)),
    )  # fmt: skip
