# SPDX-License-Identifier: Apache-2.0
"""The VME models on vme_ram.sv: memory, read-modify-write, bus timer, an interrupt."""

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, Timer
from cocotbext.vme import BusTimeout, VmeBus, VmeInterruptHandler, VmeMaster, VmeMonitor

TOPLEVEL = "vme_ram"


@cocotb.test()
async def memory_and_interrupt(dut):
    Clock(dut.clk_i, 10, "ns").start()
    dut.rst_ni.value = 0
    bus = VmeBus.from_prefix(dut, "vme")
    vme = VmeMaster(bus, skew=20, seed=1)
    monitor = VmeMonitor(bus)  # fails the test where either side breaks a rule
    await ClockCycles(dut.clk_i, 4)
    dut.rst_ni.value = 1

    await vme.write(0x1000, 0xCAFE, size=2)  # D16
    await vme.write(0x1001, 0x42)  # D08(O)
    assert await vme.read(0x1000) == 0xCA  # D08(E)
    assert await vme.rmw(0x1001, lambda old: old | 0x80) == 0x42
    assert await vme.read(0x1000, size=2) == 0xCAC2

    writes = [vme.init_write(0x1010 + n, n) for n in range(8)]  # queued
    await writes[-1].wait()
    assert [await vme.read(0x1010 + n) for n in range(8)] == list(range(8))

    with pytest.raises(BusTimeout):
        await vme.read(0x2000, size=2)

    async def on_interrupt(level: int, vector: int) -> None:
        dut._log.info("level %d, vector %02X", level, vector)

    handler = VmeInterruptHandler(vme, (3, 5), on_interrupt)
    await vme.write(0x10FF, 0x77)
    await Timer(2, "us")
    assert handler.taken == [(3, 0x77)]
    assert [c.kind for c in monitor.cycles].count("iack") == 1
    assert monitor.cycles[0].data == 0xCAFE and not monitor.broken
