# SPDX-License-Identifier: Apache-2.0
"""Loss of power; each bit of the analog side and of the switches of every card. §5.3.1-5.3.4"""

from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import LATCH_ALL, PORT_A, QUAD, Machine, dip
from cocotb_tests.system.machine import USUAL

TOPLEVEL = "mmcs"
PARAMETERS = USUAL
RELAY_US = USUAL["RelayUs"]
machine_test = tests_on(Machine)


@machine_test("DAC-1", "ANA-1", setup=True)
async def every_bit_of_every_output(tb):
    """A walking one and a walking zero at all D/As."""
    await tb.us(RELAY_US + 2)
    axes = range(2 * tb.cards)
    for bit in range(12):
        for code in (1 << bit, ~(1 << bit) & 0xFFF):
            for axis in axes:
                await tb.dac(axis, code)
            assert [tb.volts(a) for a in axes] == [(code - 0x800) * 16 for _ in axes], f"{code:03X}"


@machine_test("ADC-1", "ANA-1", setup=True)
async def every_bit_of_every_input(tb):
    """A walking one and a walking zero at all A/D inputs."""
    axes = range(2 * tb.cards)
    await tb.us(RELAY_US + 2)
    for bit in range(16):
        for value in (1 << bit, ~(1 << bit) & 0xFFFF):
            signed = value - 0x10000 if value & 0x8000 else value
            tb.inputs([signed for _ in axes])
            await tb.cwr(0, LATCH_ALL, 0)
            await tb.us(27)
            code = min((signed + 32776) >> 4, 4095)
            assert [await tb.adc(a) for a in axes] == [code for _ in axes], f"{value:04X}"


@machine_test("CRD-1", "JMP-1", setup=True)
async def every_wrong_switch_of_every_card(dut, tb):
    """A switch that is set wrong moves the card to another number, and back."""
    for card in range(tb.cards):
        for flip in (4, 8, 12, 15):
            wrong = [n ^ flip if n == card else n for n in range(tb.cards)]
            dut.dip_i.value = dip(*wrong)
            await tb.clocks(3)
            assert await tb.crd(card ^ flip, PORT_A) == QUAD
            assert await tb.crd(card, PORT_A) == 0xFF
        dut.dip_i.value = dip(*range(tb.cards))
        await tb.clocks(3)
        assert await tb.crd(card, PORT_A) == QUAD
