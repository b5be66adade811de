# SPDX-License-Identifier: Apache-2.0
"""Jumpers and switches that differ from the usual, matching and not. §4.3.6, §5.4.3"""

from cocotb.triggers import Timer
from cocotbext.vme import VmeInterruptHandler

from cocotb_tests.lib.req import test, tests_on, variants
from cocotb_tests.lib.tb import (
    ARMED,
    B_DOUBLE,
    B_INDEX,
    B_TO_JOINT,
    BASE,
    C_DONE,
    C_INDEX1,
    C_INDEX2,
    LATCH,
    LATCH_ALL,
    PCCSR,
    PORT_A,
    PORT_B,
    PORT_C,
    RUN,
    SCLOCK_IRQ,
    VECTOR,
    Machine,
    dip,
)
from cocotb_tests.system.machine import SHORT

TOPLEVEL = "mmcs"
VARIANTS = {
    # all cards, another base, level and lines, all consistent; A/D and D/A of 10 V; only card 0's
    # software latch reaches its D/As
    "moved": {
        "NumCards": 16,
        "BaseA15A11": "5'b10110",
        "IrqLevel": 3,
        "AckLevel": 3,
        "SclockDrq": 1,
        "CardSclockDrq": "64'h1111111111111111",
        "PanicIrq": 4,
        "CardPanicIrq": "64'h4444444444444444",
        "SoftLatchDac": "16'h0001",
        "AdcSpan10": "32'h00000003",
        "DacSpan10": "32'h00000006",
        "PpiFloatB": "8'hFF",
        **SHORT,
    },
    # J5 and J7 apart, card 1 on other lines than the adaptor; another clock
    "mismatch": {
        "NumCards": 2,
        "ClkHz": 16_000_000,
        "SysClkMHz": 4,
        "IrqLevel": 5,
        "AckLevel": 4,
        "CardSclockDrq": "64'h3333333333333313",
        "CardPanicIrq": "64'h7777777777777757",
        "RandomPowerUp": "1'b1",
        **SHORT,
    },
}
mismatch_test = tests_on(Machine, "mismatch")


class Moved(Machine):
    """The `moved` variant at 0xB000, SCLOCK low; its first two cards at DIP settings 6 and 10."""

    base = 0xB000
    numbers = (6, 10, 0, 1, 2, 3, 4, 5, 7, 8, 9, 11, 12, 13, 14, 15)

    def inputs_idle(self) -> None:
        super().inputs_idle()
        self.dut.dip_i.value = dip(*self.numbers)

    def creg(self, card: int, register: int) -> int:
        return super().creg(self.numbers[card], register)


async def moved(dut) -> Moved:
    tb = await Moved(dut).start(setup=True)
    await tb.wr(0x407, 0x70)
    await tb.us(25)
    return tb


moved_test = tests_on(moved, "moved")


@moved_test("VME-1", "CRD-1")
async def moved_base_and_dip(tb):
    """The window is where the jumpers say; cards answer at their switches and nowhere else."""
    answered = [s for s in range(32) if await tb.vme.answers(s << 11 | 0x409)]
    assert answered == [0b10110]
    for first, others in ((6, 10), (9, 5), (6, 10)):
        tb.dut.dip_i.value = dip(first, *[others] * 15)
        await tb.clocks(2)
        found = {c for c in range(16) if await tb.rd(c << 6 | PORT_A << 1 | 1) != 0xFF}
        assert found == {first, others}


@moved_test("INT-2", "JMP-1")
async def moved_interrupt_level(dut, tb):
    dut.axis_enable_i.value = 0
    await tb.wr(VECTOR, 0x99)
    await tb.wr(PCCSR, ARMED | SCLOCK_IRQ | BASE)
    await tb.wr(0x407, 0x74)
    assert int(dut.vme_irq_no.value) == 0x7F & ~(1 << 2)
    tb.vme.downstream = {5: 0x55}
    assert await tb.vme.iack(3) == 0x99
    assert await tb.vme.iack(5) == 0x55


@moved_test("JMP-1", "LAT-1")
async def moved_sclock_line(dut, tb):
    await tb.wr(0x407, 0x74)
    await Timer(1, "us")
    assert int(dut.pcx_drq_o.value) == 0b001
    assert [await tb.crd(c, PORT_C) & C_DONE for c in range(16)] == [0] * 16


