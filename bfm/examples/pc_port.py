# SPDX-License-Identifier: Apache-2.0
"""The PC bus models on pc_port.sv: a register, and wait states up to the master's limit."""

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles
from cocotbext.pcbus import BusTimeout, PcBus, PcBusMaster, PcBusMonitor

TOPLEVEL = "pc_port"


@cocotb.test()
async def register_and_wait_states(dut):
    Clock(dut.clk_i, 124, "ns").start()
    dut.rst_ni.value = 0
    bus = PcBus.from_prefix(dut, "pc")
    pc = PcBusMaster(bus, dut.clk_i, command=5, base=0x300, limit=50)
    monitor = PcBusMonitor(bus, setup_ns=100, command_ns=600, allow=("aen",))
    await ClockCycles(dut.clk_i, 4)
    dut.rst_ni.value = 1

    await pc.write(0, 0x5A)
    assert await pc.read(0) == 0x5A
    assert await pc.inb(0x2F8) == 0xFF  # nobody is there
    assert await pc.inb(0x300, aen=1) == 0xFF  # a DMA cycle is not for the card

    await pc.write(1, 20)
    assert await pc.read(0) == 0x5A
    assert monitor.cycles[-1].command >= 20 * 124

    await pc.write(1, 200)
    with pytest.raises(BusTimeout):  # the card holds IOCHRDY for 200 clocks
        await pc.read(0)
