# SPDX-License-Identifier: Apache-2.0
"""A VME slave: memory, or functions, behind an address window; DTACK* or BERR* after a delay."""

import cocotb
from cocotb.triggers import First, Timer
from cocotbext.mmcs import logger, pin, seeded, span, whole
from cocotbext.vme.bus import AM_SUPERVISOR, AM_USER, DS_NONE, VmeBus

DATA_NS = 10  # read data stands so long before DTACK*
OFF_NS = 10  # drivers off so long before DTACK* rises


class VmeSlave:
    """Answers bytes, words and (on 32 data lines) long words in `size` bytes from `base`.

    `memory` holds the bytes. `on_read(offset, size)` and `on_write(offset, size, value)` take the
    place of the memory; `fail` is a list of (first, last) offsets that answer with BERR*.
    `delay_ns` from the strobe to DTACK*, 30 at least: one number, or (shortest, longest).
    """

    def __init__(
        self, bus: VmeBus, *, base: int, size: int, modifiers=(AM_USER, AM_SUPERVISOR),
        delay_ns=100, on_read=None, on_write=None, fail=(), seed=None,
    ):  # fmt: skip
        self.bus = bus
        self.base = whole("base", base, 0, (1 << bus.address_width) - 1)
        self.size = whole("size", size, 1, (1 << bus.address_width) - base)
        self.modifiers = {whole("address modifier", am, 0, 63) for am in modifiers}
        self.delay_ns = span("delay_ns", delay_ns, 30)
        for name, hook in (("on_read", on_read), ("on_write", on_write)):
            if hook is not None and not callable(hook):
                raise TypeError(f"{name} is a function, not {hook!r}")
        self.on_read, self.on_write = on_read, on_write
        self.fail = [(whole("fail, first", a, 0), whole("fail, last", b, a)) for a, b in fail]
        if self.fail and bus.berr_n is None:
            raise ValueError("fail needs the signal berr_n, which this bus has not")
        self.memory = bytearray(size)
        self.log = logger("vme", bus.dtack_n)
        self.random = seeded(seed)
        self.answered = self.failed = 0
        bus.silent()
        self._task = cocotb.start_soon(self._run())

    async def _run(self) -> None:
        bus = self.bus
        while True:
            while pin(bus.ds_n) == DS_NONE or pin(bus.as_n):
                await First(bus.ds_n.value_change, bus.as_n.value_change)
            if not await self._cycle():
                while pin(bus.ds_n) != DS_NONE:
                    await bus.ds_n.value_change

    def _decode(self) -> tuple[int, int] | None:
        """Offset and size, if the cycle is ours."""
        bus = self.bus
        if bus.iack_n is not None and not pin(bus.iack_n):
            return None
        if pin(bus.am) not in self.modifiers:
            return None
        strobes = pin(bus.ds_n)
        size = 2 if strobes == 0 else 1
        if bus.lword_n is not None and not pin(bus.lword_n):
            if bus.data_width < 32 or strobes:
                return None
            size = 4
        offset = (pin(bus.a) << 1 | (strobes == 0b10)) - self.base
        return (offset, size) if 0 <= offset <= self.size - size else None

    async def _cycle(self) -> bool:
        """Answers the cycle; whether it was ours and its master stayed until the end."""
        bus = self.bus
        delay = self.random.randint(*self.delay_ns) - DATA_NS
        if not await self._stays(delay) or (what := self._decode()) is None:
            return False
        offset, size = what
        write = not pin(bus.write_n)
        end = "berr_n" if any(a <= offset <= b for a, b in self.fail) else "dtack_n"
        if end == "dtack_n":
            self._store(offset, size) if write else self._fetch(offset, size)
        if not await self._stays(DATA_NS):
            bus.put(q_oe=0)
            return False
        bus.pull(end, self, True)
        while pin(bus.ds_n) != DS_NONE:
            await bus.ds_n.value_change
        bus.put(q_oe=0)
        await Timer(OFF_NS, "ns")
        bus.pull(end, self, False)
        self.answered += end == "dtack_n"
        self.failed += end == "berr_n"
        self.log.debug("%s %04X.%d %s", "write" if write else "read", offset + self.base, size, end)
        return True

    async def _stays(self, ns: int) -> bool:
        """So many ns, unless the strobes are withdrawn; AS* ends nothing by itself."""
        timer = Timer(ns, "ns")
        while pin(self.bus.ds_n) != DS_NONE:
            if await First(timer, self.bus.ds_n.value_change) is timer:
                return True
        return False

    def _fetch(self, offset: int, size: int) -> None:
        bus, ones = self.bus, (1 << len(self.bus.q)) - 1
        if self.on_read:
            value = whole(f"what on_read gives, size {size}", self.on_read(offset, size), 0,
                          (1 << 8 * size) - 1)  # fmt: skip
        else:
            value = int.from_bytes(self.memory[offset : offset + size], "big")
        even = size == 1 and offset + self.base & 1 == 0
        lanes = {1: 0xFF00 if even else 0xFF, 2: 0xFFFF, 4: ones}[size]
        bus.put(q=ones & ~lanes | (value << 8 if even else value) & lanes, q_oe=1)

    def _store(self, offset: int, size: int) -> None:
        value = pin(self.bus.d)
        if size == 1 and offset + self.base & 1 == 0:
            value >>= 8
        value &= (1 << 8 * size) - 1
        if self.on_write:
            self.on_write(offset, size, value)
        else:
            self.memory[offset : offset + size] = value.to_bytes(size, "big")

    def stop(self) -> None:
        self._task.cancel()
