# SPDX-License-Identifier: Apache-2.0
"""The SoC's way to the registers: one access for each load or store, whatever the clocks. §4.3"""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.handle import Force, Release
from cocotb.triggers import FallingEdge, RisingEdge, Timer

from cocotb_tests.lib.req import test
from cocotb_tests.lib.tb import ARMED, BASE, Host
from mmcs.regs import CARD_PPI_B, PCCSR, PIT0, PIT_CONTROL, VECTOR, card_offset

TOPLEVEL = "bench_bridge"
SOURCES = ["../../rtl/soc/soc_cross.sv", "../../rtl/soc/soc_bridge.sv", "bench_bridge.sv"]
CARD = card_offset(0, CARD_PPI_B)
MACHINE_NS = 126
# the processor's clock: the machine's own, six times as fast, unrelated
CLOCKS = {"same": 126, "six": 21, "strange": 17}
TIMEOUT_CLKS = 128


class TwoClocks(Host):
    """The machine's side at its clock, and the processor at one of CLOCKS."""

    def __init__(self, dut, clock):
        super().__init__(dut)
        self.cpu_ns = CLOCKS[clock]

    async def start(self):
        dut = self.dut
        self.inputs_idle()
        dut.rst_ni.value = 0
        cocotb.start_soon(Clock(dut.clk_i, MACHINE_NS, unit="ns").start())
        cocotb.start_soon(Clock(dut.cpu_clk_i, self.cpu_ns, unit="ns").start())
        await Timer(5 * MACHINE_NS, "ns")
        await FallingEdge(dut.clk_i)
        dut.rst_ni.value = 1
        return self


class Bridge(TwoClocks):
    """One access after the other, as a processor makes them."""

    async def start(self):
        await super().start()
        self.reads = self.writes = 0
        self.dut.pc_d_i.value = 0xFF
        await Timer(5 * MACHINE_NS, "ns")
        return self

    async def access(self, offset, value=None, clock=False):
        """(data, error) of one access; asserts that it is answered once."""
        dut = self.dut
        await FallingEdge(dut.cpu_clk_i)
        assert not int(dut.busy_o.value) and not int(dut.done_o.value)
        dut.start_i.value = 1
        dut.clock_i.value = int(clock)
        dut.write_i.value = int(value is not None)
        dut.a_i.value = offset >> 1
        dut.wdata_i.value = value or 0
        await RisingEdge(dut.cpu_clk_i)
        await FallingEdge(dut.cpu_clk_i)
        dut.start_i.value = 0
        # what the processor's bus shows afterwards is of no account
        dut.write_i.value = random.randint(0, 1)
        dut.a_i.value = random.getrandbits(10)
        dut.wdata_i.value = random.getrandbits(8)
        dut.clock_i.value = random.randint(0, 1)
        self.waited = 0
        while not int(dut.done_o.value):
            await FallingEdge(dut.cpu_clk_i)
            self.waited += 1
            assert self.waited < 5000, "no answer"
        answer = int(dut.rdata_o.value), int(dut.err_o.value)
        await FallingEdge(dut.cpu_clk_i)
        assert not int(dut.done_o.value), "one clock of answer"
        return answer

    async def rd(self, offset):
        data, error = await self.access(offset)
        assert not error and data < 256
        self.reads += 1
        self.counted()
        assert int(self.dut.last_a_o.value) == offset >> 1
        return data

    async def wr(self, offset, value):
        assert not (await self.access(offset, value))[1]
        self.writes += 1
        self.counted()
        assert int(self.dut.last_a_o.value) == offset >> 1

    def counted(self):
        """Each access has reached the adaptor exactly once."""
        assert int(self.dut.reads_o.value) == self.reads
        assert int(self.dut.writes_o.value) == self.writes


@test("SOC-1")
@cocotb.parametrize(clock=list(CLOCKS))
async def each_register_is_reached_once(dut, clock):
    """Vector and PCCSR keep what is written; a hole and an absent card read 0xFF, once each."""
    tb = await Bridge(dut, clock).start()
    for value in (0x00, 0x55, 0xAA, 0xC3):
        await tb.wr(VECTOR, value)
        assert int(dut.vector_o.value) == value
    await tb.wr(PCCSR, BASE)
    assert await tb.rd(PCCSR) == BASE
    for _ in range(40):
        offset = random.choice((0x411, 0x443, CARD, 0x0C1)) | 1
        assert await tb.rd(offset) == 0xFF
    dut.pc_d_i.value = 0x3C
    assert await tb.rd(CARD) == 0x3C


