# SPDX-License-Identifier: Apache-2.0
"""Every rule of the VME monitor is broken once, and no other with it; good traffic breaks none."""

import cocotb
from cocotb.triggers import Timer
from cocotbext.vme import ProtocolError, VmeBus, VmeMaster, VmeMonitor, VmeSlave, VmeTiming
from cocotbext.vme.monitor import RULES

from cocotb_tests.bfm.cases import wires

TOPLEVEL = "bench_wires"
SOURCES = ["bench_wires.sv"]

BREAK = {
    "addr_setup": {"setup": 5},
    "write_setup": {"setup": 5},
    "data_setup": {"setup": 5},
    "ds_skew": {"ds_skew": 40},
    "ds_high": {"ds_high": 0, "setup": 5},
    "as_high": {"ds_high": 0, "setup": 5},
}
SPOIL = {"address": "address_held", "am": "address_held", "lword": "address_held",
         "write": "write_held", "data": "data_held", "as": "as_held"}  # fmt: skip


async def traffic(vme: VmeMaster, **how) -> set:
    for n in range(6):
        await vme.init_write(2 * n, n, size=2, **how).wait()
        await vme.init_read(2 * n, size=2, **how).wait()


@cocotb.test()
@cocotb.parametrize(rule=list(BREAK))
async def illegal_timing_is_seen(dut, rule):
    """The same traffic breaks nothing by the standard's times, and that rule by shorter ones."""
    bus = await wires(dut)
    slave = VmeSlave(bus, base=0, size=64)
    monitor = VmeMonitor(bus, fail=False)
    vme = VmeMaster(bus)
    await traffic(vme)
    assert not monitor.broken and slave.answered == 12
    vme.timing = VmeTiming(**BREAK[rule], illegal=True)
    await traffic(vme)
    assert rule in {name for name, ns, text in monitor.broken}
    assert {name for name, ns, text in monitor.broken} <= BREAK.keys()


@cocotb.test()
@cocotb.parametrize(line=list(SPOIL))
async def a_spoilt_line_is_seen(dut, line):
    bus = await wires(dut)
    VmeSlave(bus, base=0, size=64, delay_ns=400)
    monitor = VmeMonitor(bus, fail=False, bus_timer=1000)
    vme = VmeMaster(bus, timing=VmeTiming(bus_timer=1000))
    op = await vme.init_write(0x10, 0x1234, size=2, spoil=(line, 100)).wait()
    assert {name for name, ns, text in monitor.broken} == {SPOIL[line]}, op
    assert monitor.broken[0][1] == op.strobe_ns + 100


async def cycle(bus: VmeBus, write: int = 0) -> None:
    """The master's half of a cycle, up to its strobe."""
    bus.a.value, bus.am.value, bus.write_n.value = 0x10, 0x2D, 1 - write
    await Timer(50, "ns")
    bus.as_n.value = 0
    bus.ds_n.value = 0
    await Timer(50, "ns")


async def finish(bus: VmeBus) -> None:
    bus.ds_n.value, bus.as_n.value = 3, 1
    await Timer(20, "ns")
    bus.q_oe.value = 0
    await Timer(5, "ns")
    bus.dtack_n.value = bus.berr_n.value = 1
    await Timer(60, "ns")


async def dtack_alone(bus):
    bus.dtack_n.value = 0
    await Timer(50, "ns")
    bus.dtack_n.value = 1


async def next_strobe(bus):
    await cycle(bus, write=1)
    bus.dtack_n.value = 0
    await Timer(20, "ns")
    bus.ds_n.value, bus.as_n.value = 3, 1
    await Timer(60, "ns")
    bus.as_n.value = 0
    bus.ds_n.value = 0
    await Timer(60, "ns")
    await finish(bus)


async def ds_to_dtack(bus):
    bus.a.value, bus.write_n.value = 0x10, 0
    await Timer(50, "ns")
    bus.as_n.value = bus.ds_n.value = 0
    await Timer(20, "ns")
    bus.dtack_n.value = 0
    await Timer(20, "ns")
    await finish(bus)


