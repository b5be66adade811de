# SPDX-License-Identifier: Apache-2.0
"""Every switch setting of a card by every card number, and every register of every card. §5.3.1"""

import cocotb

from cocotb_tests.card.host import VARIANTS as CARDS
from cocotb_tests.card.host import Slot
from cocotb_tests.functional import cover
from cocotb_tests.lib.req import test
from cocotb_tests.lib.tb import PORT_A, PPI_CONTROL, PPI_SETUP

TOPLEVEL = "mark1"
PARAMETERS = CARDS["slot"]
READABLE = {*range(8), 12, 13, 14}


class Numbered(Slot):
    async def number(self, dip: int) -> None:
        self.dut.dip_i.value = dip
        self.pc.base = 0x300 | dip << 10
        await self.pc.write(PPI_CONTROL, PPI_SETUP)

    async def driven(self, address: int) -> int | None:
        """What the card answers with, None if it stays away."""
        dut = self.dut
        seen = []

        async def look():
            await dut.pc_ior_ni.value_change
            await self.clocks(2)
            seen.append(int(dut.pc_d_oe_o.value))

        task = cocotb.start_soon(look())
        value = await self.pc.inb(address)
        await task
        return value if seen[0] else None


@test("CRD-1", "MAP-1")
async def every_number_at_every_setting(dut):
    """A card answers to the number of its switches alone, and takes only its own writes."""
    tb = await Numbered(dut).start()
    for dip in range(16):
        await tb.number(dip)
        kept = 0
        for number in range(16):
            address = 0x300 | number << 10 | PORT_A
            value = tb.random.randrange(1, 255)
            await tb.pc.outb(address, value)
            if number == dip:
                kept = value
            assert await tb.pc.read(PORT_A) == kept
            cover.CARD.hit(dip, number, "write")
            assert await tb.driven(address) == (kept if number == dip else None)
            cover.CARD.hit(dip, number, "read")
    cover.save()
    assert set(cover.CARD.bins()) == cover.CARD.hits


@test("CRD-1")
async def every_register_of_every_number(dut):
    """Only what is readable is ever driven; no write but its own reaches port A."""
    tb = await Numbered(dut).start()
    for dip in range(16):
        await tb.number(dip)
        kept = 0
        for register in range(32):
            name = f"{register:02X}"
            value = PPI_SETUP if register == PPI_CONTROL else tb.random.randrange(1, 255)
            await tb.pc.write(register, value)
            if register in (PORT_A, PPI_CONTROL):
                kept = value if register == PORT_A else 0
            assert await tb.pc.read(PORT_A) == kept, f"card {dip}, write to {name}"
            cover.CARD_REGISTER.hit(dip, name, "write")
            read = await tb.driven(tb.pc.base | register)
            assert (read is not None) == (register in READABLE), f"card {dip}, read of {name}"
            cover.CARD_REGISTER.hit(dip, name, "read")
    cover.save()
    assert set(cover.CARD_REGISTER.bins()) == cover.CARD_REGISTER.hits