@moved_test("JMP-1", "HB-2", "PAN-1")
async def moved_panic_line(dut, tb):
    await tb.beat()
    await tb.clocks(5)
    assert not int(dut.panic_o.value)
    dut.pcx_irq_i.value = 1 << 4  # IRQ7: not our line any more
    await tb.clocks(5)
    assert not int(dut.panic_o.value)
    dut.pcx_irq_i.value = 1 << 1  # IRQ4
    await tb.clocks(5)
    assert int(dut.panic_o.value)
    dut.pcx_irq_i.value = 0
    await tb.us(420)
    assert int(dut.panic_o.value), "the cards' own"


@moved_test("DAC-1", "LAT-1")
async def software_latch_without_jumper(tb):
    """Card 1 has E023-E021: encoders and A/Ds latch, its D/As wait for SCLOCK."""
    for card in (0, 1):
        await tb.cwr(card, PORT_B, RUN | B_DOUBLE)
    for axis in range(4):
        await tb.dac(axis, 0xA00)
    await tb.cwr(0, LATCH_ALL, 0)
    assert [bool(tb.volts(a)) for a in range(4)] == [True, True, False, False]
    assert not await tb.crd(1, PORT_C) & C_DONE
    await tb.cwr(1, LATCH, 0)
    assert [bool(tb.volts(a)) for a in range(4)] == [True, True, False, False]
    await tb.wr(0x407, 0x74)
    assert all(tb.volts(a) for a in range(4))


@moved_test("DAC-1", "ADC-1", "ANA-1", "DIA-1")
async def ten_volt_spans(tb):
    """D/As 1 and 2, A/Ds 0 and 1 at 10 V: half the volts per code, twice the codes per volt."""
    for axis in range(4):
        await tb.dac(axis, 0xC00)
    assert [tb.volts(a) for a in range(4)] == [0x4000, 0x2000, 0x2000, 0x4000]
    tb.inputs([0x1000, -0x1000, 0x1000, 0x7000])
    await tb.cwr(0, LATCH_ALL, 0)
    await tb.us(26)
    assert [await tb.adc(a) for a in range(4)] == [0xA00, 0x600, 0x900, 0xF00]
    tb.inputs([0x7000, -0x7000, 0, 0])
    await tb.cwr(0, LATCH_ALL, 0)
    await tb.us(26)
    assert [await tb.adc(a) for a in range(2)] == [0xFFF, 0x000], "beyond the range it clamps"
    # looped back: 20 V D/A into 10 V A/D, 10 into 10, 10 into 20, 20 into 20
    for card in (0, 1):
        await tb.cwr(card, PORT_B, RUN & ~B_TO_JOINT)
    for axis in range(4):
        await tb.dac(axis, 0x900)
    await tb.us(25)
    await tb.cwr(0, LATCH_ALL, 0)
    await tb.us(26)
    assert [await tb.adc(a) for a in range(4)] == [0xA00, 0x900, 0x880, 0x900]


@test("PPI-1", "DIA-1")
@variants("moved")
async def floating_port_b_seen_as_ones(dut):
    """PpiFloatB = 0xFF: after RESET the board is driven, until the mode word makes outputs of 0."""
    tb = await Moved(dut).start()
    await tb.dac(0, 0xC00)
    await tb.us(25)
    assert tb.volts(0) == 0, "double-buffered while port B floats high"
    await tb.cwr(0, LATCH, 0)
    assert tb.volts(0) == 0x4000, "the relay is at the joint"
    await tb.cwr(0, 3, 0x89)
    await tb.us(25)
    assert tb.volts(0) == 0


@mismatch_test("INT-2", "VME-6", "JMP-1", setup=True)
async def j5_and_j7_apart(dut, tb):
    """The line is pulled, no acknowledge is ever answered, of J7's level neither: spurious."""
    dut.axis_enable_i.value = 0
    await tb.wr(0x407, 0x70)
    await tb.wr(PCCSR, ARMED | SCLOCK_IRQ | BASE)
    await tb.wr(0x407, 0x74)

    async def never(level, vector):
        raise AssertionError(f"level {level} answered with {vector:02X}")

    handler = VmeInterruptHandler(tb.vme, [5], never)
    await Timer(60, "us")
    assert handler.spurious >= 3
    handler.stop()
    await Timer(20, "us")
    tb.vme.downstream = {4: 0x44, 5: 0x55}
    assert [await tb.vme.iack(level) for level in (4, 5)] == [0x44, 0x55]
    assert await tb.rd(PCCSR) == ARMED | SCLOCK_IRQ | BASE


