# SPDX-License-Identifier: Apache-2.0
"""The board that closes the loop by itself, from encoder pins to the D/A. §5"""

import cocotb
from cocotb.triggers import Timer
from cocotbext.mmcs import Pins
from cocotbext.quadrature import QuadratureSource

from cocotb_tests.lib.tb import Tb
from fpga.board.tests.converters import Dac8568, Mcp3208, SerialHost

BAUD = 1_000_000
MAILBOX, ENABLED, AXIS, AXIS_WORDS, ENCNOW = 0x1E000 // 4, 21, 38, 9, 2  # words: mailbox.h
MAGIC = 0x4D4D4353
ADDRESS, DATA, DO, READ = 0x001, 0x005, 0x00D, 1  # the console
UP_MS = 40  # from reset to the first servo pass, at most
GAIN, LIMIT = 4, 512  # firmware/ports/loop.c
MIDDLE = 0x800


class Board(Tb):
    clk_hz = 24_000_000
    limit_ms = 120

    async def begin(self):
        dut = self.dut
        self.console = SerialHost(dut, BAUD)
        self.adc = Mcp3208(dut, [0x800] * 8)
        self.dac = Dac8568(dut)
        pins = [Pins(handle) for handle in (dut.enc_a, dut.enc_b, dut.enc_i)]
        self.encoder = [QuadratureSource(*pins, joint) for joint in range(2)]
        dut.estop_n.value = dut.enable_n.value = 0
        await self.start()
        return self

    async def word(self, number: int) -> int:
        """A word of the memory, by the console; signed."""
        for n in range(2):
            await self.console.wr(ADDRESS + 2 * n, number >> 8 * n & 0xFF)
        await self.console.wr(DO, READ)
        value = 0
        for n in range(4):
            value |= await self.console.rd(DATA + 2 * n) << 8 * n
        return value - (value >> 31 << 32)

    async def closed(self) -> None:
        """Until the driver has enabled itself; a reset leaves the memory as it was."""
        for _ in range(UP_MS):
            await Timer(1, "ms")
            released = int(self.dut.brake_release.value)
            if released and await self.word(MAILBOX + ENABLED) == 1:
                return
        raise AssertionError(f"not enabled after {UP_MS} ms")

    def codes(self) -> list[int]:
        return [self.dac.value[joint] >> 4 for joint in range(2)]


@cocotb.test()
async def servo_pass_by_itself(dut):
    """Counts of the pins come back as the law's D/A codes; pins, firmware and D/A say the same."""
    tb = await Board(dut).begin()
    await tb.closed()
    assert await tb.word(MAILBOX) == MAGIC
    assert int(dut.brake_release.value) and not int(dut.panic_o.value)
    assert int(dut.beat_o.value) == 3 and tb.codes() == [MIDDLE, MIDDLE]
    for joint, counts in ((0, 10), (1, -25), (0, -30), (1, 400)):
        await tb.encoder[joint].move(counts, 20_000)
        await Timer(3, "ms")
        position = [encoder.count for encoder in tb.encoder]
        told = [await tb.word(MAILBOX + AXIS + AXIS_WORDS * j + ENCNOW) for j in range(2)]
        wanted = [max(-LIMIT, min(LIMIT, -GAIN * p)) for p in position]
        assert told == position and tb.codes() == [MIDDLE + w for w in wanted]


@cocotb.test()
async def the_stop_loop_opens_it(dut):
    """The brakes close at once, and the driver takes itself off."""
    tb = await Board(dut).begin()
    await tb.closed()
    dut.estop_n.value = 1
    await Timer(1, "us")
    assert not int(dut.brake_release.value)
    await Timer(3, "ms")
    assert int(dut.panic_o.value) and await tb.word(MAILBOX + ENABLED) == 0
