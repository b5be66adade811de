# SPDX-License-Identifier: Apache-2.0
"""Every transition of the PCCSR: from every state by every write and every edge. §4.3.3, §4.3.6"""

import cocotb
from cocotb.triggers import FallingEdge

from cocotb_tests.adaptor.fronts import HostPort
from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import HEALTH_CLKS, PCCSR, PIT

TOPLEVEL = "adaptor_core"
MODE0, MODE2 = 0x70, 0x74  # control words of timer 1: they pull OUT1 low and high at once


class Csr(HostPort):
    async def sclock(self, level: int) -> None:
        await self.wr(PIT + 6, MODE2 if level else MODE0)
        assert int(self.dut.sclock_o.value) == level

    async def panic(self, level: int) -> None:
        self.dut.estop_closed_i.value = not level
        await self.clocks(HEALTH_CLKS)
        assert int(self.dut.panic_o.value) == level

    async def enter(self, state: int) -> None:
        """Both signals low; bit 7, the enables, the latches as wanted."""
        await self.sclock(0)
        await self.panic(0)
        await self.wr(PCCSR, 0)
        await self.wr(PCCSR, state >> 2 << 5)
        for latch, signal in ((state & 1, self.sclock), (state >> 1 & 1, self.panic)):
            if latch:
                await signal(1)
                await signal(0)

    async def expect(self, state: int, base: int) -> None:
        """What the register reads, and whether the latches and enables of a state interrupt: in two
        clocks running, for a bit that turns over in every clock is right in every other one."""
        bit7, enables, latches = state >> 4, state >> 2 & 3, state & 3
        assert await self.rd(PCCSR) == bit7 << 7 | latches << 5 | base
        for _ in range(2):
            assert int(self.dut.irq_req_o.value) == bool(enables & latches)
            await self.clocks(1)


csr_test = tests_on(Csr)


def after(state: int, event: int) -> int:
    """The state that follows: events 0-7 write the upper bits, 8 and 9 are edges."""
    if event >= 8:
        return state | (1 << event - 8 if state & 16 else 0)
    return event << 2 | (state & 3 if event & 4 else 0)


@csr_test("CSR-1", "INT-1", "INT-2")
async def every_transition(tb):
    """From bit 7, both enables and both latches; bit 7 at 0 holds the latches clear."""
    for state in range(32):
        if not state & 16 and state & 3:
            continue
        for event in range(10):
            await tb.enter(state)
            await tb.expect(state, 0)
            base = 0
            if event < 8:
                base = tb.random.randrange(32)
                await tb.wr(PCCSR, event << 5 | base)
            else:
                await (tb.sclock, tb.panic)[event - 8](1)
            await tb.expect(after(state, event), base)


@csr_test("CSR-1", "INT-1", "INT-2")
async def enables_beside_every_base(tb):
    """Latches and enables as wanted, whatever stands in the bits beside them."""
    for enables in range(4):
        for base in range(32):
            await tb.enter(0b10011)
            await tb.wr(PCCSR, 4 << 5 | enables << 5 | base)
            await tb.expect(0b10011 | enables << 2, base)


@csr_test("CSR-1", "MAP-1")
async def every_base_after_every_other(tb):
    for old in range(32):
        for new in range(32):
            await tb.wr(PCCSR, old)
            assert await tb.rd(PCCSR) == old
            await tb.wr(PCCSR, new)
            assert await tb.rd(PCCSR) == new


@csr_test("CSR-1", "PAN-2")
async def no_write_wins_over_sysreset(dut, tb):
    """A write that ends in any clock around the end of SYSRESET*: lost within it, kept after it."""
    kept = set()

    async def reset_at_the_answer() -> int:
        while not int(dut.hp_ack_o.value):
            await FallingEdge(dut.clk_i)
        return int(dut.sys_reset_o.value)

    for clocks in range(8):
        dut.sys_reset_i.value = 1
        await tb.clocks(4)
        answered = cocotb.start_soon(reset_at_the_answer())
        write = cocotb.start_soon(tb.wr(PCCSR, 0x9F))
        await tb.clocks(clocks)
        dut.sys_reset_i.value = 0
        await write
        in_reset = await answered
        assert await tb.rd(PCCSR) == (0 if in_reset else 0x9F), f"{clocks} clocks"
        kept.add(in_reset)
    assert kept == {0, 1}


@csr_test("INT-1")
async def an_edge_beside_a_standing_level(tb):
    """Signals that are high when bit 7 rises stay unlatched, whatever the other one does."""
    signals = (tb.sclock, tb.panic)
    for standing in (0, 1):
        await tb.enter(0)
        await signals[standing](1)
        await tb.wr(PCCSR, 0x80)
        await tb.expect(16, 0)
        await signals[1 - standing](1)
        await tb.expect(16 | 2 >> standing, 0)
        await signals[1 - standing](0)
        await tb.expect(16 | 2 >> standing, 0)
