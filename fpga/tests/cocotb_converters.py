# SPDX-License-Identifier: Apache-2.0
"""The module between a card and two SPI converters, with models of both from their data sheets."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import Timer

from fpga.tests.converters import Dac8568, Mcp3208

PERIOD_NS = 41.666
SLOTS_US = 140  # two joints, twice


class Converters:
    """The module in run, the D/A's reference on; volts are those of the card's pins."""

    def __init__(self, dut):
        self.dut, self.random = dut, random.Random(1989)

    async def begin(self):
        dut = self.dut
        Clock(dut.clk_i, round(PERIOD_NS * 1000 / 2) * 2, "ps").start()
        self.mcp3208 = Mcp3208(dut, [0x800] * 8)
        self.dac8568 = Dac8568(dut)
        dut.drive_v_i.value = 0
        dut.rst_ni.value = dut.run_i.value = 0
        await Timer(1, "us")
        dut.rst_ni.value = 1
        await Timer(SLOTS_US, "us")
        dut.run_i.value = 1
        await Timer(SLOTS_US, "us")
        return self

    async def drive(self, *codes: int):
        """Codes of 16 bits, offset binary, joint 1 first."""
        self.dut.drive_v_i.value = (codes[1] ^ 0x8000) << 16 | codes[0] ^ 0x8000
        await Timer(SLOTS_US, "us")


@cocotb.test()
async def codes_reach_the_converters(dut):
    """Out of the D/A and into the A/D, both joints, the ends and the middle included."""
    tb = await Converters(dut).begin()
    assert tb.dac8568.reference
    ends = [(0x0000, 0xFFF0), (0xFFF0, 0x0000), (0x8000, 0x8010)]
    some = [(tb.random.randrange(4096) << 4, tb.random.randrange(4096) << 4) for _ in range(8)]
    for codes in (*ends, *some):
        await tb.drive(*codes)
        assert tb.dac8568.value == dict(enumerate(codes)), codes
        tb.mcp3208.codes[:2] = [code >> 4 for code in codes]
        await Timer(SLOTS_US, "us")
        seen = int(dut.adc_v_o.value)
        assert tuple((seen >> 16 * n & 0xFFFF) ^ 0x8000 for n in (0, 1)) == codes, f"{seen:08X}"
    assert set(tb.mcp3208.reads) == {0, 1}


@cocotb.test()
async def the_end_of_run_takes_the_torque_away(dut):
    """At once and without a clock, both joints, and they stay at zero until run is back."""
    tb = await Converters(dut).begin()
    zero = {0: 0x8000, 1: 0x8000}
    await tb.drive(0x1230, 0xEDC0)
    assert tb.dac8568.value == {0: 0x1230, 1: 0xEDC0}
    dut.run_i.value = dut.drive_v_i.value = 0  # a machine in reset drives nothing
    await Timer(10, "ns")
    assert tb.dac8568.value == zero
    for _ in range(20):
        await Timer(SLOTS_US // 10, "us")
        assert tb.dac8568.value == zero
    dut.run_i.value = 1
    for _ in range(20):
        await Timer(SLOTS_US // 10, "us")
        assert tb.dac8568.value == zero


@cocotb.test()
async def the_first_clear_does_not_mean_the_lowest_voltage(dut):
    """A D/A that has just got power clears to the lowest: CLR# stays high until it was told."""
    Dac8568.value, Dac8568._clear = {0: 0x8000, 1: 0x8000}, 0x0000
    tb = Converters(dut)
    Dac8568._input, Dac8568.reference = {}, False
    await tb.begin()
    assert tb.dac8568.value == {0: 0x8000, 1: 0x8000} and tb.dac8568._clear == 0x8000