@test("SOC-1", "SOC-2")
@cocotb.parametrize(clock=list(CLOCKS))
async def byte_toggle_of_the_timers(dut, clock):
    """Reads of a count alternate between its bytes: one too many or too few would swap them."""
    tb = await Bridge(dut, clock).start()
    await tb.sclock(0x1000, 0xFFFF)
    before = 0x1001
    for n in range(20):
        await tb.wr(PIT_CONTROL, 0x00)  # latch counter 0
        if n % 3 == 0:
            await tb.rd(PCCSR)  # another register in between does not matter
        low = await tb.rd(PIT0)
        if n % 3 == 1:
            await tb.rd(VECTOR)
        count = low | await tb.rd(PIT0) << 8
        assert 0 < count < before, "bytes are in order"
        before = count


@test("SOC-1", "SOC-3")
@cocotb.parametrize(clock=list(CLOCKS))
async def sclock_interrupts(dut, clock):
    """Timers by the bridge alone: the request comes, stands, and goes with the latch."""
    tb = await Bridge(dut, clock).start()
    await tb.timer(0, 8)
    await tb.timer(1, 8, mode=3)
    await tb.wr(PCCSR, BASE | ARMED | 0x20)
    for _ in range(3):
        for _ in range(200):
            await RisingEdge(dut.clk_i)
            if int(dut.irq_o.value):
                break
        assert int(dut.irq_o.value)
        assert await tb.rd(PCCSR) & 0x20
        await tb.wr(PCCSR, BASE)
        assert not int(dut.irq_o.value)
        await tb.wr(PCCSR, BASE | ARMED | 0x20)


@test("SOC-2")
@cocotb.parametrize(clock=list(CLOCKS))
async def a_silent_adaptor_times_out(dut, clock):
    """Error after the time, no hang; the request that was left is finished, once, and forgotten."""
    tb = await Bridge(dut, clock).start()
    await tb.wr(VECTOR, 0x40)
    dut.deaf_i.value = 1
    await Timer(2 * MACHINE_NS, "ns")
    for _ in range(2):
        _, error = await tb.access(VECTOR, 0x77)
        assert error
        waited_ns = tb.waited * tb.cpu_ns
        assert TIMEOUT_CLKS * MACHINE_NS <= waited_ns <= (TIMEOUT_CLKS + 12) * MACHINE_NS
        tb.counted()
    dut.deaf_i.value = 0
    await Timer(40 * MACHINE_NS, "ns")
    tb.writes += 1  # the first one; the second never reached the host port
    tb.counted()
    assert int(dut.vector_o.value) == 0x77
    assert await tb.rd(PCCSR) == 0
    await tb.wr(VECTOR, 0x41)
    assert int(dut.vector_o.value) == 0x41


@test("SOC-2")
async def a_late_end_leaves_whole_accesses(dut):
    """The adaptor answers a late access around the next one's time-out, at every clock of it.

    The next one is then made in time, or made too late, or has spent its time waiting: that one
    reaches nothing.
    """
    tb = await Bridge(dut, "same").start()
    seen = []
    for release in range(TIMEOUT_CLKS - 14, TIMEOUT_CLKS + 4):
        dut.deaf_i.value = 1
        await Timer(2 * MACHINE_NS, "ns")
        assert (await tb.access(VECTOR, 0x11))[1]
        before = int(dut.writes_o.value)
        second = cocotb.start_soon(tb.access(VECTOR, 0x22))
        await Timer(release * MACHINE_NS, "ns")
        dut.deaf_i.value = 0
        _, error = await second
        await Timer(40 * MACHINE_NS, "ns")
        made = int(dut.writes_o.value) - before
        assert int(dut.vector_o.value) == {1: 0x11, 2: 0x22}[made]
        seen.append((error, made))
        tb.writes += made
        await tb.wr(VECTOR, 0x33)
    cocotb.log.info("error and accesses by release: %s", seen)
    assert [s for n, s in enumerate(seen) if n == 0 or s != seen[n - 1]] == [(0, 2), (1, 2), (1, 1)]


@test("SOC-2")
async def a_fault_ends_in_an_error(dut):
    """A bus error made from outside, as if the time were spent before it began: no register."""
    tb = await Bridge(dut, "six").start()
    dut.u_bridge.expired.value = Force(1)
    await Timer(2 * MACHINE_NS, "ns")
    assert (await tb.access(VECTOR, 0x12))[1] and (await tb.access(VECTOR))[1]
    tb.counted()
    dut.u_bridge.expired.value = Release()
    await Timer(2 * MACHINE_NS, "ns")
    assert await tb.rd(PCCSR) == 0
    assert int(dut.vector_o.value) == 0x0F


@test("SOC-2")
@cocotb.parametrize(clock=list(CLOCKS))
async def microseconds_are_read_whole(dut, clock):
    tb = await Bridge(dut, clock).start()
    for value in (0x0000FFFF, 0x00010000, 0xFFFFFFFF, 0x12345678):
        dut.us_i.value = value
        assert await tb.access(PCCSR, clock=True) == (value, 0)
    tb.counted()
