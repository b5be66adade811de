# SPDX-License-Identifier: Apache-2.0
"""The Mark I card and its two hosts: the slot of a PC, and VME with three cards behind it. §5.3"""

from cocotb.triggers import ClockCycles
from cocotbext.pcbus import PcBus, PcBusMaster

from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import LEDS, PIT, RUN, Host, Machine
from cocotb_tests.system.machine import SHORT, USUAL

TOPLEVEL = {"slot": "mark1", "vme": "mmcs"}
VARIANTS = {"slot": SHORT | {"HeartbeatUs": 100}, "vme": USUAL}
CONVERT_US = 25
NS_PER_COUNT = 250  # the 4 million counts/s of ENC-1


class CardHost(Host):
    """What the tests of the card ask of either host; axes are numbered over all its cards."""

    cards: int

    def axes(self) -> range:
        return range(2 * self.cards)

    def drives(self) -> list[int]:
        return [self.volts(axis) for axis in self.axes()]

    async def counts(self) -> list[int]:
        return [await self.encoder(axis) for axis in self.axes()]

    async def codes(self) -> list[int]:
        return [await self.adc(axis) for axis in self.axes()]

    async def relay(self) -> None:
        """Until relays that were switched have settled."""
        await self.us(self.parameters["RelayUs"] + 2)

    async def converted(self) -> None:
        await self.us(CONVERT_US + 1)

    async def led_edge(self, card: int, name: str, level: int) -> float:
        """When a light takes a level."""
        while self.led(card, name) != level:
            await self.leds.value_change
        return self.now()


class Slot(CardHost):
    """A card at DIP setting 9 in a PC, without an adaptor."""

    cards = 1
    dip = 9
    limit_ms = 200

    async def start(self, b: int | None = RUN):
        await super().start()
        dut = self.dut
        dut.dip_i.value = self.dip
        dut.axis_enable_i.value = 3
        self.leds = dut.leds_o
        self.bus = PcBus.from_prefix(dut, "pc")
        self.pc = PcBusMaster(self.bus, dut.clk_i, base=0x300 | self.dip << 10)
        self.enc = self.encoders(2)
        await ClockCycles(dut.clk_i, 2)
        if b is not None:
            await self.setup(0, b)
        return self

    async def crd(self, card: int, register: int) -> int:
        return await self.pc.read(register)

    async def cwr(self, card: int, register: int, value: int) -> None:
        await self.pc.write(register, value)

    async def pulse(self) -> None:
        """A rising edge of SCLOCK."""
        self.dut.pc_drq_i.value = 0
        await ClockCycles(self.dut.clk_i, 3)
        self.dut.pc_drq_i.value = 1 << 2
        await ClockCycles(self.dut.clk_i, 1)

    def led(self, card: int, name: str) -> int:
        return int(self.leds.value) >> LEDS.index(name) & 1

    def panic(self) -> int:
        return int(self.dut.pc_irq_o.value) >> 4  # IRQ7 of IRQ7-3


class Rack(CardHost, Machine):
    """Three cards in the machine, reached over VME; SCLOCK is low and stands."""

    async def start(self, b: int = RUN):
        await super().start()
        self.leds = self.dut.card_leds_o
        await self.wr(PIT + 6, 0x70)
        for card in range(self.cards):
            await self.setup(card, b)
        await self.relay()
        return self

    async def pulse(self) -> None:
        await self.wr(PIT + 6, 0x70)
        await self.wr(PIT + 6, 0x74)

    def panic(self) -> int:
        return int(self.dut.panic_o.value)


async def either(dut, **options) -> Slot | Rack:
    return await {"mark1": Slot, "mmcs": Rack}[dut._name](dut).start(**options)


card_test = tests_on(either, "slot", "vme")
slot_test = tests_on(Slot, "slot")
rack_test = tests_on(Rack, "vme")
