# SPDX-License-Identifier: Apache-2.0
"""A master of the PC I/O bus, in step with a clock: for cards alone."""

from cocotb.triggers import ClockCycles
from cocotbext.mmcs import logger, whole
from cocotbext.mmcs.bus import ProtocolError
from cocotbext.pcbus.bus import BusTimeout, PcBus


class PcBusMaster:
    """I/O cycles as a PC runs them, in clocks: address, `command` of IOR# or IOW#, data held after.

    `base` is added to the addresses of `read` and `write`. A card that holds IOCHRDY low at the end
    of the command stretches it, for `limit` clocks at most.
    """

    def __init__(
        self, bus: PcBus, clk, *, command: int = 4, setup: int = 1, hold: int = 1, base: int = 0,
        limit: int = 100,
    ):  # fmt: skip
        self.bus, self.clk = bus, clk
        self.command = whole("command", command, 1)
        self.setup, self.hold = whole("setup", setup, 1), whole("hold", hold, 1)
        self.limit = whole("limit", limit, 0)
        self.top = (1 << len(bus.a)) - 1
        self.base = whole("base", base, 0, self.top)
        self.log = logger("pcbus", bus.ior_n)
        bus.idle()

    async def outb(self, address: int, value: int, aen: int = 0) -> None:
        whole("value", value, 0, 0xFF)
        await self._cycle("outb", address, aen, self.bus.iow_n, value)

    async def inb(self, address: int, aen: int = 0) -> int:
        """What the PC reads: 0xFF where no card drives."""
        return await self._cycle("inb", address, aen, self.bus.ior_n, None)

    async def write(self, register: int, value: int) -> None:
        await self.outb(self.base + register, value)

    async def read(self, register: int) -> int:
        return await self.inb(self.base + register)

    async def _cycle(self, kind: str, address: int, aen: int, strobe, value: int | None) -> int:
        bus, clk = self.bus, self.clk
        whole("address", address, 0, self.top)
        whole("aen", aen, 0, 1 if bus.aen is not None else 0)
        bus.put(a=address, aen=aen)
        if value is not None:
            bus.d.value = value
        await ClockCycles(clk, self.setup)
        strobe.value = 0
        await ClockCycles(clk, self.command)
        late = await self._stretch()
        seen = bus.data() if value is None else value
        strobe.value = 1
        await ClockCycles(clk, self.hold)
        if value is not None:
            bus.d.value = 0xFF
        bus.put(aen=0)
        self.log.debug("%-4s %04X %02X%s", kind, address, seen, " IOCHRDY!" if late else "")
        if late:
            raise BusTimeout(f"{kind} {address:04X}: IOCHRDY low for more than {self.limit} clocks")
        if value is None and bus.q_oe is not None and int(bus.q_oe.value):
            raise ProtocolError(f"{kind} {address:04X}: the card drives after IOR#")
        return seen

    async def _stretch(self) -> bool:
        """Wait states, while a card asks for them; whether it asks for too many."""
        for _ in range(self.limit):
            if not self.bus.stretched():
                return False
            await ClockCycles(self.clk, 1)
        return self.bus.stretched()
