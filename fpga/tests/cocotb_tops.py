# SPDX-License-Identifier: Apache-2.0
"""Adaptor and cards on real buses: transceivers turn and no two drivers meet. §4.2, §5.3"""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, First, ReadOnly, RisingEdge, Timer, ValueChange
from cocotb.utils import get_sim_time
from cocotbext.vme import VmeBus, VmeMaster

from cocotb_tests.lib.tb import (
    ARMED,
    BASE,
    LATCH_ALL,
    PANIC_IRQ,
    PCCSR,
    PORT_A,
    PORT_B,
    PPI_CONTROL,
    PPI_SETUP,
    SCLOCK_IRQ,
    VECTOR,
    Host,
)

APART_PS = 20_000  # OE# high on both sides of a turn: an ABT245 disables in 6 ns, an LS645 in 25
CARD_PS = (41_500, 41_900)  # their clocks are near the adaptor's, so that phases drift


class Buses(Host):
    clk_hz = 24_000_000
    limit_ms = 60

    async def begin(self):
        dut = self.dut
        for n, period in enumerate(CARD_PS):
            cocotb.start_soon(self._card_clock(n, period))
        self.fights, self.turns, self.drives, self.close = [], 0, 0, []
        for task in (self._fights(), self._drives(), *(self._turns(n) for n in range(3))):
            cocotb.start_soon(task)
        await self.start()
        self.vme = VmeMaster(VmeBus.from_prefix(dut, "vme"))
        await self.us(60)  # RESET DRV
        await self.wr(PCCSR, BASE)
        return self

    async def _card_clock(self, n, period):
        Clock(self.dut.card_clk_i[n], period, "ps").start()

    async def _fights(self):
        while True:
            await ValueChange(self.dut.fights_o)
            await Timer(1, "ps")  # all is settled
            if int(self.dut.fights_o.value):
                self.fights.append(f"{get_sim_time('ns'):.0f} ns: {self.dut.fights_o.value}")

    async def _drives(self):
        while True:
            await ValueChange(self.dut.driven_o)
            self.drives += 1

    async def _turns(self, n):
        """DIR changes while OE# is high, long before and long after."""
        dut, bit = self.dut, 1 << n
        levels = None
        closed = turned = -(10**9)
        while True:
            await First(ValueChange(dut.dir_o), ValueChange(dut.oe_no))
            await Timer(1, "ps")
            now = get_sim_time("ps")
            seen = int(dut.dir_o.value) & bit, int(dut.oe_no.value) & bit
            if levels is not None and seen != levels:
                if seen[0] != levels[0]:
                    self.turns += 1
                    turned = now
                    if not (levels[1] and seen[1]) or now - closed < APART_PS:
                        self.close.append(f"{now} ps: transceiver {n} turns with OE# low")
                if seen[1] != levels[1]:
                    if seen[1]:
                        closed = now
                    elif now - turned < APART_PS:
                        self.close.append(f"{now} ps: transceiver {n} opens as it turns")
            levels = seen

    def settled(self, turns):
        """No fight, and enough was seen for that to mean something."""
        assert not self.fights and not self.close, (self.fights[:3], self.close[:3])
        assert self.turns >= turns, f"{self.turns} turns only"

    async def ports(self):
        for card in range(2):
            await self.cwr(card, PPI_CONTROL, PPI_SETUP)


@cocotb.test()
async def no_two_drivers_meet(dut):
    """Random accesses, back to back and apart, to both cards, an absent one and the adaptor."""
    tb = await Buses(dut).begin()
    await tb.ports()
    held = {}
    for _ in range(400):
        card, register = tb.random.choice((0, 1, 2)), tb.random.choice((PORT_A, PORT_B))
        key = card, register
        kind = tb.random.random()
        if kind < 0.45:
            held[key] = tb.random.randrange(256) & (0xFF if register == PORT_A else 0xE8)
            await tb.cwr(*key, held[key])
        elif kind < 0.9:
            expected = 0xFF if card == 2 else held.get(key, 0)
            assert await tb.crd(*key) == expected, key
        else:
            assert await tb.rd(PCCSR) & 0x1F == BASE
        if tb.random.random() < 0.5:
            await Timer(tb.random.randrange(1, 700), "ns")
    tb.settled(turns=400)
    assert tb.drives >= 500


@cocotb.test()
async def data_in_time(dut):
    """A card's data are on the bus 300 ns after IOR#, and off it within 20 ns of its end."""
    tb = await Buses(dut).begin()
    await tb.ports()
    for card in (0, 1) * 20:
        read = cocotb.start_soon(tb.crd(card, PORT_A))
        await FallingEdge(dut.pc_ior_no)
        await Timer(300, "ns")
        assert int(dut.driven_o.value) == 2 << card
        await RisingEdge(dut.pc_ior_no)
        await Timer(20, "ns")
        assert int(dut.driven_o.value) == 0
        await read
        await Timer(tb.random.randrange(1, 200), "ns")
    tb.settled(turns=80)


