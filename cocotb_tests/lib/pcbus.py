# SPDX-License-Identifier: Apache-2.0
"""The 8-bit PC bus for cocotb: a master for cards alone (§5), a monitor for the adaptor (§4)."""

from dataclasses import dataclass

import cocotb
from cocotb.triggers import ClockCycles, Edge, FallingEdge, First, RisingEdge, Timer
from cocotb.utils import get_sim_time


class PcBus:
    """The signals of one slot, by their contract names."""

    NAMES = {
        "a": "a_i",
        "aen": "aen_i",
        "ior_n": "ior_ni",
        "iow_n": "iow_ni",
        "d": "d_i",
        "q": "d_o",
        "q_oe": "d_oe_o",
        "clk_en": "clk_en_i",
        "reset_drv": "reset_drv_i",
        "drq": "drq_i",
        "irq": "irq_o",
    }

    def __init__(self, **handles):
        self.__dict__.update(handles)

    @classmethod
    def from_prefix(cls, dut, prefix: str) -> "PcBus":
        return cls(**{k: getattr(dut, f"{prefix}_{v}") for k, v in cls.NAMES.items()})

    def idle(self) -> None:
        for name in ("a", "aen", "reset_drv", "drq"):
            getattr(self, name).value = 0
        self.ior_n.value = self.iow_n.value = self.clk_en.value = 1
        self.d.value = 0xFF


class PcBusMaster:
    """I/O cycles as a PC runs them: address, `command` clocks of IOR#/IOW#, data held after."""

    def __init__(self, bus: PcBus, clk, *, command: int = 4, card: int = 0, base: int = 0x300):
        self.bus, self.clk, self.command = bus, clk, command
        self.base = base | card << 10
        bus.idle()

    async def outb(self, address: int, value: int, aen: int = 0) -> None:
        bus = self.bus
        bus.a.value, bus.d.value, bus.aen.value = address, value, aen
        await ClockCycles(self.clk, 1)
        bus.iow_n.value = 0
        await ClockCycles(self.clk, self.command)
        bus.iow_n.value = 1
        await ClockCycles(self.clk, 1)
        bus.d.value, bus.aen.value = 0xFF, 0

    async def inb(self, address: int, aen: int = 0) -> int:
        """What the PC reads: 0xFF where no card drives."""
        bus = self.bus
        bus.a.value, bus.aen.value = address, aen
        await ClockCycles(self.clk, 1)
        bus.ior_n.value = 0
        await ClockCycles(self.clk, self.command)
        value = int(bus.q.value) if int(bus.q_oe.value) else 0xFF
        bus.ior_n.value = 1
        await ClockCycles(self.clk, 1)
        bus.aen.value = 0
        assert not int(bus.q_oe.value), f"{address:04X}: the card drives after IOR#"
        return value

    async def write(self, register: int, value: int) -> None:
        await self.outb(self.base | register, value)

    async def read(self, register: int) -> int:
        return await self.inb(self.base | register)


@dataclass
class PcCycle:
    """One I/O cycle as seen on the bus; times in ns."""

    kind: str
    address: int
    data: int
    start: float
    setup: float
    command: float
    hold: float = 0.0


class PcBusMonitor:
    """Records every cycle on the expansion connector and holds it against the rules of the bus."""

    def __init__(self, dut, prefix: str = "pcx", *, setup_ns: float = 125, command_ns: float = 500):
        self.a = getattr(dut, f"{prefix}_a_o")
        self.d = getattr(dut, f"{prefix}_d_o")
        self.ior_n = getattr(dut, f"{prefix}_ior_no")
        self.iow_n = getattr(dut, f"{prefix}_iow_no")
        self.aen = getattr(dut, f"{prefix}_aen_o")
        self.setup_ns, self.command_ns = setup_ns, command_ns
        self.cycles: list[PcCycle] = []
        self._address_at = 0.0
        self._tasks = [cocotb.start_soon(self._address()), cocotb.start_soon(self._commands())]

    async def _address(self):
        while True:
            await Edge(self.a)
            self._address_at = get_sim_time("ns")
            assert int(self.ior_n.value) and int(self.iow_n.value), "address moved in a command"

    async def _commands(self):
        while True:
            read, write = FallingEdge(self.ior_n), FallingEdge(self.iow_n)
            kind = "read" if await First(read, write) is read else "write"
            start = get_sim_time("ns")
            setup = start - self._address_at
            strobe = self.ior_n if kind == "read" else self.iow_n
            await RisingEdge(strobe)
            end = get_sim_time("ns")
            cycle = PcCycle(kind, int(self.a.value), int(self.d.value), start, setup, end - start)
            self.cycles.append(cycle)
            assert not int(self.aen.value), "AEN high in an I/O cycle"
            assert setup >= self.setup_ns - 1, f"address only {setup} ns before the command"
            assert cycle.command >= self.command_ns - 1, f"command only {cycle.command} ns"
            if kind == "write":
                await Timer(20, "ns")
                assert int(self.d.value) == cycle.data, "write data gone with IOW#"

    def stop(self) -> None:
        for task in self._tasks:
            task.cancel()