@mismatch_test("JMP-1", "LAT-1", setup=True)
async def sclock_lines_apart(tb):
    """Card 1 listens on DRQ1: it never latches; a software latch still works."""
    await tb.sclock(8, 10)
    await tb.us(40)
    await tb.wr(0x407, 0x70)
    await tb.preset(0, 10)
    await tb.preset(2, 20)
    await tb.us(30)
    await tb.wr(0x407, 0x74)
    await tb.us(1)
    assert [await tb.crd(c, PORT_C) & C_DONE for c in (0, 1)] == [0, C_DONE]
    await tb.cwr(1, LATCH, 0)
    assert not await tb.crd(1, PORT_C) & C_DONE


@mismatch_test("JMP-1", "HB-2", "PAN-1", setup=True)
async def panic_lines_apart(dut, tb):
    """Card 1 calls on IRQ5: never heard."""
    dut.axis_enable_i.value = 0b1100
    await tb.us(5)
    assert not int(dut.panic_o.value), "card 1 panics unheard"
    dut.axis_enable_i.value = 0b0001
    await tb.us(5)
    assert int(dut.panic_o.value)


@mismatch_test("ANA-1")
async def random_power_up(tb):
    """D/As come up anywhere; the drive is isolated until software has spoken."""
    assert [tb.volts(a) for a in range(4)] == [0] * 4
    await tb.setup(0)
    await tb.us(25)
    assert any(tb.volts(a) for a in (0, 1))
    await tb.dac(0, 0x800)
    await tb.dac(1, 0x800)
    assert [tb.volts(a) for a in (0, 1)] == [0, 0]


@moved_test("CRD-1", "MAP-1", "LAT-1", "ENC-1", "CAL-1")
async def sixteen_cards(tb):
    """32 axes: separate registers, one latch, every counter counts, each has its index."""
    for card in range(16):
        await tb.cwr(card, PORT_A, 5 | card << 3)
    for axis in range(32):
        await tb.preset(axis, 0x100 * axis)
        await tb.enc[axis].move(2, 1000)
    await tb.us(1)
    await tb.wr(0x407, 0x74)
    for e in tb.enc:
        e.step(1)
    await tb.us(1)
    assert [await tb.crd(c, PORT_C) & C_DONE for c in range(16)] == [0] * 16
    for card in range(16):
        assert await tb.crd(card, PORT_A) == 5 | card << 3
    for axis in range(32):
        assert await tb.encoder(axis) == 0x100 * axis + 2, f"axis {axis} latched"
        assert await tb.encoder(axis) == 0x100 * axis + 3, f"axis {axis} live"
    for card in range(16):
        await tb.cwr(card, PORT_B, RUN | B_INDEX)
    for axis in range(32):
        await tb.enc[axis].index(500)
        seen = [await tb.crd(c, PORT_C) & (C_INDEX1 | C_INDEX2) for c in range(16)]
        marks = [C_INDEX1 * (2 * c <= axis) | C_INDEX2 * (2 * c < axis) for c in range(16)]
        assert seen == marks, f"axis {axis} alone has its index"


@moved_test("CRD-1", "DAC-1", "HB-2", "PAN-1")
async def sixteen_cards_drive(dut, tb):
    """Each D/A moves its own output only; the last axis written ends PANIC."""
    volts = [0] * 32
    for sign in (1, -1):
        for axis in range(32):
            assert int(dut.panic_o.value) == (sign > 0)
            await tb.dac(axis, 0x800 + sign * 16 * (axis + 1))
            await tb.clocks(5)
            span = 128 if axis in (1, 2) else 256  # two have one of 10 V
            volts[axis] = sign * span * (axis + 1)
            assert [tb.volts(a) for a in range(32)] == volts
    assert int(dut.panic_o.value) == 0
