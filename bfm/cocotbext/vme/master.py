# SPDX-License-Identifier: Apache-2.0
"""A VME master with its bus timer and IACK* daisy-chain driver.

    vme = VmeMaster(VmeBus.from_prefix(dut, "vme"))
    await vme.write(0x6409, 0xB8)          # blocking; BusTimeout where nobody answers
    op = vme.init_read(0x6409)             # queued; op.data after `await op.wait()`

All timing is that of the standard's tables, in ns, with no relation to the clock of the design:
`VmeTiming` holds the least values, `skew` adds up to so many ns at random to each of them.
"""

from collections import deque

import cocotb
from cocotb.triggers import Event, FallingEdge, First, ReadOnly, RisingEdge, Timer
from cocotb.utils import get_sim_time
from cocotbext.mmcs import logger, one_of, pin, seeded, whole
from cocotbext.mmcs.bus import ProtocolError
from cocotbext.vme.bus import (
    AM_SUPERVISOR,
    DS_BOTH,
    DS_EVEN,
    DS_NONE,
    DS_ODD,
    SPACES,
    BusError,
    BusTimeout,
    VmeBus,
    VmeTiming,
)

# What `spoil` may change between the data strobes and DTACK*.
SPOILT = ("address", "am", "lword", "write", "data", "as")
IACK_DELAY = 10  # ns from the strobes to IACKIN* of the first slot


class Operation:
    """One queued cycle and what became of it."""

    def __init__(self, **what):
        self.address: int = 0
        self.withdraw_ns: int | None = None
        self.spoil: tuple[str, int] | None = None
        self.modify = None
        self.__dict__.update(what)
        self.data: int | None = None
        self.bus: int | None = None  # the data lines while DTACK* was low
        self.error: Exception | None = None
        self.answered = False
        self.strobe_ns = self.dtack_ns = self.end_ns = 0.0
        self._done = Event()

    async def wait(self) -> "Operation":
        await self._done.wait()
        return self

    def __str__(self) -> str:
        return f"{self.kind} {self.address:04X} size {self.size}"


