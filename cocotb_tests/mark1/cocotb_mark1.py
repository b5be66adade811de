# SPDX-License-Identifier: Apache-2.0
# Length: many short cases of one block, read one at a time.
"""The Mark I card alone in the bus of a PC: no adaptor. §5.3, §5.4"""

import cocotb
from cocotb.triggers import ClockCycles, RisingEdge, Timer
from cocotbext.pcbus import PcBus, PcBusMaster
from cocotbext.quadrature import QuadratureDecoder, QuadratureSource

from cocotb_tests.lib.req import slow, test, tests_on, variants
from cocotb_tests.lib.tb import (
    B_DOUBLE,
    B_INDEX,
    C_BEAT1,
    C_DONE,
    C_INDEX1,
    DAC1,
    DAC2,
    ENC1,
    LATCH,
    LATCH_ALL,
    LEDS,
    PORT_A,
    PORT_B,
    PORT_C,
    PPI_CONTROL,
    PPI_SETUP,
    QUAD,
    RUN,
    Host,
    volts_of,
)

TOPLEVEL = "mark1"
VARIANTS = {"short": {"HeartbeatUs": 100, "RelayUs": 20}, "real": {}}


class Card(Host):
    """A card at DIP setting 9 in a PC."""

    dip = 9
    limit_ms = 200

    async def start(self, b: int | None = RUN):
        await super().start()
        dut = self.dut
        dut.dip_i.value = self.dip
        dut.axis_enable_i.value = 3
        self.bus = PcBus.from_prefix(dut, "pc")
        self.pc = PcBusMaster(self.bus, dut.clk_i, base=0x300 | self.dip << 10)
        self.enc: list[QuadratureSource] = self.encoders(2)
        await ClockCycles(dut.clk_i, 2)
        if b is not None:
            await self.setup(0, b)
        return self

    async def crd(self, card: int, register: int) -> int:
        return await self.pc.read(register)

    async def cwr(self, card: int, register: int, value: int) -> None:
        await self.pc.write(register, value)

    async def sclock(self) -> None:
        self.dut.pc_drq_i.value = 0
        await ClockCycles(self.dut.clk_i, 3)
        self.dut.pc_drq_i.value = 1 << 2
        await ClockCycles(self.dut.clk_i, 1)

    def led(self, name: str) -> int:
        return int(self.dut.leds_o.value) >> LEDS.index(name) & 1

    def panic(self) -> int:
        return int(self.dut.pc_irq_o.value) >> 4  # IRQ7 of IRQ7-3

    async def led_edge(self, name: str, level: int) -> float:
        while self.led(name) != level:
            await self.dut.leds_o.value_change
        return self.now()


card_test = tests_on(Card, "short")


@card_test("CRD-1", "CRD-2")
async def answers_only_at_its_switch_setting(tb):
    """Of the 16 settings x 32 bases, and never with AEN high."""
    found = [
        (dip, base)
        for dip in range(16)
        for base in range(32)
        if await tb.pc.inb(dip << 10 | base << 5 | PORT_A) != 0xFF
    ]
    assert found == [(9, 0x18)]
    assert await tb.pc.inb(tb.pc.base | PORT_A, aen=1) == 0xFF
    await tb.pc.outb(tb.pc.base | PORT_A, 0x77, aen=1)
    assert await tb.pc.read(PORT_A) == QUAD


@card_test("CRD-1", "CRD-2")
async def every_switch_setting(dut, tb):
    for dip in range(16):
        dut.dip_i.value = dip
        await ClockCycles(dut.clk_i, 2)
        found = [d for d in range(16) if await tb.pc.inb(d << 10 | 0x300) != 0xFF]
        assert found == [dip]


@card_test("CRD-1", "PPI-1")
async def every_register(tb):
    """What each of the 32 offsets does on read; holes and write-only ones are 0xFF."""
    await tb.us(25)
    await tb.preset(0, 0x1234)
    await tb.preset(1, 0x5678)
    tb.inputs([0x1230, 0x4560])
    await tb.pc.write(LATCH, 0)
    await tb.us(26)
    expected = {0: QUAD, 1: RUN, 2: 0xF0, 4: 0x12, 5: 0x34, 6: 0x56, 7: 0x78}
    expected |= {0x0C: 0x23, 0x0D: 0x56, 0x0E: 0xC9}
    for register in range(32):
        if register not in (0x10, 0x12):
            value = await tb.pc.read(register)
            assert value == expected.get(register, 0xFF), f"offset {register:02X}: {value:02X}"


