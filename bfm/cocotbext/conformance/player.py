# SPDX-License-Identifier: Apache-2.0
"""The cocotb test that plays rows on a core behind its wrapper, and writes what was wrong."""

import json
import os
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import Timer

from . import CHIPS

PERIOD_NS = 10


class Unfit(Exception):
    """The wrapper has not the pins of the chip."""


class Wrapper:
    def __init__(self, dut, script, settle: int) -> None:
        self.dut, self.settle = dut, settle
        self.inputs, self.outputs = (
            {name: self._port(*port) for name, port in ports.items()} for ports in script.ports()
        )
        self.rst_n, self.clk = self._port("sys_rst_n", 1), self._port("sys_clk", 1)

    def _port(self, name: str, width: int):
        port = getattr(self.dut, name, None)
        if port is None:
            raise Unfit(f"has no port {name}: give it one, of {width} bits")
        if len(port) != width:
            raise Unfit(f"has a port {name} of {len(port)} bits: make it {width}")
        return port

    async def clocks(self, number: int) -> None:
        await Timer(number * PERIOD_NS, "ns")

    async def play(self, script) -> str:
        """Nothing, or the first expectation that does not hold."""
        for name, level in script.IDLE.items():
            if name in self.inputs:
                self.inputs[name].value = level
        self.rst_n.value = 0
        await self.clocks(2 * self.settle)
        self.rst_n.value = 1
        await self.clocks(self.settle)
        for kind, what, more in script.actions:
            if kind == "pins":
                for name, level in what.items():
                    self.inputs[name].value = level
                await self.clocks(max(more, self.settle))
                continue
            seen = {}
            for name, port in self.outputs.items():
                level = port.value
                seen[name] = int(level) if level.is_resolvable else None
            if wrong := script.wrong(what, seen):
                return ": ".join(filter(None, (more.strip(), wrong)))
        return ""


@cocotb.test()
async def rows(dut) -> None:
    asked = json.loads(Path(os.environ["CONFORMANCE"]).read_text())
    kind = CHIPS[asked["chip"]]
    kind.PULSE = asked["pulse"]
    found = {}
    try:
        wrapper = Wrapper(dut, kind(asked["variant"]), asked["settle"])
        Clock(wrapper.clk, PERIOD_NS, "ns", impl="gpi").start()
        await Timer(PERIOD_NS * 3 // 4, "ns")  # pins change between the edges of the clock
        for row in kind.ROWS:
            if row.name in asked["rows"]:
                found[row.name] = await wrapper.play(row.put(kind(asked["variant"])))
    except Unfit as error:
        found = {"": str(error)}
    Path(asked["found"]).write_text(json.dumps(found))