class VmeMaster:
    """Runs cycles one after another; the next starts as soon as the standard allows."""

    def __init__(self, bus: VmeBus, *, timing: VmeTiming | None = None, skew: int = 0, seed=None):
        self.bus = bus
        self.timing = timing or VmeTiming()
        self.skew = whole("skew", skew, 0)
        self.random = seeded(seed)
        self.log = logger("vme", bus.as_n)
        self.am = AM_SUPERVISOR
        self.count = self.timeouts = 0
        self.downstream: dict[int, int] = {}  # interrupters behind us on the chain: level -> vector
        self.slowest_ns = 0.0
        self._queue: deque[Operation] = deque()
        self._more = Event()
        bus.idle()
        self._task = cocotb.start_soon(self._run())
        self.log.debug(
            "VME master: A%02d-A01, D%02d-D00", bus.address_width - 1, bus.data_width - 1
        )

    # -- queueing ------------------------------------------------------------------------------

    def init_read(self, address: int, size: int = 1, am: int | None = None, **how) -> Operation:
        return self._init("read", address, size, am, 0, how)

    def init_write(
        self, address: int, value: int, size: int = 1, am: int | None = None, **how
    ) -> Operation:
        return self._init("write", address, size, am, value, how)

    def init_rmw(
        self, address: int, modify, size: int = 1, am: int | None = None, **how
    ) -> Operation:
        """Read, and under the same AS* write what `modify` makes of it; op.data is what was."""
        if not callable(modify):
            raise TypeError(f"modify is a function of the value read, not {modify!r}")
        return self._init("rmw", address, size, am, 0, how | {"modify": modify})

    def init_iack(self, level: int, size: int = 1, **how) -> Operation:
        whole("level", level, 1, 7)
        one_of("size of a status/ID", size, (1, 2))
        return self._init("iack", level << 1, size, 0x29, 0, how)

    def _init(self, kind: str, address: int, size: int, am: int | None, value: int, how: dict):
        self._check(address, size, self.am if am is None else am, value, dict(how))
        op = Operation(kind=kind, address=address, size=size, am=am, value=value, **how)
        self._queue.append(op)
        self._more.set()
        return op

    def _check(self, address: int, size: int, am: int, value: int, how: dict) -> None:
        one_of("size", size, (1, 2, 4))
        whole("address modifier", am, 0, 63)
        lines = min(SPACES.get(am, 32), self.bus.address_width)
        whole(f"address under modifier {am:#04x}", address, 0, (1 << lines) - 1)
        if address % size:
            raise ValueError(f"an address of size {size} is a multiple of it, not {address:#x}")
        whole(f"value of size {size}", value, 0, (1 << 8 * size) - 1)
        if (ns := how.pop("withdraw_ns", None)) is not None:
            whole("withdraw_ns", ns, 1)
        if (spoil := how.pop("spoil", None)) is not None:
            if not isinstance(spoil, tuple) or len(spoil) != 2:
                raise TypeError(f"spoil is a pair, line and ns, not {spoil!r}")
            one_of("the line to spoil", spoil[0], SPOILT)
            whole("the ns after which it is spoilt", spoil[1], 1)
        how.pop("modify", None)
        if how:
            raise TypeError(f"a cycle has no option {next(iter(how))!r}")

    # -- blocking ------------------------------------------------------------------------------

    async def read(self, address: int, size: int = 1, am: int | None = None, **how) -> int:
        """1 byte, 2 bytes (even address) or 4 bytes in one LWORD* cycle."""
        return await self._finish(self.init_read(address, size, am, **how))

    async def write(
        self, address: int, value: int, size: int = 1, am: int | None = None, **how
    ) -> None:
        await self._finish(self.init_write(address, value, size, am, **how))

    async def rmw(self, address: int, modify, size: int = 1, am: int | None = None, **how) -> int:
        return await self._finish(self.init_rmw(address, modify, size, am, **how))

    async def iack(self, level: int, size: int = 1) -> int:
        """The status/ID for that level; BusTimeout is what a spurious interrupt looks like."""
        return await self._finish(self.init_iack(level, size))

    async def answers(self, address: int, **how) -> bool:
        """Whether a read is acknowledged."""
        op = await self.init_read(address, **how).wait()
        if op.error and not isinstance(op.error, BusError):
            raise op.error
        return op.error is None

    async def idle(self) -> None:
        """Until all that is queued is done."""
        while self._queue:
            await self._queue[-1].wait()

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
            except Exception as error:  # also what `modify` raises: it belongs to who waits
                op.error = error
                if not isinstance(error, BusError):
                    self.log.warning("%s: %s", op, error)
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
        if op.size == 1 and op.kind == "iack":
            return DS_ODD
        if op.size == 1:
            return DS_ODD if op.address & 1 else DS_EVEN
        return DS_BOTH

    async def _cycle(self, op: Operation) -> None:
        bus = self.bus
        if pin(bus.dtack_n) == 0:
            raise ProtocolError("DTACK* is low before any strobe")
        if bus.berr_n is not None and pin(bus.berr_n) == 0:
            raise ProtocolError("BERR* is low before any strobe")
        bus.a.value = (op.address & (1 << bus.address_width) - 1) >> 1
        bus.am.value = self.am if op.am is None else op.am
        bus.put(lword_n=int(op.size != 4), iack_n=int(op.kind != "iack"))
        if op.kind != "rmw":
            await self._transfer(op, op.kind == "write", op.value)
            return
        await self._transfer(op, False, 0, last=False)
        try:
            most = (1 << 8 * op.size) - 1
            new = whole(f"what modify gives, size {op.size}", op.modify(op.data), 0, most)
        except BaseException:
            bus.as_n.value = 1
            raise
        await self._transfer(op, True, new)

    async def _transfer(self, op: Operation, write: bool, value: int, last: bool = True) -> None:
        """The data strobes of a cycle, and all that hangs on them."""
        bus, t = self.bus, self.timing
        strobes = self._strobes(op)
        bus.write_n.value = 0 if write else 1
        odd = strobes == DS_ODD
        lane = value & 0xFF if odd else (value if op.size > 1 else value << 8)
        # the lanes that the cycle does not use carry rubbish
        filler = self.random.getrandbits(max(16, bus.data_width))
        mask = {DS_ODD: 0x00FF, DS_EVEN: 0xFF00, DS_BOTH: 0xFFFF}[strobes]
        mask = 0xFFFF_FFFF if op.size == 4 else mask
        bus.d.value = ((lane & mask) | (filler & ~mask)) & (1 << bus.data_width) - 1
        await self._pause(t.setup)
        bus.as_n.value = 0
        await self._pause(t.as_to_ds)
        if strobes == DS_BOTH and t.ds_skew:
            bus.ds_n.value = self.random.choice((DS_ODD, DS_EVEN))
            await Timer(self.random.randint(1, t.ds_skew), "ns")
        bus.ds_n.value = strobes
        op.strobe_ns = get_sim_time("ns")
        if op.kind == "iack" and bus.iackin_n is not None:
            await self._pause(IACK_DELAY)
            bus.iackin_n.value = 0
        spoiler = cocotb.start_soon(self._spoil(op)) if op.spoil else None
        try:
            await self._answer(op, write)
        except BaseException:
            last = True
            raise
        finally:
            if spoiler:
                spoiler.cancel()
            bus.ds_n.value = DS_NONE
            if last:
                bus.put(as_n=1, iackin_n=1, iack_n=1)
            await self._released(op)
            if write:
                bus.d.value = self.random.getrandbits(max(16, bus.data_width)) & (
                    (1 << bus.data_width) - 1
                )
            op.end_ns = get_sim_time("ns")
            await self._pause(t.ds_high)

    async def _spoil(self, op: Operation) -> None:
        """The one rule broken on purpose: a line moves between the strobes and DTACK*."""
        bus, (line, ns) = self.bus, op.spoil
        await Timer(ns, "ns")
        if line == "as":
            bus.as_n.value = 1
            return
        handle = {"address": bus.a, "am": bus.am, "lword": bus.lword_n, "write": bus.write_n,
                  "data": bus.d}[line]  # fmt: skip
        handle.value = int(handle.value) ^ 1

    async def _answer(self, op: Operation, write: bool) -> None:
        """Until DTACK*, BERR*, the bus timer, or the end that the operation asks for."""
        bus = self.bus
        dtack = FallingEdge(bus.dtack_n)
        timer = Timer(self.timing.bus_timer, "ns")
        if op.withdraw_ns is not None:
            timer = Timer(op.withdraw_ns, "ns")
        ends = [dtack, timer]
        passed = berr = None
        if bus.iackout_n is not None:
            passed = FallingEdge(bus.iackout_n)
            ends.append(passed)
        if bus.berr_n is not None:
            berr = FallingEdge(bus.berr_n)
            ends.append(berr)
        first = await First(*ends)
        if first is passed:
            if op.kind != "iack":
                raise ProtocolError("IACKOUT* fell without an acknowledge cycle")
            level = op.address >> 1 & 7
            await Timer(50, "ns")
            if level in self.downstream:
                op.data, op.answered = self.downstream[level], True
                if bus.driven() or not pin(bus.dtack_n):
                    raise ProtocolError("passed the acknowledge on and answered it too")
                return
            ends.remove(passed)
            ends[0] = FallingEdge(bus.dtack_n)
            first = await First(*ends)
        if first is timer:
            if op.withdraw_ns is not None:
                return
            self.timeouts += 1
            raise BusTimeout(f"{op}: BERR*")
        if first is berr:
            await Timer(1, "ns")
            await self._pause(self.timing.release)
            raise BusError(f"{op}: BERR* from the slave")
        op.dtack_ns = get_sim_time("ns")
        op.answered = True
        self.slowest_ns = max(self.slowest_ns, op.dtack_ns - op.strobe_ns)
        await ReadOnly()
        if bus.driven() not in (None, not write):
            raise ProtocolError(f"{op}: data drivers {int(bus.driven())} at DTACK*")
        seen = None if write else bus.data()
        await Timer(1, "ns")
        await self._pause(self.timing.release)
        if not write:
            op.bus = bus.data()
            if op.bus != seen:
                raise ProtocolError(f"{op}: {seen:04X} became {op.bus:04X}")
            odd = self._strobes(op) == DS_ODD
            word = op.bus if op.size == 4 else op.bus & 0xFFFF
            op.data = op.bus & 0xFF if odd else (word if op.size > 1 else word >> 8)
        if pin(bus.dtack_n):
            raise ProtocolError(f"{op}: DTACK* rose before the strobes")

    async def _released(self, op: Operation) -> None:
        """After the strobes have gone: drivers off at once, then DTACK*."""
        bus = self.bus
        await Timer(1, "ns")
        if bus.driven():
            raise ProtocolError(f"{op}: data driven after the strobes")
        for name, line in (("DTACK*", bus.dtack_n), ("BERR*", bus.berr_n)):
            if line is not None and not pin(line):
                limit = Timer(1000, "ns")
                if await First(RisingEdge(line), limit) is limit:
                    raise ProtocolError(f"{op}: {name} stays low")

    def _log(self, op: Operation) -> None:
        end = "BERR*" if isinstance(op.error, BusError) else (op.error or "DTACK*")
        data = op.value if op.kind == "write" else op.data
        shown = "--" if data is None else f"{data:0{2 * op.size}X}"
        self.log.debug("%-5s %04X.%d %s %s", op.kind, op.address, op.size, shown, end)