@card_test("PPI-1")
async def reset_drv_makes_ports_inputs(dut, tb):
    """RESET DRV: safe board, counters 0; D/A and one-shot untouched."""
    await tb.us(25)
    await tb.preset(0, 77)
    await tb.dac(0, 0xC00)
    assert tb.volts(0) == 0x4000
    dut.pc_reset_drv_i.value = 1
    await tb.us(2)
    dut.pc_reset_drv_i.value = 0
    await ClockCycles(dut.clk_i, 2)
    assert tb.led("beat1") == 1
    assert tb.volts(0) == 0
    await tb.pc.write(PPI_CONTROL, PPI_SETUP)
    assert await tb.pc.read(PORT_A) == 0 and await tb.pc.read(PORT_B) == 0
    await tb.pc.write(PORT_B, RUN)
    await tb.us(25)
    assert tb.volts(0) == 0x4000
    assert await tb.encoder(0) == 0


@card_test("ENC-1", "CRD-2")
async def counts_four_million_a_second(tb):
    await tb.preset(0, 0xFF00)
    await tb.preset(1, 0x0100)
    up = cocotb.start_soon(tb.enc[0].move(600, 250))
    await tb.enc[1].move(-600, 250)
    await up
    await tb.us(1)
    assert await tb.encoder(0) == (0xFF00 + 600) & 0xFFFF
    assert await tb.encoder(1) == (0x0100 - 600) & 0xFFFF


@card_test("ENC-1")
async def counts_a_worn_encoder(dut, tb):
    """A trapezoid to 2.5 M counts/s and back, edges up to 0.45 of a count from their places."""
    await tb.preset(0, 0)
    for phase, duty in ((0, 0), (30, 10), (-15, -25)):
        source = QuadratureSource(
            tb.enc[0].a, tb.enc[0].b, phase_error_deg=phase, duty_error_deg=duty
        )
        decoder = QuadratureDecoder(dut.enc_a_i, dut.enc_b_i, shortest_ns=125)
        await tb.clocks(2)
        for sign in (1, -1):
            top = sign * 2.5e6
            await source.profile([(100e-6, 0, top), (20e-6, top, top), (100e-6, top, 0)])
            await tb.us(1)
            assert await tb.encoder(0) == source.count == decoder.count == (300 if sign > 0 else 0)
        decoder.stop()


@card_test("ENC-1", "PCB-1")
async def slow_bus_clock_slows_the_sampling(dut, tb):
    """CLK ticks every fourth clock: a level shorter than that can pass unseen, longer cannot."""
    await tb.preset(0, 0)

    async def clk():
        n = 0
        while True:
            await RisingEdge(dut.clk_i)
            n += 1
            dut.pc_clk_en_i.value = int(n % 4 == 0)

    cocotb.start_soon(clk())
    await tb.enc[0].move(100, 1010)
    await tb.us(4)
    assert await tb.encoder(0) == 100
    await tb.enc[0].move(100, 130)
    await tb.us(4)
    assert await tb.encoder(0) != 200


@card_test("ENC-2")
async def byte_order_is_chosen_by_the_first_read(dut, tb):
    """First byte address read after RESET takes the snapshot, each time; the other returns it."""
    for first in (0, 1):
        dut.pc_reset_drv_i.value = 1
        await tb.us(1)
        dut.pc_reset_drv_i.value = 0
        await ClockCycles(dut.clk_i, 2)
        await tb.setup(0)
        await tb.pc.write(ENC1 + first, (0x12, 0x34)[first])
        await tb.pc.write(ENC1 + 1 - first, (0x34, 0x12)[first])
        one = await tb.pc.read(ENC1 + first)
        await tb.enc[0].move(0x300, 250)
        await tb.us(1)
        two = await tb.pc.read(ENC1 + 1 - first)
        pair = (one, two) if first == 0 else (two, one)
        assert pair == (0x12, 0x34), f"first {first}: {pair[0]:02X}{pair[1]:02X}"
        # a stray single read does not make later pairs stale
        await tb.pc.read(ENC1 + 1 - first)
        one = await tb.pc.read(ENC1 + first)
        two = await tb.pc.read(ENC1 + 1 - first)
        pair = (one, two) if first == 0 else (two, one)
        assert pair == (0x15, 0x34)
        await tb.enc[0].move(-0x300, 250)


