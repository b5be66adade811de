# SPDX-License-Identifier: Apache-2.0
"""The card on a board: a serial line for a host, converters on SPI, pins for all else. §5"""

import cocotb
from cocotb.triggers import Timer, ValueChange
from cocotbext.mmcs import Pins
from cocotbext.quadrature import QuadratureSource

from cocotb_tests.lib.tb import (
    ADC_HI,
    ADC_LO,
    BASE,
    LATCH,
    PCCSR,
    PORT_A,
    PORT_B,
    PPI_CONTROL,
    PPI_SETUP,
    QUAD,
    Machine,
    Tb,
)
from fpga.board.tests.converters import Dac8568, Mcp3208, SerialHost, crc8

CLK_HZ, BAUD = 24_000_000, 1_000_000
CARD = [Machine.creg(0, n) for n in range(32)]
FORGET_US = 1100
SLOTS_US = 140  # two joints, twice


class Board(Tb):
    async def begin(self):
        self.clk_hz = CLK_HZ
        self.period = round(1e12 / CLK_HZ / 2) * 2
        dut = self.dut
        self.pc = SerialHost(dut, BAUD)
        self.adc = Mcp3208(dut, [0x800] * 8)
        self.dac = Dac8568(dut)
        self.encoder = QuadratureSource(*map(Pins, (dut.enc_a, dut.enc_b, dut.enc_i)), 0)
        dut.estop_n.value = dut.enable_n.value = 0
        dut.ftdi_txd.value = 0  # during the reset: half a request
        await self.start()
        dut.ftdi_txd.value = 1
        await self.us(FORGET_US)
        await self.pc.wr(PCCSR, BASE)
        for register, value in ((PPI_CONTROL, PPI_SETUP), (PORT_A, QUAD), (PORT_B, 0x03)):
            await self.pc.wr(CARD[register], value)
        return self


@cocotb.test()
async def registers_over_the_serial_line(dut):
    tb = await Board(dut).begin()
    for value in (0x00, 0x55, 0xFF, QUAD):
        await tb.pc.wr(CARD[PORT_A], value)
        assert await tb.pc.rd(CARD[PORT_A]) == value
    assert await tb.pc.rd(PCCSR) == BASE
    assert await tb.pc.rd(0x411) == 0xFF


@cocotb.test()
async def a_disturbed_line(dut):
    """Wrong bits, cut requests and glitches for start bits reach no register and get no answer."""
    tb = await Board(dut).begin()
    await tb.pc.wr(CARD[PORT_A], 0x15)
    good = (0x80 | CARD[PORT_A] >> 8, CARD[PORT_A] & 0xFF, 0x2A)
    good = (*good, crc8(bytes(good)))
    for bit in range(32):
        bad = list(good)
        bad[bit // 8] ^= 1 << bit % 8
        await tb.pc.send(*bad)
        for _ in range(25):
            await tb.us(1)
            assert int(dut.ftdi_rxd.value), f"an answer to a request with bit {bit} wrong"
    for length in (1, 2, 3):
        await tb.pc.send(*good[:length])
        await tb.us(FORGET_US)
        assert await tb.pc.rd(CARD[PORT_A]) == 0x15
    dut.ftdi_txd.value = 0  # less than half a bit
    await Timer(400, "ns")
    dut.ftdi_txd.value = 1
    await tb.us(2)
    assert await tb.pc.rd(CARD[PORT_A]) == 0x15
    await tb.pc.send(*good)
    await tb.us(30)
    assert await tb.pc.rd(CARD[PORT_A]) == 0x2A


@cocotb.test()
async def converters_and_encoder(dut):
    """Codes out of the D/A and into the A/D, as they are on the SPI; counts of the pins."""
    tb = await Board(dut).begin()
    assert tb.dac.reference
    await tb.us(1200)  # the relay
    for joint, code in ((0, 0x000), (1, 0xFFF), (0, 0x9A5), (1, 0x800)):
        await tb.pc.wr(CARD[8 + 2 * joint], code & 0xFF)
        await tb.pc.wr(CARD[9 + 2 * joint], code >> 8)
        await tb.us(SLOTS_US)
        assert tb.dac.value[joint] == code << 4, f"{joint} {tb.dac.value[joint]:04X}"
    for codes in ((0x123, 0xEDC), (0xFFF, 0x000), (0x800, 0x801)):
        tb.adc.codes[:2] = codes
        await tb.us(SLOTS_US)
        await tb.pc.rd(CARD[LATCH])
        await tb.us(40)
        high = await tb.pc.rd(CARD[ADC_HI])
        for joint, code in enumerate(codes):
            low = await tb.pc.rd(CARD[ADC_LO + joint])
            assert (high >> 4 * joint & 15) << 8 | low == code
    assert set(tb.adc.reads) == {0, 1}
    await tb.encoder.move(300, 500)
    await tb.pc.rd(CARD[LATCH])
    high = await tb.pc.rd(CARD[4])
    assert high << 8 | await tb.pc.rd(CARD[5]) == 300


@cocotb.test()
async def the_stop_loop(dut):
    """An open loop is PANIC and brakes; closed, with both D/As written, they are released."""
    tb = await Board(dut).begin()
    assert int(dut.panic_o.value) and not int(dut.brake_release.value)
    for register in (8, 9, 10, 11):
        await tb.pc.wr(CARD[register], 0x08 if register % 2 else 0)
    await tb.us(5)
    assert not int(dut.panic_o.value) and int(dut.brake_release.value)
    assert int(dut.beat_o.value) == 3
    dut.estop_n.value = 1
    await tb.us(5)
    assert int(dut.panic_o.value) and not int(dut.brake_release.value)


@cocotb.test()
async def a_reset_takes_the_torque_away(dut):
    """At once, both joints, and they stay at zero; PANIC does not: no path leads there."""
    tb = await Board(dut).begin()
    await tb.us(1200)  # the relay
    assert tb.dac.value == {0: 0x8000, 1: 0x8000}, "by the reset of the beginning"
    for joint, code in ((0, 0x123), (1, 0xEDC)):
        await tb.pc.wr(CARD[8 + 2 * joint], code & 0xFF)
        await tb.pc.wr(CARD[9 + 2 * joint], code >> 8)
    await tb.us(SLOTS_US)
    torque = {0: 0x1230, 1: 0xEDC0}
    assert tb.dac.value == torque
    dut.estop_n.value = 1
    await tb.us(SLOTS_US)
    assert int(dut.panic_o.value) and tb.dac.value == torque
    dut.rst_ni.value = 0
    await tb.us(1)
    assert tb.dac.value == {0: 0x8000, 1: 0x8000}
    await tb.us(2 * SLOTS_US)
    assert tb.dac.value == {0: 0x8000, 1: 0x8000}
    dut.rst_ni.value = 1
    for _ in range(20):
        await tb.us(SLOTS_US / 10)
        assert tb.dac.value == {0: 0x8000, 1: 0x8000}


@cocotb.test()
async def the_board_is_alive(dut):
    tb = await Board(dut).begin()
    await ValueChange(dut.alive)
    before = tb.now()
    await ValueChange(dut.alive)
    assert round((tb.now() - before) / 1e6) == 500
