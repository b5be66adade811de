# SPDX-License-Identifier: Apache-2.0
"""The adaptor among masters and neighbours that break the rules of the acknowledge cycle. §4.3.6

The bus checkers of the whole machine would stop such a bus, so the adaptor stands here alone.
"""

import cocotb
from cocotb.triggers import FallingEdge, First, RisingEdge, Timer
from cocotb.utils import get_sim_time
from cocotbext.vme import VmeBus, VmeMaster

from cocotb_tests.lib.play import drive
from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import ARMED, BASE, PCCSR, SCLOCK_IRQ, VECTOR, Tb

TOPLEVEL = "adaptor_vme"
SOURCES = ("../edges/mmcs_sync.sv",)
VEC = 0xC5


class Adaptor(Tb):
    """The adaptor behind its VME connector; its latch of SCLOCK is set and asks."""

    async def start(self):
        await super().start()
        self.bus = VmeBus.from_prefix(self.dut, "vme")
        self.vme = VmeMaster(self.bus)
        await self.vme.write(0x6000 | VECTOR, VEC)
        await self.vme.write(0x6407, 0x70)  # timer 1, mode 0: SCLOCK falls
        await self.vme.write(0x6000 | PCCSR, ARMED | SCLOCK_IRQ | BASE)
        await self.vme.write(0x6407, 0x74)  # mode 2: it rises
        await self.clocks(4)
        assert int(self.dut.vme_irq_no.value) == 0x7F & ~(1 << 4)
        return self

    async def acknowledge(self, level: int) -> None:
        """IACKIN* of a level comes down; DS0* stays high."""
        bus = self.bus
        await drive(bus, f"a={level} lword_n=1 write_n=1 iack_n=0 40 as_n=0 20 iackin_n=0 400")

    async def end(self) -> None:
        bus = self.bus
        bus.ds_n.value, bus.as_n.value, bus.iackin_n.value, bus.iack_n.value = 3, 1, 1, 1
        await self.clocks(6)
        assert int(self.dut.vme_dtack_no.value) and not int(self.dut.vme_d_oe_o.value)
        assert await self.vme.iack(5) & 0xFF == VEC, "nothing is left of it"


adaptor_test = tests_on(Adaptor)


@adaptor_test("INT-2")
async def one_answer_to_one_iackin(dut, tb):
    """A second strobe under the same IACKIN* is neither answered nor passed on."""
    for ns in (300, 700):
        await tb.acknowledge(5)
        tb.bus.ds_n.value = 0b10
        await First(FallingEdge(dut.vme_dtack_no), Timer(1, "us"))
        assert not int(dut.vme_dtack_no.value)
        await drive(tb.bus, f"30 ds_n=0b11 {ns}")
        for level in (0b10, 0b11):
            tb.bus.ds_n.value = level
            for _ in range(7):
                await Timer(100, "ns")
                assert int(dut.vme_dtack_no.value), f"answered twice, {ns} ns later"
                assert int(dut.vme_iackout_no.value), f"passed on as well, {ns} ns later"
        await tb.end()


@adaptor_test("INT-2")
async def iackin_that_lingers_passes_nothing_on(dut, tb):
    """AS* rises and falls again before IACKIN* has risen: that cycle gets no IACKOUT*."""
    for ns in (260, 500):
        await tb.acknowledge(3)
        assert not int(dut.vme_iackout_no.value), "another level's: passed on"
        for level in (1, 0, 1):
            await drive(tb.bus, f"as_n={level} {ns}")
            assert int(dut.vme_iackout_no.value), f"AS* {level}"
        await tb.end()


OURS = (0x6000 | PCCSR) >> 1


async def answered(dut, ns: int) -> bool:
    await First(FallingEdge(dut.vme_dtack_no), Timer(ns, "ns"))
    return not int(dut.vme_dtack_no.value)


@adaptor_test("VME-3")
async def strobe_that_stands_through_reset(dut, tb):
    """Power-on ends while somebody's strobe stands: it is not ours, whatever AS* does then."""
    bus = tb.bus
    bus.am.value, bus.lword_n.value, bus.write_n.value = 0x2D, 1, 1
    await drive(bus, f"a={OURS} 30 ds_n=0b10 100")
    dut.rst_ni.value = 0
    await tb.clocks(2)
    dut.rst_ni.value = 1
    await drive(bus, "300 as_n=0")
    assert not await answered(dut, 1200), "the strobe that stood"
    await drive(bus, "ds_n=0b11 30 ds_n=0b10")
    assert await answered(dut, 1200), "the next strobe"