@cocotb.test()
async def words_leave_the_upper_byte_alone(dut):
    """§4.3.1: 16-bit accesses work on the low byte; D15-D08 have no driver."""
    tb = await Buses(dut).begin()
    await tb.ports()
    even = tb.base | tb.creg(1, PORT_A) & ~1
    await tb.vme.write(even, 0x12A8, 2)
    assert await tb.vme.read(even, 2) == 0xFFA8
    assert not await tb.vme.answers(even)
    tb.settled(turns=4)


@cocotb.test()
async def interrupts_and_acknowledge(dut):
    tb = await Buses(dut).begin()
    await tb.wr(VECTOR, 0x5A)
    await tb.sclock(100, 100)
    await tb.wr(PCCSR, ARMED | SCLOCK_IRQ | BASE)
    while int(dut.vme_irq_no.value) >> 4 & 1:
        await tb.us(5)
    dut.vme_iackin_ni.value = 1
    iack = cocotb.start_soon(tb.vme.iack(5))
    await Timer(150, "ns")
    dut.vme_iackin_ni.value = 0
    assert await iack == 0x5A
    dut.vme_iackin_ni.value = 1
    await tb.wr(PCCSR, BASE)
    await tb.us(1)
    assert int(dut.vme_irq_no.value) == 0x7F
    tb.settled(turns=0)


@cocotb.test()
async def panic_and_sclock_over_the_cable(dut):
    """PANIC goes with the last D/A write and comes with a heartbeat's end; SCLOCK latches cards."""
    tb = await Buses(dut).begin()
    await tb.ports()
    assert int(dut.panic_o.value)
    for axis in range(4):
        await tb.dac(axis, 0x800)
    await tb.us(2)
    assert not int(dut.panic_o.value) and int(dut.brake_release_o.value)
    await tb.us(450)
    assert int(dut.panic_o.value) and not int(dut.brake_release_o.value)
    for card in range(2):
        await tb.cwr(card, PORT_A, 5)
        await tb.cwr(card, PORT_B, 5)
        await tb.crd(card, 2)
        for register in (4, 5, 6, 7):
            await tb.cwr(card, register, 0)
    for _ in range(3):
        for a, b in ((1, 0), (1, 1), (0, 1), (0, 0)):
            dut.enc_a_i.value, dut.enc_b_i.value = a, b
            await tb.us(1)
    await tb.sclock(8, 40)
    await tb.us(100)
    await tb.crd(0, LATCH_ALL)
    for card in range(2):
        await tb.crd(card, 2)
        assert await tb.encoder(2 * card) == 12
    await tb.wr(PCCSR, ARMED | PANIC_IRQ | BASE)
    dut.estop_closed_i.value = 0
    await tb.us(1)
    assert not int(dut.brake_release_o.value)
    tb.settled(turns=20)


@cocotb.test()
async def ale_and_clk_of_a_pc(dut):
    """ALE falls while the address stands and a clock before each command; CLK is high a third."""
    tb = await Buses(dut).begin()
    await tb.ports()
    seen = []

    async def watch():
        fell = address = None
        while True:
            await FallingEdge(dut.pc_ale_o)
            fell, address = tb.now(), int(dut.pc_a_o.value)
            while int(dut.pc_ior_no.value) and int(dut.pc_iow_no.value):
                await RisingEdge(dut.clk_i)
                await ReadOnly()
            seen.append(tb.now() - fell)
            assert int(dut.pc_a_o.value) == address

    task = cocotb.start_soon(watch())
    for n in range(20):
        await (tb.crd(n % 2, PORT_A) if n % 3 else tb.cwr(n % 2, PORT_A, n))
    await tb.us(1)
    task.cancel()
    assert len(seen) == 20 and set(seen) == {tb.period}
    await RisingEdge(dut.pc_clk_o)
    rose = tb.now()
    await FallingEdge(dut.pc_clk_o)
    high = tb.now() - rose
    await RisingEdge(dut.pc_clk_o)
    assert tb.clks(high) == 1 and tb.clks(tb.now() - rose) == 3


@cocotb.test()
async def nothing_drives_in_reset(dut):
    """In the middle of reads as well, and without a clock of the cards'."""
    tb = await Buses(dut).begin()
    await tb.ports()
    for ns in range(0, 1500, 70):
        cocotb.start_soon(tb.vme.answers(tb.base | tb.creg(0, PORT_A)))
        await Timer(ns + 1, "ns")
        dut.rst_ni.value = 0
        await Timer(1, "ns")
        assert int(dut.driven_o.value) == 0 and not int(dut.vme_d_oe_o.value)
        assert int(dut.vme_dtack_no.value) and int(dut.vme_irq_no.value) == 0x7F
        await tb.vme.idle()
        dut.rst_ni.value = 1
        await tb.us(1)
    assert not tb.fights, tb.fights[:3]
