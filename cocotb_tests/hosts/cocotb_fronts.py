# SPDX-License-Identifier: Apache-2.0
"""The host fronts, each driven by a bus model from elsewhere: registers, errors, a closed loop."""

import functools
import math

import cocotb
from cocotb.triggers import FallingEdge, RisingEdge

from cocotb_tests.hosts.fronts import AXIL, NAMES, PREFIX, VME, Front, Refused, clocks
from cocotb_tests.lib.req import req
from cocotb_tests.lib.tb import (
    ARMED,
    BASE,
    DAC1,
    ENC1,
    PCCSR,
    PIT,
    PORT_A,
    PORT_B,
    PPI_CONTROL,
    PPI_SETUP,
    QUAD,
    SCLOCK_IRQ,
    VECTOR,
    Machine,
    Tb,
)

TOPLEVEL = "bench_hosts"
SOURCES = ("bench_hosts.sv",)
VARIANTS = {"vme": {"HostPort": 0}, "hosts": {"HostPort": 1}}
CARD = [Machine.creg(0, n) for n in range(32)]
CLOCKS = (
    76,
    68,
    68,
    68,
    68,
    68,
    68,
)  # interrupt to last D/A write, by front (hardware/adaptor.md)
INTERVAL_US = 200  # the slowest master here needs some 60 us for a pass


def each_front(test):
    """Runs the test on one front after the other, from reset each time."""

    @functools.wraps(test)
    async def all_of_them(dut):
        clocks.clear()
        for front in fronts(dut):
            await test(dut, front)

    del all_of_them.__wrapped__  # cocotb would look for the front among its own parameters
    return all_of_them


def fronts(dut) -> list[int]:
    return list(range(1, 7)) if Tb(dut).parameters["HostPort"] else [VME]


async def ready(dut, front: int) -> Front:
    tb = Front(dut, front)
    await tb.start()
    await tb.wr(PCCSR, BASE)
    for register, value in ((PPI_CONTROL, PPI_SETUP), (PORT_A, QUAD), (PORT_B, 0x03)):
        await tb.wr(CARD[register], value)
    return tb


@cocotb.test()
@each_front
@req("ADP-1", "VME-5")
async def the_same_registers(dut, front):
    """Card, PCCSR, timers and holes answer as on VME; the vector can be read."""
    tb = await ready(dut, front)
    for value in (0x01, 0x80, 0x55, 0xFF, QUAD):
        await tb.wr(CARD[PORT_A], value)
        assert await tb.rd(CARD[PORT_A]) == value
    assert await tb.rd(PCCSR) == BASE
    await tb.wr(PIT + 6, 0x12)  # timer 0: low byte, mode 1
    await tb.wr(PIT, 0x34)
    await tb.wr(VECTOR, 0xC0)
    assert await tb.rd(VECTOR) == (0xFF if tb.front == VME else 0xC0)
    for hole in (0x411, 0x431, 0x407, Machine.creg(1, PORT_A), CARD[0x1F]):
        assert await tb.rd(hole) == 0xFF, f"{hole:03X}"
        await tb.wr(hole if hole != 0x407 else 0x411, 0x00)
    assert await tb.rd(PCCSR) == BASE


@cocotb.test()
@each_front
@req("ADP-1", "VME-5")
async def what_is_no_register_ends_in_the_bus_error(dut, front):
    """Outside the window, between registers, of another width; and the front goes on after it."""
    tb = await ready(dut, front)
    if tb.front == VME:
        return  # the bus timer's affair: cocotb_vme.py
    size = 1 << (11 if tb.width == 8 else 12)
    bad = [(size + tb.place(PCCSR), None, None), (0x8000 + tb.place(PCCSR), 0xFF, None)]
    bad += [(tb.place(PCCSR) - 1, None, None)] if tb.width == 8 else []
    if tb.width == 32:
        bad += [(tb.place(PCCSR), 0xFFFFFFFF, lanes) for lanes in (2, 4, 8, 3, 6, 12, 7, 14)]
    for address, value, lanes in bad:
        refused = ""
        try:
            await tb.raw(address, value, lanes)
        except Refused as error:
            refused = str(error) or "error"
        assert refused, f"{address:04X} {value} {lanes} was accepted"
        if tb.front == AXIL:
            assert refused == ("DECERR" if address >= size else "SLVERR")
        assert await tb.rd(PCCSR) == BASE, "nothing was written, and the front goes on"
    if tb.width == 32:
        await tb.raw(tb.place(VECTOR), 0x5A, 1)  # the lowest byte alone
        assert await tb.rd(VECTOR) == 0x5A


def model(samples: int) -> tuple[list[int], list[int]]:
    """Counts at each sample and codes computed there, in plain arithmetic."""
    counts, codes, y, v, out, e1 = [], [], 0, 0, 0, 0
    for k in range(samples):
        counts.append(y)
        code = law((60 if k >= 3 else 0) - y, e1)
        e1 = (60 if k >= 3 else 0) - y
        codes.append(code)
        y, v, out = *turn(y, v, out), code
    return counts, codes


