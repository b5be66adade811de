# SPDX-License-Identifier: Apache-2.0
"""The hardware with Safety2026: PANIC stands until a release, encoders that step illegally or have
a cut wire raise it, heartbeats end after 10 ms and want latches. docs/hardware/safety.md"""

from cocotb_tests.lib.req import test, tests_on
from cocotb_tests.lib.tb import B_DOUBLE, DAC1, HEALTH_CLKS, QUAD, RUN, Machine
from cocotb_tests.system.cocotb_safety import panic
from mmcs import regs

TOPLEVEL = "mmcs"
PARAMETERS = {"NumCards": 1, "RelayUs": 20, "Safety2026": 1}
BEAT_MS = 10
ALONE = 8  # edges of one wire


async def release(tb: Machine) -> None:
    await tb.wr(regs.SAFETY, regs.SAFETY_RELEASE)
    await tb.clocks(HEALTH_CLKS)


async def machine(dut) -> Machine:
    """Both D/As just written, PANIC released."""
    tb = await Machine(dut).start(setup=True)
    dut.axis_enable_i.value = 3
    await tb.us(25)
    await tb.beat()
    await tb.clocks(HEALTH_CLKS)
    assert panic(tb), "power-on is PANIC, and latched"
    await release(tb)
    assert not panic(tb)
    return tb


machine_test = tests_on(machine)


@machine_test("PAN-1", "PAN-3")
async def panic_stands_until_released(dut, tb):
    dut.estop_closed_i.value = 0
    await tb.us(1)
    assert panic(tb)
    await release(tb)
    assert panic(tb), "its cause stands"
    assert await tb.rd(regs.SAFETY) == regs.SAFETY_PANIC_BM | regs.SAFETY_CAUSE_BM
    dut.estop_closed_i.value = 1
    await tb.clocks(4 * HEALTH_CLKS)
    assert panic(tb), "the cause has passed, PANIC has not"
    assert await tb.rd(regs.SAFETY) == regs.SAFETY_PANIC_BM
    for value in range(256):
        if value != regs.SAFETY_RELEASE:
            await tb.wr(regs.SAFETY, value)
            assert panic(tb), f"0x{value:02X} is no release"
    await tb.wr(regs.PCCSR, regs.SAFETY_RELEASE)
    await tb.wr(regs.VECTOR, regs.SAFETY_RELEASE)
    assert panic(tb), "other registers release nothing"
    await release(tb)
    assert not panic(tb)
    assert await tb.rd(regs.SAFETY) == 0


@machine_test("PAN-1", "DRV-9")
async def trip_and_sysreset_are_panic(dut, tb):
    for value in range(256):
        if value != regs.SAFETY_TRIP:
            await tb.wr(regs.SAFETY, value)
            assert not panic(tb), f"0x{value:02X} trips nothing"
    await tb.wr(regs.SAFETY, regs.SAFETY_TRIP)
    await tb.clocks(2)
    assert panic(tb)
    await tb.clocks(4 * HEALTH_CLKS)
    assert panic(tb)
    await release(tb)
    assert not panic(tb)
    dut.vme_sysreset_ni.value = 0
    await tb.us(2)
    dut.vme_sysreset_ni.value = 1
    await tb.us(2)
    assert panic(tb)


@machine_test("HB-1", "PAN-1")
async def heartbeat_of_10_ms(tb):
    for axis in range(2):
        await tb.cwr(0, DAC1 + 2 * axis, 0)
    await tb.us(1000 * BEAT_MS - 100)
    assert not panic(tb)
    await tb.us(200)
    assert panic(tb)
    await tb.beat()
    await tb.clocks(HEALTH_CLKS)
    assert panic(tb), "a heartbeat alone does not end it"


async def counting(dut) -> Machine:
    """The same; the counts are written, so that what the switch to the joint did is forgotten."""
    tb = await machine(dut)
    await tb.cwr(0, 0, QUAD)
    await tb.cwr(0, 1, RUN)
    await tb.us(10)
    for register in (4, 5, 6, 7):
        await tb.cwr(0, register, 0)
    await tb.beat()
    await release(tb)
    assert not panic(tb)
    return tb


@machine_test("HB-1")
async def write_that_no_latch_takes_is_no_heartbeat(tb):
    for double, latches in ((0, False), (1, True), (1, False)):
        await tb.cwr(0, 1, RUN | double * B_DOUBLE)
        for _ in range(2 * BEAT_MS):
            await tb.beat()
            assert not panic(tb)
            if latches:
                await tb.cwr(0, regs.CARD_LATCH, 0)
            await tb.us(490)
        if double and not latches:
            await tb.us(1000)
        else:
            assert not panic(tb)
    assert panic(tb)


@test("ENC-1", "PAN-1")
async def cut_wire_of_an_encoder_is_panic(dut):
    """Of each wire, when the axis turns; not so an axis that swings over one edge once a sample."""
    tb = await counting(dut)
    for wire in (dut.enc_a_i, dut.enc_b_i):
        for _ in range(ALONE):
            wire.value = 3 - int(wire.value)
            await tb.us(3)
            await tb.cwr(0, regs.CARD_LATCH, 0)
            await tb.us(3)
        for n in range(ALONE):
            assert not panic(tb), f"{n} edges since the last latch"
            wire.value = 3 - int(wire.value)
            await tb.us(3)
        assert panic(tb)
        await tb.beat()
        await release(tb)
        assert panic(tb), "nobody knows the count"
        for register in (4, 5, 6, 7):
            await tb.cwr(0, register, 0)
        await release(tb)
        assert not panic(tb)
    for n in range(2 * ALONE):
        wire = dut.enc_a_i if n // (ALONE - 1) % 2 else dut.enc_b_i
        wire.value = 3 - int(wire.value)
        await tb.us(3)
        assert not panic(tb), "the other wire is there"


@test("ENC-1", "PAN-1")
async def illegal_step_of_an_encoder_is_panic(dut):
    tb = await counting(dut)
    for step in (1, 3, 2, 0, 2, 3, 1, 0):  # legal ones, both ways
        dut.enc_a_i.value = step & 1
        dut.enc_b_i.value = step >> 1
        await tb.us(3)
        assert not panic(tb)
    dut.enc_a_i.value = 1
    dut.enc_b_i.value = 1
    await tb.us(3)
    assert panic(tb)
    await tb.beat()
    await release(tb)
    assert panic(tb), "nobody knows the count"
    await tb.preset(0, 0)
    await release(tb)
    assert not panic(tb)


@machine_test("SW-1", "PAN-1")
async def switched_off_axis_has_no_illegal_step(dut, tb):
    dut.axis_enable_i.value = 0
    await tb.cwr(0, 0, QUAD)
    await tb.cwr(0, 1, RUN)
    await tb.us(10)
    dut.enc_a_i.value = 3
    dut.enc_b_i.value = 3
    await tb.us(10)
    await release(tb)
    assert not panic(tb)
