# SPDX-License-Identifier: Apache-2.0
"""The card on a board: a serial line for a host, converters on SPI, pins for all else. §5"""

import cocotb
from cocotb.triggers import Timer, ValueChange
from cocotbext.mmcs import Pins
from cocotbext.quadrature import QuadratureSource

from cocotb_tests.lib.tb import BASE, LATCH, PCCSR, PORT_A, QUAD, Host
from fpga.board.tests.converters import Dac8568, Mcp3208, SerialHost, crc8

BAUD = 1_000_000
FORGET_US = 1100
SLOTS_US = 140  # two joints, twice


class Board(Host):
    clk_hz = 24_000_000

    async def begin(self):
        dut = self.dut
        self.pc = SerialHost(dut, BAUD)
        self.rd, self.wr = self.pc.rd, self.pc.wr
        self.mcp3208 = Mcp3208(dut, [0x800] * 8)
        self.dac8568 = Dac8568(dut)
        self.enc = QuadratureSource(*map(Pins, (dut.enc_a, dut.enc_b, dut.enc_i)), 0)
        dut.estop_n.value = dut.enable_n.value = 0
        dut.ftdi_txd.value = 0  # during the reset: half a request
        await self.start()
        dut.ftdi_txd.value = 1
        await self.us(FORGET_US)
        await self.wr(PCCSR, BASE)
        await self.setup(0, 0x03)
        return self


@cocotb.test()
async def registers_over_the_serial_line(dut):
    tb = await Board(dut).begin()
    for value in (0x00, 0x55, 0xFF, QUAD):
        await tb.cwr(0, PORT_A, value)
        assert await tb.crd(0, PORT_A) == value
    assert await tb.rd(PCCSR) == BASE
    assert await tb.rd(0x411) == 0xFF


@cocotb.test()
async def a_disturbed_line(dut):
    """Wrong bits, cut requests and glitches for start bits reach no register and get no answer."""
    tb = await Board(dut).begin()
    await tb.cwr(0, PORT_A, 0x15)
    port = tb.creg(0, PORT_A)
    good = (0x80 | port >> 8, port & 0xFF, 0x2A)
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
        assert await tb.crd(0, PORT_A) == 0x15
    dut.ftdi_txd.value = 0  # less than half a bit
    await Timer(400, "ns")
    dut.ftdi_txd.value = 1
    await tb.us(2)
    assert await tb.crd(0, PORT_A) == 0x15
    await tb.pc.send(*good)
    await tb.us(30)
    assert await tb.crd(0, PORT_A) == 0x2A


@cocotb.test()
async def converters_and_encoder(dut):
    """Codes out of the D/A and into the A/D, as they are on the SPI; counts of the pins."""
    tb = await Board(dut).begin()
    assert tb.dac8568.reference
    await tb.us(1200)  # the relay
    for joint, code in ((0, 0x000), (1, 0xFFF), (0, 0x9A5), (1, 0x800)):
        await tb.dac(joint, code)
        await tb.us(SLOTS_US)
        assert tb.dac8568.value[joint] == code << 4, f"{joint} {tb.dac8568.value[joint]:04X}"
    for codes in ((0x123, 0xEDC), (0xFFF, 0x000), (0x800, 0x801)):
        tb.mcp3208.codes[:2] = codes
        await tb.us(SLOTS_US)
        await tb.crd(0, LATCH)
        await tb.us(40)
        assert tuple([await tb.adc(joint) for joint in (0, 1)]) == codes
    assert set(tb.mcp3208.reads) == {0, 1}
    await tb.enc.move(300, 500)
    await tb.crd(0, LATCH)
    assert await tb.encoder(0) == 300


@cocotb.test()
async def the_stop_loop(dut):
    """An open loop is PANIC and brakes; closed, with both D/As written, they are released."""
    tb = await Board(dut).begin()
    assert int(dut.panic_o.value) and not int(dut.brake_release.value)
    for joint in (0, 1):
        await tb.dac(joint, 0x800)
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
    assert tb.dac8568.value == {0: 0x8000, 1: 0x8000}, "by the reset of the beginning"
    for joint, code in ((0, 0x123), (1, 0xEDC)):
        await tb.dac(joint, code)
    await tb.us(SLOTS_US)
    torque = {0: 0x1230, 1: 0xEDC0}
    assert tb.dac8568.value == torque
    dut.estop_n.value = 1
    await tb.us(SLOTS_US)
    assert int(dut.panic_o.value) and tb.dac8568.value == torque
    dut.rst_ni.value = 0
    await tb.us(1)
    assert tb.dac8568.value == {0: 0x8000, 1: 0x8000}
    await tb.us(2 * SLOTS_US)
    assert tb.dac8568.value == {0: 0x8000, 1: 0x8000}
    dut.rst_ni.value = 1
    for _ in range(20):
        await tb.us(SLOTS_US / 10)
        assert tb.dac8568.value == {0: 0x8000, 1: 0x8000}


@cocotb.test()
async def the_board_is_alive(dut):
    tb = await Board(dut).begin()
    await ValueChange(dut.alive)
    before = tb.now()
    await ValueChange(dut.alive)
    assert round((tb.now() - before) / 1e6) == 500