@card_test("ENC-2", "LAT-1")
async def latched_once_then_live(tb):
    await tb.preset(0, 100)
    await tb.sclock()
    await tb.enc[0].move(5, 300)
    await tb.us(1)
    assert [await tb.encoder(0) for _ in range(3)] == [100, 105, 105]
    await tb.pc.write(LATCH, 0)
    await tb.enc[0].move(5, 300)
    await tb.sclock()  # a second latch before the read wins
    await tb.enc[0].move(5, 300)
    await tb.us(1)
    assert [await tb.encoder(0) for _ in range(2)] == [110, 115]


@card_test("LAT-1")
async def latch_on_the_very_clock(dut, tb):
    """SCLOCK rises between two counts, at every phase of the clock: one of the two is latched."""
    await tb.preset(0, 0)
    for n in range(12):
        tb.dut.pc_drq_i.value = 0
        await ClockCycles(dut.clk_i, 4)
        start = tb.enc[0].count
        task = cocotb.start_soon(tb.enc[0].move(8, 500))
        await Timer(1000 + 37 * n, "ns")
        await RisingEdge(dut.clk_i)
        at = tb.enc[0].count
        dut.pc_drq_i.value = 4
        await task
        await tb.us(1)
        latched = await tb.encoder(0)
        assert at - 1 <= latched <= at, f"latched {latched} at {at}"
        assert await tb.encoder(0) == start + 8


@card_test("DAC-1", "LAT-1", b=RUN | B_DOUBLE)
async def both_ranks(dut, tb):
    await tb.us(25)
    await tb.dac(0, 0x123)
    await tb.dac(1, 0xFED)
    assert [tb.volts(j) for j in (0, 1)] == [0, 0]
    await tb.sclock()
    await ClockCycles(dut.clk_i, 2)
    assert [tb.volts(j) for j in (0, 1)] == [volts_of(c) for c in (0x123, 0xFED)]
    await tb.pc.write(PORT_B, RUN)  # single-buffered again: the high write takes both bytes out
    await tb.pc.write(DAC2, 0x00)
    assert tb.volts(1) == (0xFED - 0x800) * 16
    await tb.pc.write(DAC2 + 1, 0x8)
    assert tb.volts(1) == 0


@card_test("ADC-1")
async def conversion_to_the_clock(tb):
    """200 clocks at 8 MHz from the latch; a start on any clock of it is ignored."""
    await tb.us(25)
    tb.inputs([0x1000])
    polls = []
    await tb.sclock()
    start = tb.now()
    while not await tb.pc.read(PORT_C) & C_DONE:
        polls.append((tb.now() - start) / tb.period)
        await tb.sclock()
    assert 190 < polls[-1] < 208, f"done after {polls[-1]} clocks"
    assert len(polls) > 15
    await tb.us(30)
    assert await tb.adc(0) == 0x900


@card_test("LAT-1", "ADC-1")
async def latch_all_of_another_card(tb):
    """0x12 at any card address latches; 0x10 at another's does not."""
    for dip in range(16):
        await tb.pc.outb(dip << 10 | 0x300 | LATCH_ALL, 0)
        assert not await tb.pc.read(PORT_C) & C_DONE
        await tb.us(26)
        await tb.pc.outb(dip << 10 | 0x300 | LATCH, 0)
        assert bool(await tb.pc.read(PORT_C) & C_DONE) == (dip != 9)
        await tb.us(26)