async def one_answer(bus):
    await cycle(bus, write=1)
    bus.dtack_n.value = 0
    await Timer(20, "ns")
    bus.berr_n.value = 0
    await Timer(20, "ns")
    await finish(bus)


async def dtack_early(bus):
    await cycle(bus, write=1)
    bus.dtack_n.value = 0
    await Timer(20, "ns")
    bus.dtack_n.value = 1
    await Timer(20, "ns")
    await finish(bus)


async def data_first(bus):
    await cycle(bus)
    bus.dtack_n.value = 0
    await Timer(20, "ns")
    await finish(bus)


async def data_stands(bus):
    await cycle(bus)
    bus.q_oe.value = 1
    await Timer(10, "ns")
    bus.dtack_n.value = 0
    await Timer(20, "ns")
    bus.q.value = 0x1234
    await Timer(20, "ns")
    await finish(bus)


async def drive_on_write(bus):
    await cycle(bus, write=1)
    bus.q_oe.value = 1
    await Timer(20, "ns")
    bus.dtack_n.value = 0
    await Timer(20, "ns")
    await finish(bus)


async def drive_idle(bus):
    bus.q_oe.value = 1
    await Timer(20, "ns")
    bus.q_oe.value = 0


async def drivers_off(bus):
    await cycle(bus)
    bus.q_oe.value = 1
    await Timer(10, "ns")
    bus.dtack_n.value = 0
    await Timer(20, "ns")
    bus.ds_n.value, bus.as_n.value = 3, 1
    await Timer(10, "ns")
    bus.dtack_n.value = 1
    await Timer(10, "ns")
    bus.q_oe.value = 0


async def one_fate(bus):
    bus.iack_n.value = 0
    await cycle(bus)
    bus.iackin_n.value = 0
    await Timer(20, "ns")
    bus.iackout_n.value = 0
    bus.q_oe.value = 1
    await Timer(20, "ns")
    bus.dtack_n.value = 0
    await Timer(20, "ns")
    bus.iackin_n.value = bus.iackout_n.value = 1
    await finish(bus)


async def iackout_alone(bus):
    bus.iackout_n.value = 0
    await Timer(20, "ns")
    bus.iackout_n.value = 1


async def chain_in_cycle(bus):
    bus.iackin_n.value = 0
    await Timer(20, "ns")
    bus.iackin_n.value = 1


async def as_to_ds(bus):
    bus.ds_n.value = 0
    await Timer(200, "ns")
    bus.ds_n.value = 3


async def strobe_held(bus):
    await cycle(bus)
    await finish(bus)


BROKEN = (dtack_alone, next_strobe, ds_to_dtack, one_answer, dtack_early, data_first, data_stands,
          drive_on_write, drive_idle, drivers_off, one_fate, iackout_alone, chain_in_cycle,
          as_to_ds, strobe_held)  # fmt: skip


@cocotb.test()
async def every_other_rule_is_seen(dut):
    """Each stimulus breaks the rule of its name and no other; together with those above, all."""
    tested = {f.__name__ for f in BROKEN} | BREAK.keys() | set(SPOIL.values())
    assert tested == RULES.keys()
    bus = await wires(dut)
    for stimulus in BROKEN:
        bus.lword_n.value = bus.iack_n.value = bus.iackin_n.value = bus.iackout_n.value = 1
        await Timer(100, "ns")
        monitor = VmeMonitor(bus, fail=False)
        await Timer(10, "ns")
        await stimulus(bus)
        await Timer(100, "ns")
        assert {name for name, ns, text in monitor.broken} == {stimulus.__name__}, stimulus
        monitor.stop()


@cocotb.test(expect_error=ProtocolError)
async def a_broken_rule_fails_the_test(dut):
    bus = await wires(dut)
    VmeMonitor(bus)
    await Timer(10, "ns")
    await dtack_alone(bus)
    await Timer(10, "ns")
