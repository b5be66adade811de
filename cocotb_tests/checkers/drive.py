# SPDX-License-Identifier: Apache-2.0
"""Drives a checker alone: pins by name, clock by clock, and which rules it holds broken."""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, ReadOnly, RisingEdge, Timer


class Pins:
    """The inputs of a checker. Changes are made on falling edges, far from any sampling."""

    def __init__(self, dut, idle: dict[str, int]):
        self.dut, self.idle = dut, idle

    async def start(self):
        self.dut.rst_ni.value = 0
        self.put(**self.idle)
        Clock(self.dut.clk_i, 125, "ns").start()
        for _ in range(3):
            await FallingEdge(self.dut.clk_i)
        self.dut.rst_ni.value = 1
        await self.step(3)
        return self

    def put(self, **pins: int) -> None:
        for name, value in pins.items():
            getattr(self.dut, name).value = value

    async def step(self, clocks: int = 1, **pins: int) -> None:
        """Sets pins, then lets so many rising edges see them."""
        self.put(**pins)
        for _ in range(clocks):
            await FallingEdge(self.dut.clk_i)

    async def broken(self) -> set[int]:
        await RisingEdge(self.dut.clk_i)
        await RisingEdge(self.dut.clk_i)
        await ReadOnly()
        bits = int(self.dut.broken_o.value)
        await FallingEdge(self.dut.clk_i)
        return {n for n in range(len(self.dut.broken_o)) if bits >> n & 1}


class Timed(Pins):
    """Of a checker of times: nanosecond by nanosecond, and rules by name."""

    def __init__(self, dut, idle: dict[str, int], names: list[str]):
        super().__init__(dut, idle)
        self.names = names

    async def after(self, ns: float, **pins: int) -> None:
        if ns:
            await Timer(int(ns * 1000), "ps")
        self.put(**pins)

    async def start(self):
        self.put(rst_ni=0, **self.idle)
        await self.after(100, rst_ni=1)
        await Timer(100, "ns")
        return self

    async def broken(self) -> list[str]:
        await Timer(1, "ns")
        await ReadOnly()
        bits = int(self.dut.broken_o.value)
        return [name for n, name in enumerate(self.names) if bits >> n & 1]


async def expect(pins: Pins, stimulus, *rules: int) -> None:
    """Runs the stimulus and wants exactly these rules broken: no other, so none is vague."""
    await pins.start()
    await stimulus(pins)
    found = await pins.broken()
    assert found == set(rules), f"broken {sorted(found)}, expected {sorted(rules)}"
    cocotb.log.info("broken, as it must be: %s", sorted(found))
