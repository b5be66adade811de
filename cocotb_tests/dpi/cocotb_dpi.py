# SPDX-License-Identifier: Apache-2.0
"""The firmware drives the machine through DPI, and everything on its buses is watched. §4.3, §5.3

The C driver, the engine's bus master and a motor are behind sim/dpi/mmcs_tb.sv; a test only looks
on: the rules of both buses, timing, address mapping and the interrupt latch. What the host says it
did (bus.csv) is what was seen.
"""

import csv
import os
from pathlib import Path

import cocotb
from cocotb.triggers import RisingEdge
from cocotb.utils import get_sim_time
from cocotbext.pcbus import PcBus, PcBusMonitor
from cocotbext.vme import VmeBus, VmeMonitor

from cocotb_tests.lib.req import test
from mmcs import regs

TOPLEVEL = "mmcs_tb"
PASSES = 1000 if os.environ.get("MMCS_LONG") == "1" else 100  # of the servo, 1 ms each
PARAMETERS = {"NumCards": 1}
DPI = {"": ("lab500", "motion.0.at=0.005", f"duration={PASSES / 1000}")}

CLK_NS = 125
FIRST_CLK = 64  # of the engine, counted from the first edge
WINDOW = 0x6000
ADAPTOR = 0x400  # A10
PCCSR, VECTOR = WINDOW + regs.PCCSR, WINDOW + regs.VECTOR
LEVEL = 5
INTERVAL_NS = 1_000_000
LATCH_NS = 4 * CLK_NS  # SCLOCK at the pin to IRQ5*
ANSWER_NS = 16 * CLK_NS  # a strobe to its DTACK*, PC-bus cycle included
LATENCY_NS = 100_000 + 2 * ANSWER_NS  # what the scenario's host takes at most, and a cycle


class Lines:
    """Every edge of a line: when, and to which level."""

    def __init__(self, handle, bit: int | None = None):
        self.edges, self._handle, self._bit = [], handle, bit
        cocotb.start_soon(self._watch())

    async def _watch(self):
        last = None
        while True:
            await self._handle.value_change
            value = int(self._handle.value)
            level = value if self._bit is None else value >> self._bit & 1
            if level != last:
                self.edges.append((get_sim_time("ns"), level))
            last = level

    def to(self, level: int) -> list[float]:
        return [t for t, value in self.edges if value == level]


