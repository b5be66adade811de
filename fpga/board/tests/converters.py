# SPDX-License-Identifier: Apache-2.0
"""The chips beside the FPGA on a board, from their data sheets: MCP3208, DAC8568, and the PC."""

import cocotb
from cocotb.triggers import FallingEdge, RisingEdge, Timer


class Mcp3208:
    """An A/D of eight channels: start, single-ended, three bits of channel; null bit, 12 bits."""

    def __init__(self, dut, codes):
        self.dut, self.codes, self.reads = dut, codes, []
        dut.adc_dout.value = 0
        self._task = cocotb.start_soon(self._run())

    async def _run(self):
        dut = self.dut
        while True:
            await FallingEdge(dut.adc_cs_n)
            head = []
            while len(head) < 5:  # the start bit is the first 1; DIN is taken as SCLK rises
                await RisingEdge(dut.spi_sclk)
                bit = int(dut.adc_din.value)
                if head or bit:
                    head.append(bit)
            assert head[1] == 1, "single-ended"
            channel = head[2] << 2 | head[3] << 1 | head[4]
            await RisingEdge(dut.spi_sclk)  # it samples
            code = self.codes[channel]
            for place in range(12, -1, -1):  # the null bit first, each as SCLK falls
                await FallingEdge(dut.spi_sclk)
                dut.adc_dout.value = 0 if place == 12 else code >> place & 1
            self.reads.append(channel)


class Dac8568:
    """32 bits as SCLK falls while SYNC is low: prefix, control, address, data, feature. Input
    registers go out as LDAC falls; as CLR falls all take the clear code, the lowest at first. It
    keeps its power from one test to the next, and its contents."""

    reference, value, _input, _clear = False, {0: 0x8000, 1: 0x8000}, {}, 0x0000

    def __init__(self, dut):
        self.dut = dut
        self._tasks = [cocotb.start_soon(t) for t in (self._run(), self._ldac(), self._clr())]

    async def _ldac(self):
        while True:
            await FallingEdge(self.dut.dac_ldac_n)
            if int(self.dut.dac_clr_n.value):
                Dac8568.value = self.value | self._input

    async def _clr(self):
        while True:
            await FallingEdge(self.dut.dac_clr_n)
            Dac8568.value = dict.fromkeys(self.value, self._clear)
            Dac8568._input = dict(self.value)

    async def _run(self):
        dut = self.dut
        while True:
            await FallingEdge(dut.dac_sync_n)
            word = 0
            for _ in range(32):
                await FallingEdge(dut.spi_sclk)
                assert not int(dut.dac_sync_n.value), "SYNC rises within a word"
                word = word << 1 | int(dut.dac_din.value)
            if word == 0x0800_0001:
                Dac8568.reference = True
            elif word >> 24 == 0x05:
                Dac8568._clear = {0: 0x0000, 1: 0x8000, 2: 0xFFFF}[word & 3]
            else:
                assert word >> 24 == 0x00, f"{word:08X} is no write to an input register"
                self._input[word >> 20 & 15] = word >> 4 & 0xFFFF


def crc8(message: bytes) -> int:
    """Polynomial 0x07, from 0xFF."""
    check = 0xFF
    for byte in message:
        check ^= byte
        for _ in range(8):
            check = check << 1 & 0xFF ^ (7 if check & 0x80 else 0)
    return check


class SerialHost:
    """The PC: rd(offset) and wr(offset, value) over the serial line."""

    def __init__(self, dut, baud: int):
        self.dut, self.bit_ps = dut, round(1e12 / baud)
        dut.ftdi_txd.value = 1

    async def _send(self, byte: int):
        for bit in (0, *(byte >> n & 1 for n in range(8)), 1):
            self.dut.ftdi_txd.value = bit
            await Timer(self.bit_ps // 2 * 2, "ps")

    async def _answer(self) -> int:
        await FallingEdge(self.dut.ftdi_rxd)
        await Timer(self.bit_ps * 3 // 4 * 2, "ps")
        byte = 0
        for n in range(8):
            byte |= int(self.dut.ftdi_rxd.value) << n
            await Timer(self.bit_ps // 2 * 2, "ps")
        assert int(self.dut.ftdi_rxd.value), "the stop bit"
        return byte

    async def send(self, *request: int) -> None:
        for byte in request:
            await self._send(byte)

    async def _ask(self, *request: int) -> int:
        """The answer begins before the last stop bit has ended."""
        check = crc8(bytes(request))
        await self.send(*request)
        task = cocotb.start_soon(self._send(check))
        answer = await self._answer()
        assert await self._answer() == crc8(bytes([*request, answer])), "the check of the answer"
        await task
        return answer

    async def rd(self, offset: int) -> int:
        return await self._ask(offset >> 8, offset & 0xFF, 0)

    async def wr(self, offset: int, value: int) -> None:
        assert await self._ask(0x80 | offset >> 8, offset & 0xFF, value) == 0
