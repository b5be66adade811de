# SPDX-License-Identifier: Apache-2.0
"""The host fronts, each driven by a bus model from elsewhere: registers, errors, our driver."""

import math
import random
import zlib

import cocotb
from cocotb.triggers import FallingEdge, RisingEdge

from cocotb_tests.adaptor.driver import Driver
from cocotb_tests.adaptor.fronts import AXIL, NAMES, PREFIX, VME, Front, Refused
from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import BASE, PCCSR, PIT, PORT_A, QUAD, VECTOR
from cocotb_tests.system.machine import SINGLE
from mmcs import mcdef

TOPLEVEL = dict.fromkeys(NAMES, "bench_hosts") | {"vme": "mmcs"}
SOURCES = ("bench_hosts.sv",)
VARIANTS = dict.fromkeys(NAMES, {"HeartbeatUs": SINGLE["HeartbeatUs"]}) | {"vme": SINGLE}
# Interrupt to last D/A write of the driver's pass over one card, by front (hardware/adaptor.md).
CLOCKS = (327, 314, 314, 314, 314, 314, 314)
INTERVAL_US = 200


async def ready(dut) -> Front:
    tb = await Front(dut).start()
    await tb.wr(PCCSR, BASE)
    await tb.setup(0, 0x03)
    return tb


front_test = tests_on(ready)
bus_test = tests_on(ready, *NAMES[1:])  # VME ends in the bus timer: cocotb_vme.py


@front_test("ADP-1", "VME-5")
async def the_same_registers(tb):
    """Card, PCCSR, timers and holes answer as on VME; the vector can be read."""
    for value in (*(1 << n for n in range(8)), 0x00, 0x55, 0xFF, QUAD):
        await tb.cwr(0, PORT_A, value)
        assert await tb.crd(0, PORT_A) == value
    assert await tb.rd(PCCSR) == BASE
    await tb.wr(PIT + 6, 0x12)  # timer 0: low byte, mode 1
    await tb.wr(PIT, 0x34)
    await tb.wr(VECTOR, 0xC0)
    assert await tb.rd(VECTOR) == (0xFF if tb.front == VME else 0xC0)
    absent = [tb.creg(card, PORT_A) for card in range(1, 16)]
    for hole in (0x411, 0x431, 0x407, *absent, tb.creg(0, 0x1F)):
        assert await tb.rd(hole) == 0xFF, f"{hole:03X}"
        await tb.wr(hole if hole != 0x407 else 0x411, 0x00)
    assert await tb.rd(PCCSR) == BASE


@bus_test("ADP-1", "VME-5")
async def what_is_no_register_ends_in_the_bus_error(tb):
    """Outside the window, between registers, of another width; and the front goes on after it."""
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


GAIN, LEAD, SCALE, LIMIT = 140, -112, 8, 900  # a0, a1, b0, ilim of the driver's law
STEP, STEP_AT, SAMPLES = 60, 3, 40


def model() -> tuple[list[int], list[int]]:
    """Counts at each sample and codes computed there, in plain arithmetic."""
    counts, codes, y, v, out, e1 = [], [], 0, 0, 0, 0
    for k in range(SAMPLES):
        counts.append(y)
        e = (STEP if k >= STEP_AT else 0) - y
        codes.append(law(e, e1))
        y, v, out, e1 = *turn(y, v, out), codes[-1], e
    return counts, codes


def law(e: int, e1: int) -> int:
    return max(-LIMIT, min(LIMIT, int((GAIN * e + LEAD * e1) / SCALE)))