class Watched:
    """What was seen until the program had ended."""

    def __init__(self, dut):
        u = dut.u_mmcs
        self.vme = VmeMonitor(VmeBus.from_prefix(u, "vme"))
        self.pc = PcBusMonitor(
            PcBus(a=u.pcx_a_o, aen=u.pcx_aen_o, ior_n=u.pcx_ior_no, iow_n=u.pcx_iow_no,
                  d=u.pcx_d_o, q=u.pc_rdata, q_oe=u.u_cards.card_d_oe)
        )  # fmt: skip
        self.sclock, self.irq = Lines(u.sclock_o), Lines(u.vme_irq_no, LEVEL - 1)
        self.done = dut.done

    async def to_the_end(self):
        await RisingEdge(self.done)
        with Path("bus.csv").open() as file:
            self.said = list(csv.DictReader(file))

    # --- the host, cycle by cycle ---

    def check_cycles(self, least: int):
        """Kind, address, data and both clocks of every cycle are those that the host tells."""
        assert len(self.said) == len(self.vme.cycles) >= least
        for said, seen in zip(self.said, self.vme.cycles, strict=True):
            kind = {"acknowledge": "iack"}.get(said["cycle"], said["cycle"])
            address = int(said["address"], 16) | 1
            assert (seen.kind, seen.address, seen.am) == (kind, address, int(said["am"], 16))
            assert (seen.size, seen.data) == (1, int(said["data"], 16) & 0xFF)
            assert (seen.outcome, said["answer"]) == ("DTACK*", "DTACK")
            begin, end = (self._clock_ns(said[name]) for name in ("begin_clock", "end_clock"))
            assert seen.start == begin + CLK_NS  # the strobe, a clock behind its address
            assert seen.answer == end - CLK_NS  # the host sees it at the next edge

    @staticmethod
    def _clock_ns(clock: str) -> float:
        return CLK_NS / 2 + CLK_NS * (FIRST_CLK + int(clock))

    # --- address mapping ---

    def check_mapping(self):
        """A cycle with A10 = 0 is one PC-bus cycle at its place, any other is none. MAP-1, VME-4"""
        base, left, cards = 0, list(self.pc.cycles), 0
        for cycle in self.vme.cycles:
            inside = []
            while left and left[0].start < cycle.answer:
                inside.append(left.pop(0))
            if cycle.kind == "iack" or cycle.address & ADAPTOR:
                assert not inside
                if cycle.kind == "write" and cycle.address == PCCSR:
                    base = cycle.data & 0x1F
                continue
            assert len(inside) == 1
            pc, cards = inside[0], cards + 1
            low, high = cycle.address >> 1 & 0x1F, cycle.address >> 6 & 0xF
            assert pc.address == low | base << 5 | high << 10
            assert (pc.kind, pc.data) == (cycle.kind, cycle.data)
            assert cycle.start < pc.start
        assert not left
        assert cards > len(self.vme.cycles) / 4

    # --- timing ---

    def check_timing(self, passes: int):
        """SCLOCK to the nanosecond, answers and the host's latency within their limits."""
        rises = self.sclock.to(1)[-passes:]
        assert len(rises) == passes
        assert {b - a for a, b in zip(rises, rises[1:], strict=False)} == {INTERVAL_NS}
        assert max(c.answer - c.start for c in self.vme.cycles) <= ANSWER_NS
        falls = iter(self.irq.to(0))
        for cycle in self._acknowledges():
            assert 0 < cycle.start - next(falls) <= LATENCY_NS

    def _acknowledges(self):
        return [c for c in self.vme.cycles if c.kind == "iack"]

    # --- the interrupt latch ---

    def check_latch(self, passes: int):
        """An SCLOCK edge is latched while PCCSR bit 7 is set, and held until the register is
        written; the acknowledge, at level 5, has the vector and releases nothing. INT-1, INT-2"""
        writes = [c for c in self.vme.cycles if c.kind == "write" and c.address == PCCSR]
        vectors = [c.data for c in self.vme.cycles if c.kind == "write" and c.address == VECTOR]
        armed = regs.PCCSR_LATCH_EN_BM | regs.PCCSR_SCLOCK_EN_BM
        latched = 0
        rises = self.irq.to(1)
        for edge in self.sclock.to(1):
            before = [c for c in writes if c.answer < edge]
            busy = any(c.start <= edge <= c.end for c in writes)
            if busy or not before or before[-1].data & armed != armed:
                continue
            latched += 1
            level = next((v for t, v in reversed(self.irq.edges) if t <= edge + LATCH_NS), 1)
            assert level == 0, f"SCLOCK at {edge} ns was not latched"
        assert latched >= passes
        for t in rises[1:]:  # the first is the reset's
            clearing = [c for c in writes if c.start <= t <= c.end]
            assert clearing, f"IRQ5* rose at {t} ns with no write of PCCSR"
            assert not clearing[0].data & regs.PCCSR_LATCH_EN_BM
        for cycle in self._acknowledges():
            assert (cycle.address >> 1 & 7, cycle.data) == (LEVEL, vectors[-1])
        assert len(self._acknowledges()) >= passes


async def watch(dut, passes: int):
    seen = Watched(dut)
    await seen.to_the_end()
    seen.check_cycles(20 * passes)
    seen.check_mapping()
    seen.check_timing(passes)
    seen.check_latch(passes)


@test("VME-3", "VME-4", "VME-5", "MAP-1", "PCB-1", "INT-1", "INT-2", "FW-1")
async def everything_the_firmware_does_keeps_the_rules(dut):
    """From power-on over a hundred servo passes; MMCS_LONG=1: a thousand."""
    await watch(dut, PASSES - 10)
