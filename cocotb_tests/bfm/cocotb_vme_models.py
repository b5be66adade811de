# SPDX-License-Identifier: Apache-2.0
"""The VME models against each other: widths, spaces, errors, the chain."""

from types import SimpleNamespace

import cocotb
from cocotb.triggers import Timer
from cocotbext.vme import (
    AM_A24_SUPERVISOR,
    AM_A32_SUPERVISOR,
    BusError,
    BusTimeout,
    ProtocolError,
    VmeBus,
    VmeInterrupter,
    VmeInterruptHandler,
    VmeMaster,
    VmeMonitor,
    VmeSlave,
    VmeTiming,
)

from cocotb_tests.bfm.cases import raises, refused, wires

TOPLEVEL = "bench_wires"
SOURCES = ["bench_wires.sv"]


@cocotb.test()
async def every_size_in_every_space(dut):
    """D08(E), D08(O), D16 and D32 by random traffic in A16, A24 and A32; compared with a copy."""
    bus = await wires(dut)
    vme = VmeMaster(bus, skew=30, timing=VmeTiming(ds_skew=10))
    everywhere = (0x2D, AM_A24_SUPERVISOR, AM_A32_SUPERVISOR)
    slave = VmeSlave(bus, base=0xA000, size=256, modifiers=everywhere, delay_ns=(30, 300))
    monitor = VmeMonitor(bus, at="master")
    copy, random, compared = bytearray(256), vme.random, 0
    for _ in range(150):
        size = random.choice((1, 2, 4))
        offset = random.randrange(256 // size) * size
        how = {"size": size, "am": random.choice(everywhere)}
        if random.randrange(2):
            value = random.getrandbits(8 * size)
            await vme.write(0xA000 + offset, value, **how)
            copy[offset : offset + size] = value.to_bytes(size, "big")
        else:
            want = int.from_bytes(copy[offset : offset + size], "big")
            assert await vme.read(0xA000 + offset, **how) == want
            compared += 1
    assert slave.memory == copy and compared > 40
    assert len(monitor.cycles) == vme.count == slave.answered == 150
    assert {c.size for c in monitor.cycles} == {1, 2, 4}
    assert not await vme.answers(0xA000, am=0x29) and not await vme.answers(0xA100)


@cocotb.test()
async def read_modify_write_is_one_address_cycle(dut):
    bus = await wires(dut)
    vme, slave, monitor = VmeMaster(bus), VmeSlave(bus, base=0, size=16), VmeMonitor(bus)
    falls = []

    async def addresses():
        while True:
            await bus.as_n.falling_edge
            falls.append(True)

    cocotb.start_soon(addresses())
    slave.memory[2:4] = b"\x12\x34"
    assert await vme.rmw(2, lambda old: old + 1, size=2) == 0x1234
    assert slave.memory[2:4] == b"\x12\x35" and len(falls) == 1
    assert [(c.kind, c.data) for c in monitor.cycles] == [("read", 0x1234), ("write", 0x1235)]
    # what the function raises, or gives out of range, ends the cycle and is told
    with raises(ValueError, "what modify gives, size 1 is 0 to 255, not 256"):
        await vme.rmw(2, lambda old: 256)
    with raises(ZeroDivisionError):
        await vme.rmw(2, lambda old: 1 // 0)
    assert await vme.read(3) == 0x35


@cocotb.test()
async def errors_and_the_bus_timer(dut):
    """BERR* of a slave, nobody there, hooks, a read that was withdrawn."""
    bus = await wires(dut)
    vme = VmeMaster(bus, timing=VmeTiming(bus_timer=2000))
    written = []
    slave = VmeSlave(bus, base=0x100, size=64, fail=[(8, 9)], on_read=lambda at, size: at,
                     on_write=lambda *what: written.append(what))  # fmt: skip
    monitor = VmeMonitor(bus, allow=("strobe_held",))
    assert await vme.read(0x105) == 5
    await vme.write(0x106, 0xBEEF, size=2)
    assert written == [(6, 2, 0xBEEF)]
    with raises(BusError, "BERR* from the slave"):
        await vme.read(0x108, size=2)
    with raises(BusTimeout, "read 0200 size 1"):
        await vme.read(0x200)
    op = await vme.init_read(0x105, withdraw_ns=60).wait()
    assert op.error is None and not op.answered
    assert await vme.read(0x105) == 5
    assert [c.outcome for c in monitor.cycles] == ["DTACK*", "DTACK*", "BERR*", "none", "none",
                                                   "DTACK*"]  # fmt: skip
    assert (slave.answered, slave.failed, vme.timeouts) == (3, 1, 1)


@cocotb.test()
async def two_on_the_chain(dut):
    """The first passes on what is not its own; of two on one level the nearer goes first."""
    bus = await wires(dut)
    vme = VmeMaster(bus)
    near = VmeInterrupter(bus, 3, 0x33, iackout=dut.chain1_n)
    far = VmeInterrupter(bus, 3, 0x66, iackin=dut.chain1_n, release="register")
    monitor = VmeMonitor(bus)
    far.request()
    near.request()
    assert await vme.iack(3) == 0x33
    assert not int(dut.irq_n.value) & 4, "the other still asks"
    assert await vme.iack(3) == 0x66
    assert not int(dut.irq_n.value) & 4, "until its register is read"
    far.withdraw()
    await Timer(10, "ns")
    assert int(dut.irq_n.value) == 0x7F
    with raises(BusTimeout):
        await vme.iack(3)
    assert (near.acknowledged, far.acknowledged, far.passed) == (1, 1, 1)

    taken = []

    async def on_interrupt(level, vector):
        taken.append(vector)
        if vector == 0x66:
            far.withdraw()

    handler = VmeInterruptHandler(vme, range(1, 8), on_interrupt)
    far.request()
    near.request()
    await Timer(5, "us")
    assert taken == [0x33, 0x66] and handler.spurious == 0
    assert not monitor.broken
    handler.stop()
    far.request()
    far.stop()
    await Timer(10, "ns")
    assert int(dut.irq_n.value) == 0x7F
    assert near.passed == 3
    with raises(BusTimeout):
        await vme.iack(3)
    assert (near.passed, far.passed, far.acknowledged) == (4, 1, 2)


@cocotb.test()
async def the_pins_of_a_master_are_found(dut):
    """What a slave hears, a master drives: the same lines by the names of the other side."""
    pins = {"a_o": dut.a, "am_o": dut.am, "as_no": dut.as_n, "ds_no": dut.ds_n, "d_o": dut.d,
            "d_i": dut.q, "write_no": dut.write_n, "dtack_ni": dut.dtack_n,
            "berr_ni": dut.berr_n, "irq_ni": dut.irq_n, "iack_no": dut.iack_n}  # fmt: skip
    design = SimpleNamespace(_path="cpu", **{f"vme_{name}": pin for name, pin in pins.items()})
    bus, host = VmeBus.from_prefix(design, "vme"), await wires(dut)
    assert (bus.d, bus.q, bus.q_oe, bus.lword_n) == (dut.d, dut.q, None, None)
    slave, cards = VmeSlave(bus, base=0x40, size=8), VmeInterrupter(bus, 2, 0x22)
    vme = VmeMaster(host)
    await vme.write(0x42, 0x5AA5, size=2)
    assert slave.memory[2:4] == b"\x5a\xa5"
    del pins["dtack_ni"]
    with raises(AttributeError, "cpu has no signal vme_dtack_ni"):
        del design.vme_dtack_ni
        VmeBus.from_prefix(design, "vme")
    cards.stop()


@cocotb.test()
async def what_a_slave_breaks_the_master_tells(dut):
    """DTACK* that is low before, that stays low, data after the strobes."""
    bus = await wires(dut)
    vme = VmeMaster(bus)
    bus.dtack_n.value = 0
    await Timer(1, "ns")
    with raises(ProtocolError, "DTACK* is low before any strobe"):
        await vme.read(0x10)
    bus.dtack_n.value = 1
    await Timer(10, "ns")

    async def bad_slave(oe_after: int):
        await bus.ds_n.value_change
        await Timer(50, "ns")
        bus.q_oe.value = 1
        await Timer(20, "ns")
        bus.dtack_n.value = 0
        await bus.ds_n.value_change
        bus.q_oe.value = oe_after

    for oe_after, words in ((1, "data driven after the strobes"), (0, "DTACK* stays low")):
        cocotb.start_soon(bad_slave(oe_after))
        with raises(ProtocolError, words):
            await vme.read(0x10)
        bus.q_oe.value, bus.dtack_n.value = 0, 1
        await Timer(10, "ns")


@cocotb.test()
async def wrong_arguments_end_in_one_sentence(dut):
    bus = await wires(dut)
    vme = VmeMaster(bus)
    bare = await wires(dut, berr_n=None, irq_n=None)
    refused(
        (ValueError, "size is one of 1, 2, 4, not 3", lambda: vme.init_read(0, size=3)),
        (ValueError, "is a multiple of it, not 0x3", lambda: vme.init_read(3, size=2)),
        (ValueError, "under modifier 0x2d is 0 to 0xffff, not 0x10000",
         lambda: vme.init_read(0x10000)),
        (ValueError, "address modifier is 0 to 63, not 64", lambda: vme.init_read(0, am=64)),
        (ValueError, "value of size 1 is 0 to 255, not 256", lambda: vme.init_write(1, 256)),
        (TypeError, "value of size 1 is a whole number, not '1'", lambda: vme.init_write(1, "1")),
        (ValueError, "level is 1 to 7, not 0", lambda: vme.init_iack(0)),
        (TypeError, "a cycle has no option 'sise'", lambda: vme.init_read(1, sise=2)),
        (ValueError, "withdraw_ns is 1 or more", lambda: vme.init_read(1, withdraw_ns=0)),
        (ValueError, "the line to spoil is one of", lambda: vme.init_read(1, spoil=("dtack", 5))),
        (TypeError, "modify is a function", lambda: vme.init_rmw(1, 5)),
        (ValueError, "VmeTiming.setup is 35 or more, not 10: illegal=True",
         lambda: VmeTiming(setup=10)),
        (ValueError, "VmeTiming.ds_skew is 0 to 10, not 11", lambda: VmeTiming(ds_skew=11)),
        (ValueError, "at is one of master, slave", lambda: VmeMonitor(bus, at="card")),
        (ValueError, "a rule to allow is one of", lambda: VmeMonitor(bus, allow=("setup",))),
        (ValueError, "delay_ns is 30 or more, not 5", lambda: VmeSlave(
            bus, base=0, size=2, delay_ns=5)),
        (ValueError, "fail needs the signal berr_n", lambda: VmeSlave(
            bare, base=0, size=2, fail=[(0, 1)])),
        (ValueError, "an interrupter needs the signal irq_n", lambda: VmeInterrupter(
            bare, 3, 1)),
        (TypeError, "VmeBus needs the signal as_n", lambda: VmeBus(
            a=dut.a, am=dut.am, d=dut.d, q=dut.q, ds_n=dut.ds_n, write_n=dut.write_n,
            dtack_n=dut.dtack_n)),
        (AttributeError, "bench_wires has no signal bus_a_i", lambda: VmeBus.from_prefix(
            dut, "bus")),
    )  # fmt: skip