@card_test("HB-1", "HB-2", "CRD-2")
async def heartbeat_on_every_clock_around_its_end(dut, tb):
    """100 us = 800 clocks: a trigger up to the last clock extends without a glitch, then PANIC."""
    dut.axis_enable_i.value = 1
    gaps = []
    for early in range(6, -6, -1):
        await tb.pc.write(DAC1, 0)
        await tb.led_edge("beat1", 1)
        await tb.us(150)
        write = cocotb.start_soon(tb.pc.write(DAC1, 0))
        start = await tb.led_edge("beat1", 1)
        await write
        fell = []

        async def ends(out=fell):
            out.append(await tb.led_edge("beat1", 0))

        watch = cocotb.start_soon(ends())
        again = start + 800 * tb.period - (early + 2) * tb.period
        await Timer(round((again - tb.now()) / 1000), "ns")
        await tb.pc.write(DAC1, 0)
        await tb.us(3)
        watch.cancel()
        assert tb.led("beat1") == 1 and not tb.panic()
        if fell:
            assert tb.clks(fell[0] - start) == 800
        gaps.append(bool(fell))
    assert gaps == sorted(gaps) and True in gaps and False in gaps, f"{gaps}"


@card_test("HB-2", "SW-1")
async def panic_needs_an_enabled_axis(dut, tb):
    """All four switch settings x both heartbeats."""
    for enabled in range(4):
        dut.axis_enable_i.value = enabled
        for beating in range(4):
            await tb.us(105)
            for joint in (0, 1):
                if beating >> joint & 1:
                    await tb.pc.write(DAC1 + 2 * joint, 0)
            await ClockCycles(dut.clk_i, 4)
            assert tb.panic() == int(bool(enabled & ~beating)), f"{enabled:02b} {beating:02b}"
            assert int(dut.pc_irq_o.value) & 0xF == 0, "only the jumpered line"
            assert await tb.pc.read(PORT_C) & 5 == (beating & 1) | (beating & 2) << 1


@card_test("SW-1")
async def switch_grounds_the_drive(dut, tb):
    await tb.us(25)
    await tb.dac(0, 0xC00)
    await tb.dac(1, 0x400)
    for enabled in range(4):
        dut.axis_enable_i.value = enabled
        await ClockCycles(dut.clk_i, 4)
        assert [tb.volts(j) for j in (0, 1)] == [
            0x4000 if enabled & 1 else 0,
            -0x4000 if enabled & 2 else 0,
        ]


