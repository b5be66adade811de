# SPDX-License-Identifier: Apache-2.0
"""Drives a checker alone: pins by name, clock by clock, and which rules it holds broken."""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, ReadOnly, RisingEdge, Timer

from cocotb_tests.lib.play import play

BENCH = (
    "bench_checkers",
    ("bench_checkers.sv", *(f"../../rtl/checkers/{file}.sv" for file in (
        "pcbus_checker", "pcbus_timing", "vme_claim_checker", "vme_edge_checker",
        "vme_master_checker", "vme_slave_checker", "vme_timing"))),
)  # fmt: skip
# Both buses at rest.
IDLE = {
    "vme_a_i": 0, "vme_am_i": 0x29, "vme_as_ni": 1, "vme_ds_ni": 3, "vme_write_ni": 1,
    "vme_lword_ni": 1, "vme_iack_ni": 1, "vme_iackin_ni": 1, "vme_iackout_no": 1,
    "vme_sysreset_ni": 1, "vme_d_i": 0, "vme_irq_no": 0x7F, "vme_d_oe_o": 0, "vme_d_o": 0xFF,
    "vme_dtack_no": 1,
    "link_ok_i": 1, "pc_a_i": 0x300, "pc_d_i": 0xFF, "pc_rdata_i": 0xFF, "pc_ior_ni": 1,
    "pc_iow_ni": 1, "pc_aen_i": 0, "drivers_i": 0, "driven_i": 0,
}  # fmt: skip


class Pins:
    """The inputs of a checker. Changes are made on falling edges, far from any sampling."""

    def __init__(self, dut, checker: str, **others: int):
        self.dut, self.checker = dut, checker
        self.idle = {name: v for name, v in IDLE.items() if hasattr(dut, name)} | others

    async def start(self):
        self.dut.rst_ni.value = 0
        self.put(**self.idle)
        Clock(self.dut.clk_i, 125, "ns").start()
        for _ in range(3):
            await FallingEdge(self.dut.clk_i)
        self.dut.rst_ni.value = 1
        await self.wait(3)
        return self

    def put(self, **pins: int) -> None:
        for name, value in pins.items():
            getattr(self.dut, name).value = value

    async def wait(self, clocks: float) -> None:
        """Lets so many rising edges see the pins."""
        for _ in range(int(clocks)):
            await FallingEdge(self.dut.clk_i)

    async def play(self, text: str) -> None:
        """As play() says; a pin without the prefix of its bus."""
        others = "pc_" if self.checker.startswith("vme_") else "vme_"
        names = [name for name in self.idle if not name.startswith(others)]
        full = {name.removeprefix("vme_").removeprefix("pc_"): name for name in names}
        await play(text, lambda name, value: self.put(**{full[name]: value}), self.wait)

    async def broken(self) -> set[int]:
        await RisingEdge(self.dut.clk_i)
        await RisingEdge(self.dut.clk_i)
        await ReadOnly()
        bits = self.bits()
        await FallingEdge(self.dut.clk_i)
        return {n for n in range(bits.bit_length()) if bits >> n & 1}

    def bits(self) -> int:
        """The rules that the checker reports, one bit each."""
        return int(getattr(self.dut, f"{self.checker}_o").value)


class Timed(Pins):
    """Of a checker of times: nanosecond by nanosecond, and rules by name."""

    def __init__(self, dut, checker: str, names: list[str]):
        super().__init__(dut, checker)
        self.names = names

    async def wait(self, ns: float) -> None:
        if ns:
            await Timer(int(ns * 1000), "ps")

    async def after(self, ns: float, **pins: int) -> None:
        await self.wait(ns)
        self.put(**pins)

    async def start(self):
        self.put(rst_ni=0, **self.idle)
        await self.after(100, rst_ni=1)
        await Timer(100, "ns")
        return self

    async def broken(self) -> list[str]:
        await Timer(1, "ns")
        await ReadOnly()
        bits = self.bits()
        await Timer(1, "ns")
        return [name for n, name in enumerate(self.names) if bits >> n & 1]


async def expect(pins: Pins, stimulus: str, *rules: int) -> None:
    """Plays the stimulus and wants exactly these rules broken: no other, so none is vague."""
    await pins.start()
    await pins.play(stimulus)
    found = await pins.broken()
    assert found == set(rules), f"broken {sorted(found)}, expected {sorted(rules)}"
    cocotb.log.info("broken, as it must be: %s", sorted(found))


async def broken_by(dut, checker: str, names: list[str], stimulus: str) -> list[str]:
    """The rules, by their names, that a stimulus in ns breaks."""
    pins = await Timed(dut, checker, names).start()
    await pins.play(stimulus)
    return await pins.broken()