def turn(y: int, v: int, code: int) -> tuple[int, int]:
    """The motor over one interval, in whole counts: at most 20 of them."""
    v = max(-160, min(160, v + code // 16 - v // 8))
    return y + v // 8, v


async def motor(tb) -> None:
    """What stands on joint 1's D/A since an SCLOCK turns it until the next."""
    y = v = 0
    while True:
        await RisingEdge(tb.dut.sclock_o)
        await tb.clocks(4)  # the card's latch, and the D/As behind it
        before, (y, v) = y, turn(y, v, tb.volts(0) // 16)
        await tb.enc[0].move(y - before, 1000)


@tests_on(Front)("ADP-1", "DAC-1", "LAT-1", "INT-1")
async def our_driver_is_the_same_to_the_count(tb):
    """The mc driver on each front, double-buffered: 40 samples as plain arithmetic has them."""
    counts, codes, took, begin = [], [], [], [0.0]

    def on_pass(driver):
        if running:
            counts.append(driver.lib.mc_state_of(driver.mc, 0).encnow)
            codes.append(driver.lib.mc_current(driver.mc, 0))
            took.append(math.ceil((driver.last_drive - begin[0]) / tb.period))

    async def note_interrupts():
        while True:
            await RisingEdge(tb.irq)
            begin[0] = tb.now()

    tasks = [cocotb.start_soon(motor(tb)), cocotb.start_soon(note_interrupts())]
    running = False
    mc = Driver(tb, on_pass)
    client = await mc.open()
    assert client == 0 and mc.lib.mc_joints(mc.mc) == 2, mc.log
    for axis in range(2):
        given = {"which": axis, "mode": mcdef.MD_POS, "a0": GAIN, "a1": LEAD, "b0": SCALE}
        param = mc.ffi.new("struct mc_param *", mcdef.initial() | given | {"ilim": LIMIT})
        assert await mc.ioctl(client, mcdef.MSETPARAM, param) == 0, mc.log
    for request, value in ((mcdef.MSETINTERVAL, INTERVAL_US), (mcdef.MDACMODE, 1)):
        assert await mc.ioctl(client, request, mc.ffi.new("int *", value)) == 0, mc.log
    assert await mc.ioctl(client, mcdef.MENABLE) == 0, mc.log
    running = True
    while len(counts) < STEP_AT:
        await mc.sleep(10)
    assert await mc.write(client, [STEP, 0]) == 8
    while len(counts) < SAMPLES:
        await mc.sleep(INTERVAL_US // 2)
    for task in tasks:
        task.cancel()
    assert (counts, codes) == model()
    assert STEP - 10 < counts[-1] < STEP + 10, "the loop works"
    stats = mc.lib.mc_stats_of(mc.mc)
    assert (stats.missed, stats.overrun, stats.panics, stats.spurious) == (0, 0, 0, 0)
    tb.log.info("interrupt to last D/A write: %d clocks", max(took))
    assert max(took) == CLOCKS[tb.front], f"{max(took)} clocks"


@tests_on(ready, "axil")("ADP-1")
async def reads_and_writes_that_wait_take_turns(dut, tb):
    order = []

    async def ask(what, access):
        await access
        order.append(what)

    tasks = [cocotb.start_soon(ask("read", tb.rd(PCCSR))) for _ in range(6)]
    tasks += [cocotb.start_soon(ask("write", tb.wr(VECTOR, 0x40))) for _ in range(6)]
    for task in tasks:
        await task
    assert all(a != b for a, b in zip(order, order[1:], strict=False)), order


@tests_on(ready, "axil", "wb", "wb-pipelined", "wb-8bit")("ADP-1")
async def masters_that_pause_and_masters_that_give_up(dut, tb):
    """A response that is not taken waits; a Wishbone cycle given up leaves nothing behind."""
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
    else:

        def pin(name):
            return getattr(dut, f"{PREFIX[tb.front]}_{name}")

        cyc, stb = pin("cyc_i"), pin("stb_i")
        for clocks in range(1, 16):
            await FallingEdge(dut.clk_i)
            cyc.value = stb.value = 1
            pin("we_i").value, pin("adr_i").value = 0, tb.place(tb.creg(0, PORT_A))
            await tb.clocks(clocks)
            await FallingEdge(dut.clk_i)
            answered = int(pin("ack_o").value)
            cyc.value = stb.value = 0
            for _ in range(0 if answered else 16):
                await FallingEdge(dut.clk_i)
                assert not int(pin("ack_o").value) and not int(pin("err_o").value)
            await tb.clocks(16)
            assert await tb.rd(PCCSR) == BASE
    assert await tb.crd(0, PORT_A) == QUAD


AS_EVER = {
    "axil": "478f 8bf6 2345 d755 5d19 7b14", "wb": "46d2 de68 6e65 89b0 0a85 cc12",
    "wb-pipelined": "e46c 13c4 714e 32ce e087 9cde", "apb": "dd9b 3166 e088 cef8 3491 6983",
    "wb-8bit": "7090 941d cc69 da20 487a 4c17", "apb-8bit": "2a30 bcfc d7cf ca84 662d 8eee",
}  # fmt: skip
PINS = {
    "s_axil": """awaddr awvalid wdata wstrb wvalid bready araddr arvalid rready
        > awready wready bresp bvalid arready rdata rresp rvalid""",
    "wb": "cyc_i stb_i we_i adr_i sel_i dat_i > dat_o ack_o err_o stall_o",
    "apb": "psel penable pwrite paddr pstrb pwdata > prdata pready pslverr",
}
CLOCKS_EACH, PARTS = 1000, 6


@tests_on(Front, *NAMES[1:])("ADP-1")
async def pins_that_change_at_random_are_answered_as_ever(tb):
    """Every output at each clock, also to masters that keep no rule, by digests of what it was. Who
    means to change it puts in what the failure shows."""
    dut, chance, parts = tb.dut, random.Random(tb.front), []
    prefix = "s_axil" if tb.front == AXIL else PREFIX[tb.front]
    inputs, outputs = ([getattr(dut, f"{prefix}_{name}") for name in half.split()]
                       for half in PINS[prefix].split(">"))  # fmt: skip
    outputs += [dut.sclock_o, dut.irq_o, dut.drive_v_o]
    near = [tb.place(n) for n in (PCCSR, VECTOR, PIT, PIT + 6, tb.creg(0, PORT_A), 0x411, 0xFFF)]

    def value(pin):
        if "ad" in pin._name and len(pin) == 16:
            return chance.choice([*near, *near, near[0] ^ 1 << chance.randrange(16)])
        if len(pin) == 1:
            return chance.random() < 0.7
        return chance.choice([(1 << len(pin)) - 1, 1, chance.randrange(1 << len(pin))])

    for pin in inputs:
        pin.value = 0
    for _ in range(PARTS):
        seen = []
        for _ in range(CLOCKS_EACH):
            await FallingEdge(dut.clk_i)
            seen.append([int(pin.value) for pin in outputs])
            for pin in inputs:
                if chance.random() < 0.15:
                    pin.value = value(pin)
            if chance.random() < 0.05:
                dut.enc_a_i.value, dut.enc_b_i.value = chance.randrange(4), chance.randrange(4)
                dut.estop_closed_i.value = chance.random() < 0.9
        parts.append(f"{zlib.crc32(str(seen).encode()) & 0xFFFF:04x}")
    assert " ".join(parts) == AS_EVER[NAMES[tb.front]]
