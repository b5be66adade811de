# SPDX-License-Identifier: Apache-2.0
"""VME master, interrupt handler and bus timer for cocotb. §4.3.1, §4.3.6

    bus = VmeBus.from_prefix(dut, "vme")
    vme = VmeMaster(bus)
    await vme.write(0x6409, 0xB8)          # blocking; BusTimeout where nobody answers
    op = vme.init_read(0x6409)             # queued; op.data after `await op.wait()`

All timing is that of the standard's tables, in ns, with no relation to the clock of the design:
`VmeTiming` holds the least values, `skew` adds up to so many ns at random to each of them.
"""

import logging
import random
from collections import deque
from dataclasses import dataclass

import cocotb
from cocotb.triggers import Event, FallingEdge, First, ReadOnly, RisingEdge, Timer
from cocotb.utils import get_sim_time

AM_USER, AM_SUPERVISOR = 0x29, 0x2D
DS_BOTH, DS_ODD, DS_EVEN, DS_NONE = 0b00, 0b10, 0b01, 0b11  # {DS1*, DS0*}

SIGNALS = {
    "a": "a_i",
    "am": "am_i",
    "as_n": "as_ni",
    "ds_n": "ds_ni",
    "write_n": "write_ni",
    "lword_n": "lword_ni",
    "d": "d_i",
    "q": "d_o",
    "q_oe": "d_oe_o",
    "dtack_n": "dtack_no",
    "iack_n": "iack_ni",
    "iackin_n": "iackin_ni",
    "iackout_n": "iackout_no",
    "irq_n": "irq_no",
    "sysreset_n": "sysreset_ni",
}


class BusTimeout(Exception):
    """Nobody answered: the backplane's bus timer drove BERR*."""


class ProtocolError(AssertionError):
    """The slave broke a rule of the bus."""


class VmeBus:
    """The signals of one slot, by their contract names."""

    def __init__(self, **handles):
        self.__dict__.update(handles)

    @classmethod
    def from_prefix(cls, dut, prefix: str) -> "VmeBus":
        return cls(**{k: getattr(dut, f"{prefix}_{v}") for k, v in SIGNALS.items()})

    def idle(self) -> None:
        for name in ("as_n", "write_n", "lword_n", "iack_n", "iackin_n", "sysreset_n"):
            getattr(self, name).value = 1
        self.ds_n.value = DS_NONE
        self.a.value = self.am.value = self.d.value = 0

    def data(self) -> int:
        """D15-D00 as a master sees them: the terminators pull up what nobody drives."""
        return int(self.q.value) if int(self.q_oe.value) else 0xFFFF


@dataclass
class VmeTiming:
    """Least times that a master keeps, in ns."""

    setup: int = 35  # A, AM, LWORD*, IACK*, WRITE*, D before the strobes
    as_to_ds: int = 0
    ds_skew: int = 0  # between DS1* and DS0*, at most 10
    release: int = 0  # DTACK* low to the strobes high
    ds_high: int = 40  # both strobes high between cycles
    bus_timer: int = 16_000


class Operation:
    """One queued cycle and what became of it."""

    def __init__(self, **what):
        self.address: int = 0
        self.__dict__.update(what)
        self.data: int | None = None
        self.bus: int | None = None  # D15-D00 while DTACK* was low
        self.error: Exception | None = None
        self.answered = False
        self.strobe_ns = self.dtack_ns = self.end_ns = 0.0
        self._done = Event()

    async def wait(self) -> "Operation":
        await self._done.wait()
        return self


