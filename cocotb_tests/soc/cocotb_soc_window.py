# SPDX-License-Identifier: Apache-2.0
"""The computer above and the SoC's processor share memory by the window. docs/hardware/soc.md

The mailbox is used as firmware/ports/mailbox.h says, by words that go through the window, while a
stand-in for the core keeps the data port as busy as can be.
"""

import random

import cocotb
from cocotb.triggers import FallingEdge

from cocotb_tests.lib.req import test
from cocotb_tests.soc.cocotb_soc_bridge import CLOCKS, TwoClocks

TOPLEVEL = "soc_host"
SOURCES = ["../../rtl/soc/soc_cross.sv", "../../rtl/soc/soc_bridge.sv", "../../rtl/soc/soc_ram.sv",
           "../../rtl/soc/soc_host.sv", "bench_cpu.sv"]  # fmt: skip
MAILBOX = 0x1E000
POSTED, DONE, RESULT, DATA = MAILBOX + 8, MAILBOX + 12, MAILBOX + 32, MAILBOX + 0x500
OWN, OWN_BYTES = 0x4000, 0x1000  # where the stand-in writes
MAILBOX_DONE = 4
ANSWER_CLKS = 12  # of the machine, from request to answer, with a processor on the same clock


class Above(TwoClocks):
    """The computer above: one word at a time."""

    longest = 0

    async def start(self, run):
        await super().start()
        self.dut.run_i.value = run
        await self.clocks(5)
        return self

    async def clocks(self, n):
        for _ in range(n):
            await FallingEdge(self.dut.clk_i)

    async def access(self, address, value=None, gap=0):
        """Read, or write of a value. Registers of the computer above see the answer a clock later:
        only then the request goes, or is the next one's."""
        dut = self.dut
        dut.box_req_i.value = 1
        dut.box_write_i.value = int(value is not None)
        dut.box_a_i.value = address >> 2
        dut.box_wdata_i.value = value or 0
        waited = 0
        await FallingEdge(dut.clk_i)
        while not int(dut.box_ack_o.value):
            await FallingEdge(dut.clk_i)
            waited += 1
            assert waited < 1000, "the window does not answer"
        self.longest = max(self.longest, waited)
        answer = int(dut.box_rdata_o.value) if value is None else None
        await FallingEdge(dut.clk_i)
        assert not int(dut.box_ack_o.value), "one clock of answer"
        dut.box_req_i.value = 0
        dut.box_a_i.value = random.getrandbits(30)
        dut.box_write_i.value = random.randint(0, 1)
        for _ in range(gap):
            await FallingEdge(dut.clk_i)
            assert not int(dut.box_ack_o.value), "an answer that nobody asked for"
        return answer

    async def rd(self, address):
        return await self.access(address, gap=random.randint(0, 2))

    async def wr(self, address, value):
        await self.access(address, value, gap=random.randint(0, 2))

    async def request(self, words):
        """Posts these, rings, and waits for the report, which is left standing."""
        dut = self.dut
        for n, word in enumerate(words):
            await self.wr(DATA + 4 * n, word)
        number = (await self.rd(POSTED) + 1) & 0xFFFFFFFF
        await self.wr(POSTED, number)
        await self.clocks(1)
        dut.ring_i.value = 1
        await self.clocks(1)
        dut.ring_i.value = 0
        for _ in range(2000):
            if int(dut.report_valid_o.value):
                break
            await self.clocks(1)
        assert int(dut.report_valid_o.value) and int(dut.report_o.value) == MAILBOX_DONE
        return number

    async def take(self):
        dut = self.dut
        dut.report_take_i.value = 1
        await self.clocks(1)
        dut.report_take_i.value = 0
        await self.clocks(1)
        assert not int(dut.report_valid_o.value)


