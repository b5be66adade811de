# SPDX-License-Identifier: Apache-2.0
"""A card on the PC I/O bus: registers, or functions, with access time and wait states."""

import cocotb
from cocotb.triggers import FallingEdge, First, RisingEdge, Timer
from cocotbext.mmcs import logger, seeded, span, whole
from cocotbext.pcbus.bus import PcBus


class PcBusSlave:
    """Answers `size` ports from `base`; those elsewhere, and cycles with AEN, it leaves alone.

    `registers` holds the bytes; `on_read(offset)` and `on_write(offset, value)` take their place.
    `access_ns` from IOR# to data, `wait_ns` of IOCHRDY from the command on: one number each, or
    (shortest, longest).
    """

    def __init__(
        self, bus: PcBus, *, base: int, size: int, access_ns=100, wait_ns=0, on_read=None,
        on_write=None, seed=None,
    ):  # fmt: skip
        self.bus = bus
        self.base = whole("base", base, 0, (1 << len(bus.a)) - 1)
        self.size = whole("size", size, 1, (1 << len(bus.a)) - base)
        self.access_ns, self.wait_ns = span("access_ns", access_ns), span("wait_ns", wait_ns)
        if self.wait_ns[1] and not bus.can_stretch():
            raise ValueError("wait_ns needs the signal iochrdy or wait, which this bus has not")
        for name, hook in (("on_read", on_read), ("on_write", on_write)):
            if hook is not None and not callable(hook):
                raise TypeError(f"{name} is a function, not {hook!r}")
        self.on_read, self.on_write = on_read, on_write
        if bus.q is None:
            raise ValueError("a slave needs the signal q")
        self.registers = bytearray(size)
        self.reads = self.writes = 0
        self.log = logger("pcbus", bus.ior_n)
        self.random = seeded(seed)
        bus.silent()
        self._tasks = [cocotb.start_soon(self._reads()), cocotb.start_soon(self._writes())]

    def interrupt(self, line: int, level: int) -> None:
        """One line of `irq`, counted from its lowest."""
        if self.bus.irq is None:
            raise ValueError("this bus has no signal irq")
        whole("line", line, 0, len(self.bus.irq) - 1)
        lines = int(self.bus.irq.value)
        self.bus.irq.value = lines & ~(1 << line) | whole("level", level, 0, 1) << line

    def stop(self) -> None:
        for task in self._tasks:
            task.cancel()

    def _offset(self) -> int | None:
        bus = self.bus
        if bus.aen is not None and int(bus.aen.value):
            return None
        offset = int(bus.a.value) - self.base
        return offset if 0 <= offset < self.size else None

    async def _reads(self) -> None:
        bus = self.bus
        while True:
            await FallingEdge(bus.ior_n)
            if (offset := self._offset()) is None:
                continue
            stretch = cocotb.start_soon(self._stretch())
            end = RisingEdge(bus.ior_n)
            access = Timer(max(1, self.random.randint(*self.access_ns)), "ns")
            if await First(access, end) is access:
                value = self.on_read(offset) if self.on_read else self.registers[offset]
                bus.put(q=whole("what on_read gives", value, 0, 0xFF), q_oe=1)
                self.log.debug("read  %04X %02X", offset + self.base, value)
                self.reads += 1
                await end
            self._off(stretch)

    async def _writes(self) -> None:
        bus = self.bus
        while True:
            await FallingEdge(bus.iow_n)
            if (offset := self._offset()) is None:
                continue
            stretch = cocotb.start_soon(self._stretch())
            await RisingEdge(bus.iow_n)
            self._off(stretch)
            value = int(bus.d.value)
            self.log.debug("write %04X %02X", offset + self.base, value)
            self.writes += 1
            if self.on_write:
                self.on_write(offset, value)
            else:
                self.registers[offset] = value

    def _off(self, stretch) -> None:
        stretch.cancel()
        self.bus.put(q=0xFF, q_oe=0)
        self.bus.stretch(False)

    async def _stretch(self) -> None:
        if ns := self.random.randint(*self.wait_ns):
            self.bus.stretch(True)
            await Timer(ns, "ns")
            self.bus.stretch(False)
