# SPDX-License-Identifier: Apache-2.0
"""Loss of power, and each bit of the faults and inputs of every card. §5.3.1, §5.3.3, §5.3.4"""

import cocotb

from cocotb_tests.lib.req import req
from cocotb_tests.lib.tb import LATCH_ALL, PORT_A, QUAD, Machine
from cocotb_tests.system.machine import USUAL

TOPLEVEL = "mmcs"
PARAMETERS = USUAL
RELAY_US = USUAL["RelayUs"]


@cocotb.test()
@req("PAN-2", "ANA-1")
async def power_loss_forgets_the_converters(dut):
    """After power comes back, and the ports are set anew, the D/As stand at 0 V."""
    tb = Machine(dut)
    await tb.start(setup=True)
    axes = range(2 * tb.cards)
    for axis in axes:
        await tb.dac(axis, 0xA00 + axis)
    await tb.us(RELAY_US + 2)
    assert [tb.volts(a) for a in axes] == [(0x200 + a) * 16 for a in axes]
    dut.pc_power_i.value = 0
    await tb.us(10)
    assert [tb.volts(a) for a in axes] == [0 for _ in axes]
    dut.pc_power_i.value = 1
    await tb.us(60)
    for card in range(tb.cards):
        await tb.setup(card)
    await tb.us(RELAY_US + 2)
    assert [tb.volts(a) for a in axes] == [0 for _ in axes]


@cocotb.test()
@req("DAC-1", "ANA-1")
async def every_stuck_bit_of_every_converter(dut):
    """Each bit of each D/A stuck at 1 and at 0, one after the other."""
    tb = Machine(dut)
    await tb.start(setup=True)
    await tb.us(RELAY_US + 2)
    axes = range(2 * tb.cards)
    for pin, code in ((dut.dac_stuck1_i, 0x000), (dut.dac_stuck0_i, 0xFFF)):
        for axis in axes:
            await tb.dac(axis, code)
        for bit in range(12):
            pin.value = sum(1 << bit + 12 * a for a in axes)
            await tb.clocks(3)
            want = ((code ^ 1 << bit) - 0x800) * 16
            assert [tb.volts(a) for a in axes] == [want for _ in axes], f"bit {bit}"
        pin.value = 0


@cocotb.test()
@req("PAN-1", "SW-1")
async def every_axis_switch_by_itself(dut):
    """No heart beats: PANIC stands while any one axis is switched on."""
    tb = Machine(dut)
    await tb.start(setup=True)
    for _ in range(2):
        for switches in [0] + [n for a in range(2 * tb.cards) for n in (1 << a, 0)]:
            dut.axis_enable_i.value = switches
            await tb.clocks(6)
            assert int(dut.panic_o.value) == int(switches != 0), f"switches {switches:06b}"


@cocotb.test()
@req("DAC-1", "ANA-1")
async def stuck_bits_one_after_the_other(dut):
    """Each joins those that are stuck already, at 1 and at 0, until all are."""
    tb = Machine(dut)
    await tb.start(setup=True)
    await tb.us(RELAY_US + 2)
    axes = range(2 * tb.cards)
    for pin, code in ((dut.dac_stuck1_i, 0x000), (dut.dac_stuck0_i, 0xFFF)):
        for axis in axes:
            await tb.dac(axis, code)
        stuck = 0
        for bit in tb.random.sample(range(12 * len(axes)), 12 * len(axes)):
            stuck |= 1 << bit
            pin.value = stuck
            await tb.clocks(3)
            axis = bit // 12
            want = ((code ^ (stuck >> 12 * axis & 0xFFF)) - 0x800) * 16
            assert tb.volts(axis) == want, f"bit {bit}"
        pin.value = 0


@cocotb.test()
@req("ADC-1", "ANA-1")
async def converters_stick_one_after_the_other(dut):
    """Each joins those that keep their code already, in both directions, and is let go again."""
    tb = Machine(dut)
    await tb.start(setup=True)
    await tb.us(RELAY_US + 2)
    axes = range(2 * tb.cards)
    codes, stuck, value = [0x800] * len(axes), 0, 0
    for bit in [0, *axes, *axes, *reversed(axes)]:
        value = (value + 0x1230) & 0x7FFF
        tb.inputs([value for _ in axes])
        await tb.cwr(0, LATCH_ALL, 0)
        await tb.us(27)
        codes = [c if stuck >> a & 1 else (value + 32776) >> 4 for a, c in enumerate(codes)]
        assert [await tb.adc(a) for a in axes] == codes, f"{stuck:06b}"
        stuck ^= 1 << bit
        dut.adc_stuck_i.value = stuck
        await tb.clocks(3)


@cocotb.test()
@req("ADC-1", "ANA-1")
async def every_bit_of_every_input(dut):
    """A walking one and a walking zero at all A/D inputs; the stuck converter keeps its code."""
    tb = Machine(dut)
    await tb.start(setup=True)
    axes = range(2 * tb.cards)
    await tb.us(RELAY_US + 2)
    last = None
    for bit in range(16):
        for value in (1 << bit, ~(1 << bit) & 0xFFFF):
            signed = value - 0x10000 if value & 0x8000 else value
            tb.inputs([signed for _ in axes])
            stuck = last is not None and bit == 9
            dut.adc_stuck_i.value = (1 << 2 * tb.cards) - 1 if stuck else 0
            await tb.clocks(3)
            await tb.cwr(0, LATCH_ALL, 0)
            await tb.us(27)
            code = min((signed + 32776) >> 4, 4095)
            last = last if stuck else code
            assert [await tb.adc(a) for a in axes] == [last for _ in axes], f"{value:04X}"


@cocotb.test()
@req("CRD-1", "JMP-1")
async def every_wrong_switch_of_every_card(dut):
    """A switch that is set wrong moves the card to another number, and back."""
    tb = Machine(dut)
    await tb.start(setup=True)
    for card in range(tb.cards):
        for flip in (4, 8, 12, 15):
            dut.dip_xor_i.value = flip << 4 * card
            await tb.clocks(3)
            assert await tb.crd(card ^ flip, PORT_A) == QUAD
            assert await tb.crd(card, PORT_A) == 0xFF
        dut.dip_xor_i.value = 0
        dut.card_absent_i.value = 1 << card
        await tb.clocks(3)
        assert await tb.crd(card, PORT_A) == 0xFF
        dut.card_absent_i.value = 0
        await tb.clocks(3)
        assert await tb.crd(card, PORT_A) == QUAD
