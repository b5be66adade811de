# SPDX-License-Identifier: Apache-2.0
"""Every rule of the VME monitor is broken once, and no other with it; good traffic breaks none."""

import cocotb
from cocotb.triggers import Timer
from cocotbext.vme import ProtocolError, VmeMaster, VmeMonitor, VmeSlave, VmeTiming
from cocotbext.vme.monitor import RULES

from cocotb_tests.bfm.cases import wires
from cocotb_tests.lib.play import drive

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


# The master's half of a cycle, up to its strobe; the answer; the end of both.
BEGIN = "a=0x10 am=0x2D write_n={} 50 as_n=0 ds_n=0 50"
READ, WRITE = BEGIN.format(1), BEGIN.format(0)
DATA, DTACK = "q_oe=1 10", "dtack_n=0 20"
END = "ds_n=3 as_n=1 20 q_oe=0 5 dtack_n=1 berr_n=1 60"
BROKEN = {
    "dtack_alone": "dtack_n=0 50 dtack_n=1",
    "next_strobe": f"{WRITE} {DTACK} ds_n=3 as_n=1 60 as_n=0 ds_n=0 60 {END}",
    "ds_to_dtack": f"a=0x10 write_n=0 50 as_n=0 ds_n=0 20 {DTACK} {END}",
    "one_answer": f"{WRITE} {DTACK} berr_n=0 20 {END}",
    "dtack_early": f"{WRITE} {DTACK} dtack_n=1 20 {END}",
    "data_first": f"{READ} {DTACK} {END}",
    "data_stands": f"{READ} {DATA} {DTACK} q=0x1234 20 {END}",
    "drive_on_write": f"{WRITE} q_oe=1 20 {DTACK} {END}",
    "drive_idle": "q_oe=1 20 q_oe=0",
    "drivers_off": f"{READ} {DATA} {DTACK} ds_n=3 as_n=1 10 dtack_n=1 10 q_oe=0",
    "one_fate":
        f"iack_n=0 {READ} iackin_n=0 20 iackout_n=0 q_oe=1 20 {DTACK} iackin_n=1 iackout_n=1 {END}",
    "iackout_alone": "iackout_n=0 20 iackout_n=1",
    "chain_in_cycle": "iackin_n=0 20 iackin_n=1",
    "as_to_ds": "ds_n=0 200 ds_n=3",
    "strobe_held": f"{READ} {END}",
}  # fmt: skip


@cocotb.test()
async def every_other_rule_is_seen(dut):
    """Each stimulus breaks the rule of its name and no other; together with those above, all."""
    assert BROKEN.keys() | BREAK.keys() | set(SPOIL.values()) == RULES.keys()
    bus = await wires(dut)
    for rule, stimulus in BROKEN.items():
        bus.lword_n.value = bus.iack_n.value = bus.iackin_n.value = bus.iackout_n.value = 1
        await Timer(100, "ns")
        monitor = VmeMonitor(bus, fail=False)
        await Timer(10, "ns")
        await drive(bus, stimulus)
        await Timer(100, "ns")
        assert {name for name, ns, text in monitor.broken} == {rule}
        monitor.stop()


@cocotb.test(expect_error=ProtocolError)
async def a_broken_rule_fails_the_test(dut):
    bus = await wires(dut)
    VmeMonitor(bus)
    await Timer(10, "ns")
    await drive(bus, BROKEN["dtack_alone"])
    await Timer(10, "ns")
