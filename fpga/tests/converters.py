# SPDX-License-Identifier: Apache-2.0
"""The chips beside the FPGA on a board, from their data sheets: MCP3208 and DAC8568."""

import cocotb
from cocotb.triggers import FallingEdge, RisingEdge


class Mcp3208:
    """An A/D of eight channels: start, single-ended, three bits of channel; null bit, 12 bits."""

    def __init__(self, dut, codes):
        self.dut, self.codes, self.reads = dut, codes, []
        dut.adc_dout_i.value = 0
        self._task = cocotb.start_soon(self._run())

    async def _run(self):
        dut = self.dut
        while True:
            await FallingEdge(dut.adc_cs_no)
            head = []
            while len(head) < 5:  # the start bit is the first 1; DIN is taken as SCLK rises
                await RisingEdge(dut.sclk_o)
                bit = int(dut.adc_din_o.value)
                if head or bit:
                    head.append(bit)
            assert head[1] == 1, "single-ended"
            channel = head[2] << 2 | head[3] << 1 | head[4]
            await RisingEdge(dut.sclk_o)  # it samples
            code = self.codes[channel]
            for place in range(12, -1, -1):  # the null bit first, each as SCLK falls
                await FallingEdge(dut.sclk_o)
                dut.adc_dout_i.value = 0 if place == 12 else code >> place & 1
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
            await FallingEdge(self.dut.dac_ldac_no)
            if int(self.dut.dac_clr_no.value):
                Dac8568.value = self.value | self._input

    async def _clr(self):
        while True:
            await FallingEdge(self.dut.dac_clr_no)
            Dac8568.value = dict.fromkeys(self.value, self._clear)
            Dac8568._input = dict(self.value)

    async def _run(self):
        dut = self.dut
        while True:
            await FallingEdge(dut.dac_sync_no)
            word = 0
            for _ in range(32):
                await FallingEdge(dut.sclk_o)
                assert not int(dut.dac_sync_no.value), "SYNC rises within a word"
                word = word << 1 | int(dut.dac_din_o.value)
            if word == 0x0800_0001:
                Dac8568.reference = True
            elif word >> 24 == 0x05:
                Dac8568._clear = {0: 0x0000, 1: 0x8000, 2: 0xFFFF}[word & 3]
            else:
                assert word >> 24 == 0x00, f"{word:08X} is no write to an input register"
                self._input[word >> 20 & 15] = word >> 4 & 0xFFFF
