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
    """32 bits as SCLK falls while SYNC is low: prefix, control, address, data, feature."""

    def __init__(self, dut):
        self.dut, self.value, self.reference = dut, {}, False
        self._task = cocotb.start_soon(self._run())

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
                self.reference = True
            else:
                assert word >> 24 == 0x03, f"{word:08X} is no write and update"
                self.value[word >> 20 & 15] = word >> 4 & 0xFFFF


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

    async def _ask(self, *request: int) -> int:
        """The answer begins before the last stop bit has ended."""
        for byte in request[:-1]:
            await self._send(byte)
        task = cocotb.start_soon(self._send(request[-1]))
        answer = await self._answer()
        await task
        return answer

    async def rd(self, offset: int) -> int:
        return await self._ask(offset >> 8, offset & 0xFF)

    async def wr(self, offset: int, value: int) -> None:
        assert await self._ask(0x80 | offset >> 8, offset & 0xFF, value) == 0
