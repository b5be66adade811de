# SPDX-License-Identifier: Apache-2.0
"""Our driver, compiled for this machine, behind any front: each access is a cycle on its pins.

The driver runs in a thread of cocotb's bridge; time passes only while it accesses the bus or waits.
There, as on a processor, an interrupt that is not masked is served between two accesses.
"""

import functools
import re

import cffi
from cocotb.task import bridge, resume
from cocotb.triggers import First, RisingEdge, Timer

from cocotb_tests.adaptor.fronts import VME, Refused
from cocotb_tests.lib.runner import ROOT
from cocotb_tests.lib.tb import DAC1, Machine
from tools.compiled import compiled

SYSCLK_HZ, IRQ_LEVEL, IRQ_VECTOR = 8_000_000, 5, 0x40
RDWR = 2
DRIVES = [Machine.creg(0, register) for register in range(DAC1, DAC1 + 4)]


def text_of(header: str) -> str:
    """The declarations of a header of the firmware, as cffi reads them."""
    text = re.sub(r"/\*.*?\*/", "", (ROOT / "firmware" / header).read_text(), flags=re.S)
    return re.sub(r"^#define(?:.*\\\n)*.*$|^#.*$", "", text, flags=re.M)


@functools.cache
def load():
    """The driver and its port as a library."""
    firmware = ROOT / "firmware"
    sources = [*sorted((firmware / "mc").glob("*.c")), firmware / "ports" / "window.c"]
    include = [f"-I{firmware / d}" for d in ("include", "mc", "ports")]
    flags = ["-std=c11", "-O1", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", *include]
    out = compiled("libmc_window.so", ["cc", *flags], sources)
    ffi = cffi.FFI()
    for header in ("include/mcdef.h", "mc/mc.h", "ports/window.h"):
        ffi.cdef(text_of(header))
    return ffi, ffi.dlopen(str(out))


class Driver:
    """The driver of one machine; its calls are coroutines."""

    def __init__(self, front, on_pass):
        """on_pass(driver) is called after each servo pass."""
        self.front, self.on_pass = front, on_pass
        self.ffi, self.lib = ffi, _ = load()
        self.masked = self.serving = 0
        self.failed: BaseException | None = None  # in a call-back: C knows no exceptions
        self.log: list[str] = []
        self.last_drive = 0.0  # when the last D/A write ended
        self._memory = ffi.new("char[]", self.lib.mc_size())
        self.mc = ffi.cast("struct mc *", self._memory)
        self._keep = []
        bus, os = ffi.new("struct mc_bus *"), ffi.new("struct mc_os *")
        if front.front == VME:
            bus.read8 = self._hear(
                "enum mc_bus_result(void *, uint16_t, uint8_t *)",
                lambda ctx, at, out: self._read(at, out),
            )
            bus.write8 = self._hear(
                "enum mc_bus_result(void *, uint16_t, uint8_t)",
                lambda ctx, at, value: self._write(at, value),
            )
        else:
            window = ffi.new("struct window *")
            window.width = front.width
            window.load = self._hear(
                "enum mc_bus_result(void *, uint32_t, uint32_t *)",
                lambda ctx, at, out: self._read(at, out),
            )
            window.store = self._hear(
                "enum mc_bus_result(void *, uint32_t, uint32_t)",
                lambda ctx, at, value: self._write(at, value),
            )
            self.lib.window_make_bus(bus, window)
            self._keep.append(window)
        os.signal = self._hear("void(void *, int)", lambda ctx, client: None)
        os.log = self._hear(
            "void(void *, const char *)",
            lambda ctx, text: self.log.append(ffi.string(text).decode()),
        )
        os.compute = self._hear("void(void *, unsigned)", lambda ctx, axes: None)
        os.delay_us = self._hear("void(void *, uint32_t)", lambda ctx, us: self._delay(us))
        os.mask = self._hear("unsigned(void *)", lambda ctx: self._mask(1))
        os.unmask = self._hear("void(void *, unsigned)", lambda ctx, before: self._unmask(before))
        os.copy_in = os.copy_out = self._hear(
            "int(void *, void *, const void *, size_t)",
            lambda ctx, to, from_, n: ffi.memmove(to, from_, n) or 0,
        )
        config = ffi.new("struct mc_config *", {"sysclk_hz": SYSCLK_HZ, "vector": IRQ_VECTOR})
        assert self.lib.mc_attach(self.mc, bus, os, config) == 0

    def _hear(self, kind: str, call):
        """A call-back; what it raises is raised again by the call of the driver around it."""

        def heard(*arguments):
            try:
                return call(*arguments)
            except BaseException as error:
                self.failed = self.failed or error
                return 0

        self._keep.append(self.ffi.callback(kind.replace("enum mc_bus_result", "int"), heard))
        pointer = kind.replace("(", "(*)(", 1)
        return self.ffi.cast(pointer, self._keep[-1])

    # --- time: bus accesses, waits, interrupts ---

    def _read(self, at: int, out) -> int:
        front = self.front
        try:
            out[0] = resume(front.vme.read if front.front == VME else front.raw)(self._where(at))
        except Refused:
            return self.lib.MC_BUS_ERROR
        self._poll()
        return self.lib.MC_BUS_OK

    def _write(self, at: int, value: int) -> int:
        front = self.front
        try:
            resume(front.vme.write if front.front == VME else front.raw)(self._where(at), value)
        except Refused:
            return self.lib.MC_BUS_ERROR
        if (at // 2 + 1 if front.width == 32 and front.front != VME else at) in DRIVES:
            self.last_drive = front.now()
        self._poll()
        return self.lib.MC_BUS_OK

    def _where(self, at: int) -> int:
        return 0x6000 | at if self.front.front == VME else at

    def _delay(self, us: int) -> None:
        end = self.front.now() + 1e6 * us
        while (left := end - self.front.now()) > 0:
            resume(self._wait)(left)
            self._poll()

    async def _wait(self, ps: float) -> None:
        """Until an interrupt is asked for, at most so long."""
        timer = Timer(max(int(ps), 1000), "ps")
        if int(self.front.irq.value):
            await Timer(1, "us")
        else:
            await First(timer, RisingEdge(self.front.irq))

    def _mask(self, value: int) -> int:
        before, self.masked = self.masked, value
        return before

    def _unmask(self, before: int) -> None:
        self.masked = before
        self._poll()

    def _poll(self) -> None:
        if self.masked or self.serving or not int(self.front.irq.value):
            return
        self.serving, before = 1, self._mask(1)
        if self.front.front == VME:
            vector = resume(self.front.vme.iack)(IRQ_LEVEL)
            assert vector == IRQ_VECTOR, f"vector {vector:02X}"
        if self.lib.mc_interrupt(self.mc):
            self.on_pass(self)
        self.serving = 0
        self._mask(before)

    # --- the device ---

    async def _call(self, function, *arguments) -> int:
        result = await bridge(lambda: function(*arguments))()
        if self.failed:
            raise self.failed
        return result

    async def open(self) -> int:
        return await self._call(self.lib.mc_open, self.mc, RDWR)

    async def ioctl(self, client: int, request: int, argument=None) -> int:
        data = self.ffi.NULL if argument is None else argument
        return await self._call(self.lib.mc_ioctl, self.mc, client, request, data)

    async def write(self, client: int, setpoints: list[int]) -> int:
        data = self.ffi.new("int[]", setpoints)
        return await self._call(self.lib.mc_write, self.mc, client, data, 4 * len(setpoints))

    async def sleep(self, us: int) -> None:
        """The process sleeps; interrupts are served."""
        await self._call(self._delay, us)
