# SPDX-License-Identifier: Apache-2.0
"""The two ends of the priority interrupt bus: a handler, and an interrupter on the daisy chain."""

import cocotb
from cocotb.triggers import Event, FallingEdge, First, RisingEdge, Timer
from cocotbext.mmcs import logger, one_of, pin, whole
from cocotbext.vme.bus import BusError, VmeBus
from cocotbext.vme.master import VmeMaster


class VmeInterruptHandler:
    """Answers IRQn* with acknowledge cycles, as the host's CPU board would.

    `on_interrupt(level, vector)` is awaited for each; `spurious` counts the unanswered. While it
    runs, that level is masked, as on a 68020.
    """

    def __init__(self, master: VmeMaster, levels, on_interrupt):
        if master.bus.irq_n is None:
            raise ValueError("a handler needs the signal irq_n of its master's bus")
        self.levels = tuple(whole("level", n, 1, 7) for n in levels)
        if not self.levels:
            raise ValueError("levels holds one level at least")
        if not callable(on_interrupt):
            raise TypeError(f"on_interrupt is a coroutine function, not {on_interrupt!r}")
        self.master, self.on_interrupt = master, on_interrupt
        self.taken: list[tuple[int, int]] = []
        self.spurious = 0
        self._task = cocotb.start_soon(self._run())

    def _pending(self) -> int | None:
        lines = pin(self.master.bus.irq_n)  # bit 0 is IRQ1*
        low = [n for n in self.levels if not lines >> (n - 1) & 1]
        return max(low) if low else None

    async def _run(self):
        while True:
            while (level := self._pending()) is None:
                await self.master.bus.irq_n.value_change
            try:
                vector = await self.master.iack(level)
            except BusError:
                self.spurious += 1
                await Timer(1, "us")
                continue
            self.taken.append((level, vector))
            await self.on_interrupt(level, vector)
            await Timer(1, "ps")  # a request withdrawn at this instant is gone

    def stop(self) -> None:
        self._task.cancel()


class VmeInterrupter:
    """Asks on a level and answers the acknowledge with its vector, or passes IACKIN* on.

    `iackin` and `iackout` are its place on the chain: by default the bus's own pins; without an
    `iackin` it is the first behind IACK* itself. `release`: "acknowledge" takes the request back
    with the vector (ROAK), "register" leaves that to `withdraw()` (RORA).
    """

    def __init__(
        self, bus: VmeBus, level: int, vector: int, *, iackin=None, iackout=None,
        release: str = "acknowledge", delay_ns: int = 50,
    ):  # fmt: skip
        if bus.irq_n is None:
            raise ValueError("an interrupter needs the signal irq_n")
        self.bus, self.level = bus, whole("level", level, 1, 7)
        self.vector = whole("vector", vector, 0, 0xFF)
        self.release = one_of("release", release, ("acknowledge", "register"))
        self.delay_ns = whole("delay_ns", delay_ns, 30)
        self.iackin = next((h for h in (iackin, bus.iackin_n, bus.iack_n) if h is not None), None)
        if self.iackin is None:
            raise ValueError("an interrupter needs iackin, or a bus with iackin_n or iack_n")
        self.iackout = iackout if iackout is not None else bus.iackout_n
        self.log = logger("vme", bus.irq_n)
        self.pending = False
        self.acknowledged, self.passed = 0, 0
        self.taken = Event()  # set with each vector given
        if self.iackout is not None:
            self.iackout.value = 1
        self._task = cocotb.start_soon(self._run())

    def request(self) -> None:
        self.pending = True
        self.bus.pull("irq_n", self, True, self.level - 1)

    def withdraw(self) -> None:
        self.pending = False
        self.bus.pull("irq_n", self, False, self.level - 1)

    def stop(self) -> None:
        """Answers nothing any more and asks for nothing; it passes nothing on, either."""
        self._task.cancel()
        self.withdraw()

    async def _run(self) -> None:
        bus = self.bus
        while True:
            if pin(self.iackin):
                await FallingEdge(self.iackin)
            await Timer(10, "ns")
            level = pin(bus.a) & 7  # A03-A01
            if self.pending and level == self.level:
                await self._answer()
            else:
                await self._pass_on()
            if not pin(self.iackin):
                await RisingEdge(self.iackin)

    async def _answer(self) -> None:
        bus = self.bus
        end = RisingEdge(bus.as_n)
        while pin(bus.ds_n) & 1:  # waits for DS0*, or for the end of the cycle
            if await First(bus.ds_n.value_change, end) is end:
                return
        await Timer(self.delay_ns - 20, "ns")
        bus.put(q=self.vector | ((1 << len(bus.q)) - 1) & ~0xFF, q_oe=1)
        await Timer(20, "ns")
        bus.pull("dtack_n", self, True)
        if self.release == "acknowledge":
            self.withdraw()
        while pin(bus.ds_n) != 3:
            await bus.ds_n.value_change
        bus.put(q_oe=0)
        await Timer(10, "ns")
        bus.pull("dtack_n", self, False)
        self.acknowledged += 1
        self.log.debug("level %d acknowledged, vector %02X", self.level, self.vector)
        self.taken.set()

    async def _pass_on(self) -> None:
        self.passed += 1
        if self.iackout is None:
            return
        self.iackout.value = 0
        if not pin(self.bus.as_n):
            await RisingEdge(self.bus.as_n)
        self.iackout.value = 1