@test("SOC-3")
@cocotb.parametrize(clock=list(CLOCKS))
async def the_interrupt_reaches_the_processor(dut, clock):
    """The level of the machine's request, and its end, within three of the processor's clocks."""
    tb = await Above(dut, clock).start(run=1)
    for level in (1, 0, 1):
        dut.irq_i.value = level
        for _ in range(3):
            await FallingEdge(dut.cpu_clk_i)
        assert int(dut.u_cpu.irq_external_i.value) == level
        await tb.clocks(4)
        assert int(dut.u_cpu.irq_external_i.value) == level


@test("SOC-4")
@cocotb.parametrize(clock=list(CLOCKS))
async def memory_is_filled_while_the_processor_is_held(dut, clock):
    """Every word has its place, first and last included, and nothing is written twice."""
    tb = await Above(dut, clock).start(run=0)
    places = [0, 4, 0x1FFFC, 0x10000, *(4 * n for n in random.sample(range(2, 0x7FFF), 60))]
    image = {address: random.getrandbits(32) for address in places}
    for address, word in image.items():
        await tb.wr(address, word)
    for address in random.sample(list(image), len(image)):
        assert await tb.rd(address) == image[address], hex(address)
    # without a pause: each answer ends one request and begins the next
    for address in places[:20]:
        await tb.access(address, image[address] ^ 0xFFFFFFFF)
    for address in places[:20]:
        assert await tb.access(address) == image[address] ^ 0xFFFFFFFF


@test("SOC-4")
@cocotb.parametrize(clock=list(CLOCKS))
async def requests_pass_through_the_mailbox(dut, clock):
    """Data in, answer out, the report last; the processor waits until its report is taken."""
    tb = await Above(dut, clock).start(run=0)
    for address in range(MAILBOX, MAILBOX + 0x30, 4):
        await tb.wr(address, 0)
    dut.run_i.value = 1
    for n in range(1, 7):
        words = [random.getrandbits(32) for _ in range(8)]
        assert await tb.request(words) == n
        assert await tb.rd(DONE) == n
        assert await tb.rd(RESULT) == sum(words) & 0xFFFFFFFF
        assert [await tb.rd(DATA + 4 * i) for i in range(8)] == [
            (word + 1) & 0xFFFFFFFF for word in words
        ]
        rounds = int(dut.u_cpu.rounds_q.value)
        await tb.clocks(50)
        assert int(dut.u_cpu.rounds_q.value) == rounds, "its report is not taken yet"
        assert int(dut.report_valid_o.value)
        await tb.take()
        await tb.clocks(50)
        assert int(dut.u_cpu.rounds_q.value) > rounds
    assert int(dut.u_cpu.wrong_q.value) == 0


@test("SOC-4")
@cocotb.parametrize(clock=list(CLOCKS))
async def window_takes_the_clocks_that_the_processor_leaves(dut, clock):
    """Neither waits long for the other, neither spoils a word of the other."""
    tb = await Above(dut, clock).start(run=0)
    free = [4 * n for n in random.sample(range(0x7000), 60) if not OWN <= 4 * n < OWN + OWN_BYTES]
    dut.run_i.value = 1
    await tb.clocks(20)
    tb.longest, image = 0, {}
    for _ in range(200):
        address = random.choice(free)
        if address in image and random.random() < 0.5:
            assert await tb.rd(address) == image[address]
        else:
            image[address] = random.getrandbits(32)
            await tb.wr(address, image[address])
    assert tb.longest <= ANSWER_CLKS
    rounds = int(dut.u_cpu.rounds_q.value)
    assert rounds > 200 and int(dut.u_cpu.wrong_q.value) == 0
    # what the processor wrote is seen: its last words, while it stands still
    dut.run_i.value = 0
    await tb.clocks(20)
    words = [await tb.rd(OWN + 4 * (37 * n % 1024)) for n in range(min(200, rounds))]
    assert all(word >> 22 == 37 * n % 1024 ^ 0x5A5A1234 >> 22 for n, word in enumerate(words))
