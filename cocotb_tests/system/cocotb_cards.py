# SPDX-License-Identifier: Apache-2.0
"""Cards beside each other, and beside a third-party card on the expansion connector. §4.2.2, §5.3

The third-party card: a register of eight outputs that reads back, and an identity.
"""

import cocotb
from cocotb.triggers import Timer
from cocotbext.pcbus import PcBus, PcBusSlave

from cocotb_tests.card.host import TOPLEVEL as TOPS
from cocotb_tests.card.host import Rack, rack_test
from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import BASE, LATCH_ALL, PCCSR, PORT_A, QUAD, dip
from cocotb_tests.system.machine import USUAL

TOPLEVEL = TOPS["vme"]
VARIANTS = {"vme": USUAL}
OTHER = 0x2A0  # the third-party card's address
OTHER_BASE = OTHER >> 5  # what PCCSR bits 4-0 must be
OUT, IDENTITY = 0x001, 0x007  # VME offsets of its registers, A09-A06 = 0
LIMIT = 10  # of IOCHRDY, in CLK


async def with_other(dut) -> Rack:
    tb = await Rack(dut).start()
    tb.other = PcBusSlave(PcBus.from_prefix(dut, "pcx"), base=OTHER, size=4)
    tb.other.registers[3] = 0xD1
    await tb.wr(PCCSR, OTHER_BASE)
    return tb


other_test = tests_on(with_other, "vme")


@rack_test("LAT-1")
async def no_skew_between_cards(tb):
    """All six encoders run; SCLOCK and 0x12 take all counts on the same clock."""
    for axis in range(6):
        await tb.preset(axis, 0)
    stop = []

    async def run():
        while not stop:
            for e in tb.enc:
                e.step(1)
            await Timer(300, "ns")

    task = cocotb.start_soon(run())
    for how in ("sclock", "all", "sclock", "all"):
        await tb.us(3)
        if how == "sclock":
            await tb.pulse()
        else:
            await tb.cwr(0, LATCH_ALL, 0)
        counts = set(await tb.counts())
        assert len(counts) == 1, f"{how}: {counts}"
    stop.append(1)
    await task


@rack_test("PCB-2", "CRD-1")
async def two_cards_with_one_address(dut, tb):
    """Card 2's DIP switch set like card 1's: data is the AND of both, both take writes."""
    await tb.cwr(1, PORT_A, 0xF5)
    await tb.cwr(2, PORT_A, 0x3D)
    dut.dip_i.value = dip(0, 1, 1)
    await tb.clocks(2)
    assert await tb.crd(1, PORT_A) == 0xF5 & 0x3D
    assert await tb.crd(2, PORT_A) == 0xFF
    await tb.cwr(1, PORT_A, 0x0D)
    dut.dip_i.value = dip(0, 1, 2)
    await tb.clocks(2)
    assert [await tb.crd(c, PORT_A) for c in range(3)] == [QUAD, 0x0D, 0x0D]


@other_test("PCB-2", "CRD-1", "MAP-1")
async def the_bases_do_not_meet(tb):
    """At no base but theirs do the Mark I cards and the third-party card answer or take a write."""
    for base in range(32):
        await tb.wr(PCCSR, base)
        assert await tb.rd(IDENTITY) == {OTHER_BASE: 0xD1}.get(base, 0xFF)
        if base not in (BASE, OTHER_BASE):
            await tb.cwr(0, PORT_A, 0xAA)
            assert await tb.crd(0, PORT_A) == 0xFF
    assert not tb.other.writes
    await tb.wr(PCCSR, BASE)
    assert [await tb.crd(card, PORT_A) for card in range(3)] == [QUAD] * 3


@other_test("PCB-1", "PCB-2", "VME-4")
async def wait_states(tb):
    """IOCHRDY stretches reads and writes by whole CLKs and is given up at the limit."""
    monitor = tb.pc_monitor()
    lengths = []
    for waits in range(16):
        tb.other.wait_ns = (max(0, 125 * waits - 60),) * 2
        monitor.cycles.clear()
        await tb.wr(OUT, 0xA0 + waits)
        value = await tb.rd(OUT)
        write, read = monitor.cycles
        lengths.append(read.command)
        assert write.command == read.command
        # Four CLKs of command and the limit; a clock more or less depends on the phase of CLK.
        if abs(waits - 4 - LIMIT) > 1:
            assert value == (0xFF if waits > 4 + LIMIT else 0xA0 + waits)
        assert read.command >= min(waits * 125, 500)
    assert lengths == sorted(lengths) and lengths[0] == 500 and lengths[12] > lengths[6]


@other_test("PCB-2", "VME-3")
async def mixed_traffic(tb):
    """Both kinds of card in turn, with wait states: neither disturbs the other."""
    out, port = 0, QUAD
    for _ in range(60):
        value = tb.random.getrandbits(8)
        if tb.random.randrange(2):
            await tb.wr(PCCSR, OTHER_BASE)
            tb.other.wait_ns = (0, 125 * tb.random.randrange(1, 12))
            assert await tb.rd(OUT) == out
            await tb.wr(OUT, value)
            out = value
        else:
            await tb.wr(PCCSR, BASE)
            assert await tb.crd(0, PORT_A) == port
            await tb.cwr(0, PORT_A, value)
            port = value
    assert tb.other.registers[0] == out