@adaptor_test("INT-2")
@cocotb.parametrize(line=["ds_n", "as_n", "iackin_n"])
async def acknowledge_that_goes_before_the_answer(dut, tb, line):
    """DS0*, AS* or IACKIN* may rise at any time before DTACK* falls; then it does not fall."""
    bus, early = tb.bus, 0
    for ns in range(126, 500, 5):  # never with the clock
        await tb.acknowledge(5)
        await RisingEdge(dut.clk_i)
        bus.ds_n.value = 0b10
        if await answered(dut, ns):
            break
        early += 1
        getattr(bus, line).value = 0b11 if line == "ds_n" else 1
        assert not await answered(dut, 500), f"{line} rose {ns} ns after DS0* fell"
        await tb.end()
    assert early > 20
    await Timer(30, "ns")
    await tb.end()


@adaptor_test("INT-2")
async def iackin_without_iack_is_not_ours(dut, tb):
    """A neighbour that pulls IACKIN* in a transfer: passed on, whatever the address, and if IACK*
    comes after, that was decided."""
    bus = tb.bus
    await drive(bus, "a=5 lword_n=1 write_n=1 40 as_n=0 iackin_n=0 400")
    assert not int(dut.vme_iackout_no.value)
    await drive(bus, "iack_n=0 40 ds_n=0b10")
    assert not await answered(dut, 1200)
    await tb.end()


@adaptor_test("VME-3")
async def sysreset_ends_an_answer(dut, tb):
    """Three clocks into SYSRESET* DTACK* is high and no data are driven, and both stay so, whatever
    a transfer has come to."""
    bus, answers = tb.bus, set()
    bus.am.value, bus.lword_n.value, bus.write_n.value, bus.a.value = 0x2D, 1, 1, OURS
    for clocks in range(1, 16):
        await RisingEdge(dut.clk_i)
        await drive(bus, "1 as_n=0 ds_n=0b10")
        await tb.clocks(clocks)
        await Timer(1, "ns")
        dut.vme_sysreset_ni.value = 0
        answers.add(int(dut.vme_dtack_no.value))
        await tb.clocks(3)
        for _ in range(8):
            await Timer(1, "ns")
            assert int(dut.vme_dtack_no.value), f"SYSRESET* {clocks} clocks after the strobe"
            assert not int(dut.vme_d_oe_o.value), f"SYSRESET* {clocks} clocks after the strobe"
            await tb.clocks(1)
        bus.as_n.value, bus.ds_n.value = 1, 0b11
        await tb.clocks(40)
        dut.vme_sysreset_ni.value = 1
        await tb.clocks(4)
    assert answers == {0, 1}, "before and after the answer"


@adaptor_test("INT-2")
async def iackin_before_as(dut, tb):
    """A chain that is early is passed on under AS* only, of our level or another."""
    bus = tb.bus
    bus.lword_n.value, bus.write_n.value, bus.iack_n.value = 1, 1, 0
    for level in (3, 5):
        bus.a.value, bus.iackin_n.value = level, 0
        for _ in range(8):
            await Timer(100, "ns")
            assert int(dut.vme_iackout_no.value), f"level {level}: no AS* yet"
        await drive(bus, "as_n=0 400")
        assert not int(dut.vme_iackout_no.value), f"level {level}: decided as IACKIN* fell"
        bus.as_n.value, bus.iackin_n.value = 1, 1
        await tb.clocks(4)
    await tb.end()


@adaptor_test("VME-3")
async def the_later_strobe_begins_the_cycle(dut, tb):
    """DS0* alone under our address begins nothing, however long it stands. When AS* comes, it
    passes as many flip-flops as DS0* does: the answer takes as long from the later one."""
    bus, took = tb.bus, []
    bus.am.value, bus.lword_n.value, bus.write_n.value, bus.a.value = 0x2D, 1, 1, OURS
    for ds_first in (False, True):
        await tb.clocks(4)
        if ds_first:
            bus.ds_n.value = 0b10
            assert not await answered(dut, 2000)
        else:
            bus.as_n.value = 0
        await RisingEdge(dut.clk_i)
        await drive(bus, "40 as_n=0 ds_n=0b10")
        began = get_sim_time("ns")
        assert await answered(dut, 1200)
        took.append(get_sim_time("ns") - began)
        bus.ds_n.value, bus.as_n.value = 0b11, 1
    assert took[0] == took[1], took
