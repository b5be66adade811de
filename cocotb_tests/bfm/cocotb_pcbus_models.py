# SPDX-License-Identifier: Apache-2.0
"""The PC bus models against each other: traffic, wait states, every rule broken once."""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, Timer
from cocotbext.pcbus import BusTimeout, PcBus, PcBusMaster, PcBusMonitor, PcBusSlave, ProtocolError
from cocotbext.pcbus.monitor import RULES

from cocotb_tests.bfm.cases import raises, refused
from cocotb_tests.lib.play import drive

TOPLEVEL = "bench_wires"
SOURCES = ["bench_wires.sv"]


async def wires(dut) -> PcBus:
    bus = PcBus.from_prefix(dut, "pc")
    bus.idle()
    bus.silent()
    await Timer(10, "ns")
    return bus


@cocotb.test()
async def traffic_with_wait_states(dut):
    """Two cards, random waits; compared with a copy. Cycles that are nobody's read 0xFF."""
    bus = await wires(dut)
    Clock(dut.clk_i, 125, "ns").start()
    pc = PcBusMaster(bus, dut.clk_i)
    slave = PcBusSlave(bus, base=0x300, size=32, access_ns=(50, 400), wait_ns=(0, 2000), seed=7)
    monitor = PcBusMonitor(bus, recovery_ns=250, allow=("aen",))
    await ClockCycles(dut.clk_i, 2)
    copy, random, compared = bytearray(32), slave.random, 0
    for _ in range(80):
        at = random.randrange(32)
        if random.randrange(2):
            copy[at] = random.randrange(256)
            await pc.outb(0x300 + at, copy[at])
        else:
            assert await pc.inb(0x300 + at) == copy[at]
            compared += 1
    assert slave.registers == copy and compared > 25
    lengths = {c.command for c in monitor.cycles}
    assert min(lengths) == 500 and max(lengths) > 1500
    assert await pc.inb(0x320) == 0xFF and await pc.inb(0x300, aen=1) == 0xFF
    assert [c.data for c in monitor.cycles[-2:]] == [0xFF, 0xFF]
    assert slave.reads + slave.writes == 80 == len(monitor.cycles) - 2


@cocotb.test()
async def hooks_interrupts_and_patience(dut):
    bus = await wires(dut)
    Clock(dut.clk_i, 125, "ns").start()
    pc, seen = PcBusMaster(bus, dut.clk_i, base=0x200, limit=8), []
    slave = PcBusSlave(
        bus, base=0x200, size=4, on_read=lambda at: 0x40 + at, on_write=lambda *w: seen.append(w)
    )
    assert await pc.read(3) == 0x43
    await pc.write(1, 0x99)
    assert seen == [(1, 0x99)]
    slave.interrupt(2, 1)
    await Timer(1, "ns")
    assert int(dut.pc_irq_o.value) == 4
    slave.wait_ns = (5000, 5000)
    with raises(BusTimeout, "inb 0200: IOCHRDY low for more than 8 clocks"):
        await pc.read(0)
    slave.wait_ns = (0, 0)
    assert await pc.read(0) == 0x40
    slave.stop()
    await ClockCycles(dut.clk_i, 2)
    dut.pc_d_oe_o.value = 1
    with raises(ProtocolError, "inb 0200: the card drives after IOR#"):
        await pc.read(0)


# --- every rule goes red ------------------------------------------------------------------------


def write(setup: int = 200, command: int = 600) -> str:
    return f"a=0x123 d=0x45 {setup} iow_n=0 {command} iow_n=1 100 a=0 d=0xFF 200"


BROKEN = {
    "one_command": "a=0x50 200 ior_n=0 iow_n=0 600 ior_n=1 iow_n=1",
    "aen": f"aen=1 {write()} aen=0",
    "setup": write(setup=50),
    "command": write(command=300),
    "longest": write(command=3000),
    "recovery": "iow_n=0 600 iow_n=1 50 iow_n=0 600 iow_n=1 50",
    "address_held": "a=0x10 200 ior_n=0 300 a=0x11 300 ior_n=1 100",
    "address_after": "a=0x10 200 ior_n=0 600 ior_n=1 5 a=0",
    "data_held": "d=0x10 200 iow_n=0 600 iow_n=1 d=0x11",
    "drive_in_read": "q_oe=1 10 q_oe=0",
}


@cocotb.test()
async def every_rule_is_seen(dut):
    """Each stimulus breaks the rule of its name and no other, a good cycle none."""
    assert BROKEN.keys() == RULES.keys()
    bus = await wires(dut)
    for rules, stimulus in [([], write()), *(([rule], s) for rule, s in BROKEN.items())]:
        await Timer(500, "ns")
        monitor = PcBusMonitor(bus, recovery_ns=200, longest_ns=2000, fail=False)
        await Timer(10, "ns")
        await drive(bus, stimulus)
        await Timer(100, "ns")
        assert {name for name, ns, text in monitor.broken} == set(rules)
        monitor.stop()


@cocotb.test(expect_error=ProtocolError)
async def a_broken_rule_fails_the_test(dut):
    bus = await wires(dut)
    PcBusMonitor(bus)
    await Timer(10, "ns")
    await drive(bus, BROKEN["command"])


@cocotb.test()
async def wrong_arguments_end_in_one_sentence(dut):
    bus = await wires(dut)
    pc = PcBusMaster(bus, dut.clk_i)
    bare = PcBus(a=dut.pc_a_i, d=dut.pc_d_i, ior_n=dut.pc_ior_ni, iow_n=dut.pc_iow_ni)
    with raises(ValueError, "address is 0 to 0xffff, not 0x10000"):
        await pc.inb(0x10000)
    with raises(ValueError, "value is 0 to 255, not 300"):
        await pc.outb(0, 300)
    with raises(ValueError, "aen is 0 to 0, not 1"):
        await PcBusMaster(bare, dut.clk_i).outb(0, 0, aen=1)
    refused(
        (ValueError, "command is 1 or more", lambda: PcBusMaster(bus, dut.clk_i, command=0)),
        (ValueError, "this bus has no signal q", bare.data),
        (ValueError, "wait_ns needs the signal iochrdy", lambda: PcBusSlave(
            bare, base=0, size=1, wait_ns=100)),
        (ValueError, "a slave needs the signal q", lambda: PcBusSlave(bare, base=0, size=1)),
        (ValueError, "size is 1 to 0x10000, not 0", lambda: PcBusSlave(bus, base=0, size=0)),
        (TypeError, "on_read is a function", lambda: PcBusSlave(bus, base=0, size=1, on_read=5)),
        (ValueError, "access_ns, the longest is 9 or more", lambda: PcBusSlave(
            bus, base=0, size=1, access_ns=(9, 5))),
        (ValueError, "a rule to allow is one of", lambda: PcBusMonitor(bus, allow=("Aen",))),
        (TypeError, "PcBus has no signal ior", lambda: PcBus(ior=1)),
        (TypeError, "PcBus needs the signal a", lambda: PcBus(d=1)),
    )  # fmt: skip