@card_test("CAL-1")
async def index_at_any_speed(tb):
    """The count latched is exactly that of the index, upwards and downwards, to 4 M counts/s.

    The index comes and goes with an edge of A or B, at any phase of the clock.
    """
    e = tb.enc[0]
    e.lines = 4  # an index every 16 counts
    await e.move(5, 500)
    for ns in (250, 260, 333, 500, 2000):
        for start, end in ((5, 29), (29, 5)):
            await tb.pc.write(PORT_B, RUN)
            await tb.preset(0, e.count)
            await tb.pc.write(PORT_B, RUN | B_INDEX)
            assert not await tb.pc.read(PORT_C) & C_INDEX1
            await Timer(2 + 2 * tb.random.randrange(tb.period // 2), "ps")
            assert e.count == start
            await e.move(end - start, ns)
            await tb.us(1)
            assert await tb.pc.read(PORT_C) & C_INDEX1
            assert await tb.encoder(0) == 16, f"{ns} ns, from {start} to {end}"
            assert await tb.encoder(0) == end


@card_test("DIA-2", "CAL-1", b=0)
async def the_made_index_is_one_bit_of_port_a(tb):
    """Bit 7 alone, whatever lights, A and B do."""
    for value in range(32):
        await tb.pc.write(PORT_B, 0)
        await tb.pc.write(PORT_A, QUAD | value << 3)
        await tb.pc.write(PORT_B, B_INDEX)
        await tb.us(2)
        assert bool(await tb.pc.read(PORT_C) & C_INDEX1) == (value > 15), f"{value:02X}"


@card_test("LED-2", "PAN-2")
async def power_off(dut, tb):
    """No power: LEDs off, no drive, no answer, one-shots low, PANIC line not driven by the card."""
    await tb.us(25)
    await tb.dac(0, 0xC00)
    await tb.dac(1, 0xC00)
    assert tb.led("power") == 1 and tb.volts(0)
    dut.power_i.value = 0
    await ClockCycles(dut.clk_i, 3)
    assert int(dut.leds_o.value) == 0
    assert [tb.volts(j) for j in (0, 1)] == [0, 0]
    assert await tb.pc.read(PORT_A) == 0xFF
    dut.power_i.value = 1
    await ClockCycles(dut.clk_i, 3)
    await tb.pc.write(PPI_CONTROL, PPI_SETUP)
    assert await tb.pc.read(PORT_C) & 5 == 0
    assert tb.led("power") == 1


@card_test("PPI-1", "CRD-2")
async def port_b_bits_5_to_7_are_free(tb):
    """Unassigned bits hold what is written and move nothing; port C shows 1 there."""
    await tb.us(25)
    await tb.dac(0, 0xC00)
    for high in range(8):
        await tb.pc.write(PORT_B, RUN | high << 5)
        assert await tb.pc.read(PORT_B) == RUN | high << 5
        assert tb.volts(0) == 0x4000
        assert await tb.pc.read(PORT_C) & 0xE0 == 0xE0


@card_test("CRD-2", "DAC-1", "ENC-1", "ADC-1")
async def random_traffic(tb):
    """400 random accesses against a model of ports, D/As and encoders."""
    await tb.us(25)
    ports, low, volts, counts = [QUAD, RUN], [0, 0], [0, 0], [0, 0]
    for joint in (0, 1):
        await tb.preset(joint, 0)
        await tb.dac(joint, 0x800)
        low[joint] = 0
    compared = 0
    for _ in range(400):
        joint, value = tb.random.randrange(2), tb.random.getrandbits(8)
        kind = tb.random.randrange(7)
        if kind == 0:
            ports[0] = QUAD | value & 0xF8
            await tb.pc.write(PORT_A, ports[0])
        elif kind == 1:
            await tb.pc.write(DAC1 + 2 * joint, value)
            low[joint] = value
        elif kind == 2:
            await tb.pc.write(DAC1 + 2 * joint + 1, value)
            volts[joint] = (((value & 15) << 8 | low[joint]) - 0x800) * 16
        elif kind == 3:
            counts[joint] = value << 8 | value ^ 0x5A
            await tb.preset(joint, counts[joint])
        elif kind == 4:
            move = tb.random.choice((-3, -1, 1, 2, 7))
            await tb.enc[joint].move(move, 250)
            await tb.us(0.5)
            counts[joint] = (counts[joint] + move) & 0xFFFF
        elif kind == 5:
            assert await tb.pc.read(PORT_A) == ports[0]
            compared += 1
        else:
            assert await tb.encoder(joint) == counts[joint]
            compared += 1
        assert [tb.volts(j) for j in (0, 1)] == volts
    assert compared > 80


@test("HB-1", "DIA-1", "ADC-1")
@variants("real")
@slow
async def real_heartbeat_relay_and_conversion(dut):
    """The times of the report: 50 ms to the clock, 1 ms, 25 us."""
    tb = await Card(dut).start()
    dut.axis_enable_i.value = 1
    await tb.pc.write(DAC1, 0xFF)
    await tb.pc.write(DAC1 + 1, 0xF)
    start = tb.now()
    await dut.drive_v_o.value_change
    relay = (tb.now() - start) / 1e6
    assert 990 < relay < 1001, f"relay {relay} us"
    await tb.sclock()
    start = tb.now()
    while not await tb.pc.read(PORT_C) & C_DONE:
        pass
    assert abs((tb.now() - start) / 1e6 - 25) < 1
    write = cocotb.start_soon(tb.pc.write(DAC1, 0))
    await write
    assert await tb.pc.read(PORT_C) & C_BEAT1
    await tb.us(49_900)
    assert not tb.panic()
    await tb.led_edge("beat1", 0)
    await tb.clocks(2)
    assert tb.panic()
    task = cocotb.start_soon(tb.pc.write(DAC1, 0))
    begin = await tb.led_edge("beat1", 1)
    await task
    await tb.us(49_990)
    end = await tb.led_edge("beat1", 0)
    assert tb.clks(end - begin) == 400_000
