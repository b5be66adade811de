# SPDX-License-Identifier: Apache-2.0
"""Reset in the midst of things leaves nothing behind: the same start, output by output."""

import cocotb
from cocotb.triggers import FallingEdge
from cocotbext.vme import VmeMaster

from cocotb_tests.lib.play import drive
from cocotb_tests.lib.req import test
from cocotb_tests.lib.tb import (
    ARMED,
    B_DOUBLE,
    B_INDEX,
    BASE,
    DAC1,
    DAC2,
    ENC1,
    LATCH_ALL,
    PANIC_IRQ,
    PCCSR,
    PIT,
    PORT_A,
    PORT_B,
    QUAD,
    SCLOCK_IRQ,
    VECTOR,
    Machine,
    Tb,
)
from cocotb_tests.system.machine import USUAL

TOPLEVEL = "mmcs"
PARAMETERS = USUAL


class Twice(Machine):
    """The machine, started as often as one likes."""

    async def again(self) -> None:
        self.inputs_idle()
        self.dut.axis_enable_i.value = (1 << 2 * self.cards) - 1
        self.dut.rst_ni.value = 0
        await self.clocks(5)
        self.dut.rst_ni.value = 1
        self.vme = VmeMaster(self.bus, seed=1)

    async def record(self) -> list[str]:
        """What a start shows: all outputs in each clock, while registers are read and used."""
        names = [h._name for h in self.dut if h._name.endswith(("_o", "_no"))]
        pins = [getattr(self.dut, n) for n in names]
        seen = []

        async def sample():
            while True:
                await FallingEdge(self.dut.clk_i)
                seen.append(" ".join(str(pin.value) for pin in pins))

        task = cocotb.start_soon(sample())
        await self.use()
        task.cancel()
        return seen

    async def use(self) -> None:
        for offset in (PIT, PIT + 2, PIT + 4, PCCSR):
            for _ in range(2):
                await self.rd(offset)
        self.dut.enc_a_i.value = 0x15
        await self.wr(PIT + 6, 0x70)
        await self.wr(PCCSR, ARMED | SCLOCK_IRQ | BASE)
        await self.wr(PIT + 6, 0x74)
        await self.clocks(4)
        await self.vme.iack(5)
        for card in range(self.cards):
            for register in (0, 1, 2, 4, 5, 6, 7, 12, 13, 14):
                await self.crd(card, register)
        await self.setup(0)
        self.dut.enc_b_i.value = 0x2A
        await self.cwr(0, LATCH_ALL, 0)
        await self.cwr(0, DAC1 + 1, 0x9)
        await self.cwr(0, DAC2 + 1, 0x7)
        await self.us(30)
        for register in (4, 5, 6, 7, 12, 13, 14):
            await self.crd(0, register)
        await self.adc(0)

    async def mess(self) -> None:
        """Everything at work, and much of it half done."""
        dut = self.dut
        await self.wr(VECTOR, 0xA5)
        await self.wr(PCCSR, ARMED | SCLOCK_IRQ | PANIC_IRQ | BASE)
        self.inputs([0x1111 * (n + 1) for n in range(2 * self.cards)])
        for card in range(self.cards):
            await self.setup(card, 0x1F)
            await self.cwr(card, PORT_A, 0xF8 | QUAD)
        for axis in range(2 * self.cards):
            await self.dac(axis, 0xA53 + axis)
            await self.preset(axis, 0x5AA5 + axis)
        await self.sclock(7, 5)
        await self.timer(2, 3)
        dut.enc_i_i.value = 0x3F
        for a, b in ((0x3F, 0), (0x3F, 0x3F), (0, 0x3F), (0x15, 0x2A)):
            dut.enc_a_i.value, dut.enc_b_i.value = a, b
            await self.clocks(2)
        await self.us(27)
        for card in range(self.cards):
            await self.cwr(card, PORT_B, B_INDEX | B_DOUBLE)
            await self.cwr(card, ENC1, 0x77)  # one byte of two
            await self.crd(card, ENC1 + 2)
            await self.cwr(card, DAC1, 0x99)
        await self.wr(PIT + 6, 0xEE)  # status of all, not read
        await self.wr(PIT + 6, 0xDE)  # counts of all
        await self.wr(PIT, 0x12)
        await self.rd(PIT + 2)
        dut.estop_closed_i.value = 0
        await self.cwr(0, LATCH_ALL, 0)


@test("ADP-1", "CRD-2")
async def reset_at_any_time_starts_anew(dut):
    """In any phase of an access, of the card's or the adaptor's own, or of an acknowledge."""
    tb = Twice(dut)
    await Tb.start(tb)
    await tb.again()
    first = await tb.record()
    for address, ns in ((tb.creg(0, PORT_A), 700), (PIT, 450), (tb.creg(1, ENC1), 450), (5, 450)):
        await tb.mess()
        chain = int(address != 5)  # low in an acknowledge
        at = (tb.base | address) >> 1 if chain else 5
        await drive(tb.bus, f"a={at} am=0x2D lword_n=1 write_n=1 iack_n={chain} 40")
        await drive(tb.bus, f"as_n=0 ds_n=2 20 iackin_n={chain} {ns}")
        await tb.again()
        second = await tb.record()
        assert len(first) == len(second)
        for at, (one, two) in enumerate(zip(first, second, strict=True)):
            assert one == two, f"{address:X}: clock {at} after reset:\n{one}\n{two}"
