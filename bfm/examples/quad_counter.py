# SPDX-License-Identifier: Apache-2.0
"""The encoder models on quad_counter.sv: a move, a trapezoid, a sine, an index, an error."""

import math

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, Timer
from cocotbext.quadrature import QuadratureDecoder, QuadratureSource

TOPLEVEL = "quad_counter"


@cocotb.test()
async def counts_what_turns(dut):
    Clock(dut.clk_i, 100, "ns").start()
    dut.rst_ni.value = dut.home_i.value = 0
    pins = dut.a_i, dut.b_i, dut.i_i
    encoder = QuadratureSource(*pins, lines=100, phase_error_deg=20, duty_error_deg=10)
    decoder = QuadratureDecoder(*pins, shortest_ns=300, fail=False)
    await ClockCycles(dut.clk_i, 4)
    dut.rst_ni.value = 1

    async def counted() -> int:
        await ClockCycles(dut.clk_i, 4)
        return dut.count_o.value.to_signed()

    await encoder.move(37, ns_per_count=500)
    assert await counted() == encoder.count == 37
    # up to 200,000 counts a second, on, and down again: 60 counts in all
    await encoder.profile([(200e-6, 0, 200e3), (100e-6, 200e3, 200e3), (200e-6, 200e3, 0)])
    assert await counted() == encoder.count == 97
    # two periods of +-30 counts about where it stands
    wave = lambda t: 30 * math.sin(2 * math.pi * 4000 * t)  # noqa: E731
    await encoder.follow(wave, seconds=500e-6, step_s=2e-6)
    assert await counted() == decoder.count == 97 and not decoder.errors

    dut.home_i.value = 1
    await encoder.move(-100, 500)  # through the index at 0
    assert await counted() == encoder.count == -3
    assert decoder.indices[-1][1] == 0

    encoder.jump()
    await Timer(1, "us")
    assert int(dut.error_o.value) and len(decoder.errors) == 1
