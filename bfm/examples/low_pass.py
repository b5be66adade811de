# SPDX-License-Identifier: Apache-2.0
"""The analog models on low_pass.sv: a step, a ramp, a sine that comes out smaller."""

import math

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, Timer
from cocotbext.analog import AnalogSink, AnalogSource

TOPLEVEL = "low_pass"


@cocotb.test()
async def step_ramp_and_sine(dut):
    Clock(dut.clk_i, 1, "us").start()
    dut.rst_ni.value = 0
    source, sink = AnalogSource(dut.vin_i), AnalogSink(dut.vout_o)
    await ClockCycles(dut.clk_i, 2)
    dut.rst_ni.value = 1

    source.set(5.0)
    rise = await sink.reaches(5.0 * (1 - math.exp(-1)), within=0.1, ns=100e3)
    assert 14e3 < rise < 18e3  # the time constant: 16 us
    await sink.reaches(5.0, within=0.01, ns=200e3)

    await source.ramp(-5.0, seconds=1e-3, step_s=1e-6)
    assert 0.1 < sink.volts() + 5.0 < 0.2  # behind by 16 us of 10 V a ms

    await Timer(200, "us")
    sink.record()
    await source.sine(4.0, hz=10e3, seconds=400e-6, step_s=1e-6, offset=1.0)
    top = max(volts for ns, volts in sink.history[len(sink.history) // 2 :])
    assert abs(top - 1.0 - 4.0 / math.sqrt(1 + (2 * math.pi * 0.16) ** 2)) < 0.1