class VmeMaster:
    """Runs cycles one after another; the next starts as soon as the standard allows."""

    def __init__(self, bus: VmeBus, *, timing: VmeTiming | None = None, skew: int = 0, seed=None):
        self.bus = bus
        self.timing = timing or VmeTiming()
        self.skew = skew
        self.random = random.Random(cocotb.RANDOM_SEED if seed is None else seed)
        self.log = logging.getLogger("cocotb.vme")
        self.am = AM_SUPERVISOR
        self.count = self.timeouts = 0
        self.downstream: dict[int, int] = {}  # interrupters behind us on the chain: level -> vector
        self.slowest_ns = 0.0
        self._queue: deque[Operation] = deque()
        self._more = Event()
        bus.idle()
        self._task = cocotb.start_soon(self._run())

    # -- queueing ------------------------------------------------------------------------------

    def init_read(self, address: int, size: int = 1, am: int | None = None, **how) -> Operation:
        return self._init(kind="read", address=address, size=size, am=am, value=0, **how)

    def init_write(
        self, address: int, value: int, size: int = 1, am: int | None = None, **how
    ) -> Operation:
        return self._init(kind="write", address=address, size=size, am=am, value=value, **how)

    def init_iack(self, level: int, **how) -> Operation:
        return self._init(kind="iack", address=level << 1, size=1, am=0x29, value=0, **how)

    def _init(self, **what) -> Operation:
        op = Operation(withdraw_ns=what.pop("withdraw_ns", None), **what)
        self._queue.append(op)
        self._more.set()
        return op

    # -- blocking ------------------------------------------------------------------------------

    async def read(self, address: int, size: int = 1, am: int | None = None, **how) -> int:
        """1 byte, 2 bytes (even address) or 4 bytes in one LWORD* cycle."""
        return await self._finish(self.init_read(address, size, am, **how))

    async def write(
        self, address: int, value: int, size: int = 1, am: int | None = None, **how
    ) -> None:
        await self._finish(self.init_write(address, value, size, am, **how))

    async def iack(self, level: int) -> int:
        """The status/ID for that level; BusTimeout is what a spurious interrupt looks like."""
        return await self._finish(self.init_iack(level))

    async def answers(self, address: int, **how) -> bool:
        """Whether a read is acknowledged."""
        op = await self.init_read(address, **how).wait()
        if op.error and not isinstance(op.error, BusTimeout):
            raise op.error
        return op.error is None

    async def _finish(self, op: Operation) -> int:
        await op.wait()
        if op.error:
            raise op.error
        return op.data

    # -- cycles --------------------------------------------------------------------------------

    async def _run(self):
        while True:
            while not self._queue:
                self._more.clear()
                await self._more.wait()
            op = self._queue.popleft()
            try:
                await self._cycle(op)
            except (BusTimeout, ProtocolError) as error:
                op.error = error
            self.count += 1
            self._log(op)
            op._done.set()

    def _wait(self, least: int) -> Timer | None:
        ns = least + (self.random.randint(0, self.skew) if self.skew else 0)
        return Timer(ns, "ns") if ns else None

    async def _pause(self, least: int) -> None:
        if (timer := self._wait(least)) is not None:
            await timer

    def _strobes(self, op: Operation) -> int:
        if op.kind == "iack":
            return DS_ODD
        if op.size == 1:
            return DS_ODD if op.address & 1 else DS_EVEN
        return DS_BOTH

    async def _cycle(self, op: Operation) -> None:
        bus, t = self.bus, self.timing
        if int(bus.dtack_n.value) == 0:
            raise ProtocolError("DTACK* is low before any strobe")
        strobes = self._strobes(op)
        bus.a.value = (op.address & 0xFFFF) >> 1
        bus.am.value = self.am if op.am is None else op.am
        bus.lword_n.value = 0 if op.size == 4 else 1
        bus.iack_n.value = 0 if op.kind == "iack" else 1
        bus.write_n.value = 0 if op.kind == "write" else 1
        odd = strobes == DS_ODD
        lane = op.value & 0xFF if odd else (op.value if op.size > 1 else op.value << 8)
        # the lane that the cycle does not use carries rubbish
        filler = self.random.getrandbits(16)
        mask = {DS_ODD: 0x00FF, DS_EVEN: 0xFF00, DS_BOTH: 0xFFFF}[strobes]
        bus.d.value = (lane & mask) | (filler & ~mask & 0xFFFF)
        await self._pause(t.setup)
        bus.as_n.value = 0
        await self._pause(t.as_to_ds)
        if strobes == DS_BOTH and t.ds_skew:
            bus.ds_n.value = self.random.choice((DS_ODD, DS_EVEN))
            await Timer(self.random.randint(1, t.ds_skew), "ns")
        bus.ds_n.value = strobes
        op.strobe_ns = get_sim_time("ns")
        if op.kind == "iack":
            await self._pause(10)
            bus.iackin_n.value = 0
        try:
            await self._answer(op)
        finally:
            bus.ds_n.value = DS_NONE
            bus.as_n.value = 1
            bus.iackin_n.value = 1
            bus.iack_n.value = 1
            await self._released(op)
            if op.kind == "write":
                bus.d.value = self.random.getrandbits(16)
            op.end_ns = get_sim_time("ns")
            await self._pause(t.ds_high)

    async def _answer(self, op: Operation) -> None:
        bus = self.bus
        dtack = FallingEdge(bus.dtack_n)
        timer = Timer(self.timing.bus_timer, "ns")
        if op.withdraw_ns is not None:
            timer = Timer(op.withdraw_ns, "ns")
        passed = FallingEdge(bus.iackout_n)
        first = await First(dtack, timer, passed)
        if first is passed:
            if op.kind != "iack":
                raise ProtocolError("IACKOUT* fell without an acknowledge cycle")
            level = op.address >> 1 & 7
            await Timer(50, "ns")
            if level in self.downstream:
                op.data, op.answered = self.downstream[level], True
                if int(bus.q_oe.value) or not int(bus.dtack_n.value):
                    raise ProtocolError("passed the acknowledge on and answered it too")
                return
            first = await First(FallingEdge(bus.dtack_n), timer)
        if first is timer:
            if op.withdraw_ns is not None:
                return
            self.timeouts += 1
            raise BusTimeout(f"{op.kind} {op.address:04X} size {op.size}: BERR*")
        op.dtack_ns = get_sim_time("ns")
        op.answered = True
        self.slowest_ns = max(self.slowest_ns, op.dtack_ns - op.strobe_ns)
        await ReadOnly()
        driven = int(bus.q_oe.value)
        if driven != (op.kind != "write"):
            raise ProtocolError(f"{op.kind} {op.address:04X}: data drivers {driven} at DTACK*")
        seen = bus.data()
        await Timer(1, "ns")
        await self._pause(self.timing.release)
        if op.kind != "write":
            op.bus = bus.data()
            if op.bus != seen:
                raise ProtocolError(f"read {op.address:04X}: {seen:04X} became {op.bus:04X}")
            odd = self._strobes(op) == DS_ODD
            op.data = op.bus & 0xFF if odd else (op.bus if op.size > 1 else op.bus >> 8)
        if int(bus.dtack_n.value):
            raise ProtocolError(f"{op.kind} {op.address:04X}: DTACK* rose before the strobes")

    async def _released(self, op: Operation) -> None:
        """After the strobes have gone: drivers off at once, then DTACK*."""
        bus = self.bus
        await Timer(1, "ns")
        if int(bus.q_oe.value):
            raise ProtocolError(f"{op.kind} {op.address:04X}: data driven after the strobes")
        if not int(bus.dtack_n.value):
            limit = Timer(1000, "ns")
            if await First(RisingEdge(bus.dtack_n), limit) is limit:
                raise ProtocolError(f"{op.kind} {op.address:04X}: DTACK* stays low")

    def _log(self, op: Operation) -> None:
        end = "BERR*" if isinstance(op.error, BusTimeout) else (op.error or "DTACK*")
        data = op.value if op.kind == "write" else op.data
        shown = "--" if data is None else f"{data:0{2 * min(op.size, 2)}X}"
        self.log.debug("%-5s %04X.%d %s %s", op.kind, op.address, op.size, shown, end)


class VmeInterruptHandler:
    """Answers IRQn* with acknowledge cycles, as the host's CPU board would.

    `on_interrupt(level, vector)` is awaited for each; `spurious` counts the unanswered. While it
    runs, that level is masked, as on a 68020.
    """

    def __init__(self, master: VmeMaster, levels, on_interrupt):
        self.master, self.levels, self.on_interrupt = master, tuple(levels), on_interrupt
        self.taken: list[tuple[int, int]] = []
        self.spurious = 0
        self._task = cocotb.start_soon(self._run())

    def _pending(self) -> int | None:
        lines = int(self.master.bus.irq_n.value)  # bit 0 is IRQ1*
        low = [n for n in self.levels if not lines >> (n - 1) & 1]
        return max(low) if low else None

    async def _run(self):
        while True:
            while (level := self._pending()) is None:
                await self.master.bus.irq_n.value_change
            try:
                vector = await self.master.iack(level)
            except BusTimeout:
                self.spurious += 1
                await Timer(1, "us")
                continue
            self.taken.append((level, vector))
            await self.on_interrupt(level, vector)

    def stop(self) -> None:
        self._task.cancel()