def law(e: int, e1: int) -> int:
    return max(-900, min(900, (140 * e - 112 * e1) // 8))


def turn(y: int, v: int, code: int) -> tuple[int, int]:
    """The motor over one interval, in whole counts: at most 20 of them."""
    v = max(-160, min(160, v + code // 16 - v // 8))
    return y + v // 8, v


@cocotb.test()
@each_front
@req("ADP-1", "DAC-1", "LAT-1", "INT-1")
async def a_double_buffered_loop_is_the_same_to_the_count(dut, front):
    """Interrupt, PCCSR, latched counter, law, D/A: 40 samples as plain arithmetic has them."""
    tb = await ready(dut, front)
    await tb.us(30)  # the relay
    for register in (ENC1, ENC1 + 1):
        await tb.wr(CARD[register], 0)
    await tb.wr(CARD[PORT_B], 0x0F)  # joints, latched by SCLOCK, D/As double-buffered
    await write_code(tb, 0)
    for offset, value in ((PIT + 6, 0x34), (PIT, 8), (PIT, 0), (PIT + 6, 0x74),
                          (PIT + 2, INTERVAL_US & 0xFF), (PIT + 2, INTERVAL_US >> 8)):  # fmt: skip
        await tb.wr(offset, value)
    await tb.wr(PCCSR, ARMED | SCLOCK_IRQ | BASE)
    counts, codes, took = [], [], []
    y, v, e1 = 0, 0, 0
    for k in range(40):
        if not int(dut.irq_o.value):
            await RisingEdge(dut.irq_o)
        begin = tb.now()
        assert await tb.rd(PCCSR) & SCLOCK_IRQ
        await tb.wr(PCCSR, SCLOCK_IRQ | BASE)
        await tb.wr(PCCSR, ARMED | SCLOCK_IRQ | BASE)
        drive = int(dut.drive_v_o.value) & 0xFFFF
        high = await tb.rd(CARD[ENC1])
        count = high << 8 | await tb.rd(CARD[ENC1 + 1])
        counts.append(count - 0x10000 if count & 0x8000 else count)
        e = (60 if k >= 3 else 0) - counts[-1]
        codes.append(law(e, e1))
        e1 = e
        await write_code(tb, codes[-1])
        took.append(math.ceil((tb.now() - begin) / tb.period))
        # what stood on the D/A since this SCLOCK turns the motor until the next
        code = (drive - 0x10000 if drive & 0x8000 else drive) // 16
        before, (y, v) = y, turn(y, v, code)
        await tb.enc[0].move(y - before, 1000)
    assert (counts, codes) == model(40)
    assert counts[-1] in range(50, 70), "the loop works"
    dut._log.info("%s: interrupt to last D/A write %d clocks", NAMES[front], max(took))
    assert max(took) <= CLOCKS[front], f"{NAMES[front]}: {max(took)} clocks"


async def write_code(tb, code: int) -> None:
    await tb.wr(CARD[DAC1], (2048 + code) & 0xFF)
    await tb.wr(CARD[DAC1 + 1], 2048 + code >> 8)


@cocotb.test()
@each_front
@req("ADP-1")
async def masters_that_pause_and_masters_that_give_up(dut, front):
    """A response that is not taken waits; a Wishbone cycle given up leaves nothing behind."""
    tb = await ready(dut, front)
    if tb.front == AXIL:
        for pause in (0, 1, 7):
            dut.s_axil_rready.value = 0
            tb.axil.read_if.r_channel.pause = True
            task = cocotb.start_soon(tb.rd(PCCSR))
            await RisingEdge(dut.s_axil_rvalid)
            await tb.clocks(1 + pause)
            assert int(dut.s_axil_rvalid.value) and int(dut.s_axil_rdata.value) == BASE
            tb.axil.read_if.r_channel.pause = False
            assert await task == BASE
    elif PREFIX.get(front, "").startswith("wb"):

        def pin(name):
            return getattr(dut, f"{PREFIX[front]}_{name}")

        cyc, stb = pin("cyc_i"), pin("stb_i")
        for clocks in range(1, 16):
            await FallingEdge(dut.clk_i)
            cyc.value = stb.value = 1
            pin("we_i").value, pin("adr_i").value = 0, tb.place(CARD[PORT_A])
            await tb.clocks(clocks)
            await FallingEdge(dut.clk_i)
            answered = int(pin("ack_o").value)
            cyc.value = stb.value = 0
            for _ in range(0 if answered else 16):
                await FallingEdge(dut.clk_i)
                assert not int(pin("ack_o").value) and not int(pin("err_o").value)
            await tb.clocks(16)
            assert await tb.rd(PCCSR) == BASE
    assert await tb.rd(CARD[PORT_A]) == QUAD
