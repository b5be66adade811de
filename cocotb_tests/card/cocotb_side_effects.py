# SPDX-License-Identifier: Apache-2.0
# Length: one test for each thing that must not happen, on three hosts.
"""What must not happen on a card: reads that write, latches that update, slow relays. §5.3"""

import cocotb
from cocotb.triggers import FallingEdge

from cocotb_tests.card.host import VARIANTS as CARDS
from cocotb_tests.card.host import Slot
from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import (
    B_INDEX,
    B_SCLOCK,
    B_TO_JOINT,
    C_BEAT1,
    C_BEAT2,
    C_DONE,
    C_INDEX1,
    DAC1,
    ENC1,
    LATCH,
    PORT_A,
    PORT_B,
    PORT_C,
    PPI_CONTROL,
    PPI_SETUP,
    QUAD,
    RUN,
    volts_of,
)

TOPLEVEL = "mark1"
PARAMETERS = CARDS["slot"]
CODES = (0x9A5, 0x35C)
READABLE = {*range(8), 12, 13, 14}
card_test = tests_on(Slot)


async def driving(dut) -> Slot:
    """Both D/As written and connected; the heartbeats have run out."""
    tb = await Slot(dut).start()
    for joint, code in enumerate(CODES):
        await tb.dac(joint, code)
    await tb.us(130)
    assert tb.drives() == [volts_of(code) for code in CODES]
    assert not await tb.pc.read(PORT_C) & (C_BEAT1 | C_BEAT2)
    return tb


driving_test = tests_on(driving)


@driving_test("DAC-1", "HB-1", "CRD-1")
async def reading_a_converter_writes_nothing(dut, tb):
    """The D/A registers are write-only: a read starts no heartbeat and leaves both ranks."""
    for register in range(DAC1, DAC1 + 4):
        dut.pc_d_i.value = 0x00
        assert await tb.pc.read(register) == 0xFF
        assert not await tb.pc.read(PORT_C) & (C_BEAT1 | C_BEAT2), f"read of {register:02X}"
    for joint, code in enumerate(CODES):
        await tb.pc.write(DAC1 + 2 * joint + 1, code >> 8)
    assert tb.drives() == [volts_of(code) for code in CODES]


@driving_test("DAC-1", "LAT-1")
async def latch_leaves_a_single_buffered_output(tb):
    """Without double buffering only the high nibble completes a value, never a latch."""
    for joint in (0, 1):
        await tb.pc.write(DAC1 + 2 * joint, 0x77)
    await tb.pc.write(LATCH, 0)
    await tb.pulse()
    await tb.clocks(3)
    assert tb.drives() == [volts_of(code) for code in CODES]


@driving_test("DIA-1")
async def joints_are_isolated_at_once(tb):
    """The relay takes its time, but nothing is driven from the moment its coil is off."""
    await tb.pc.write(PORT_B, RUN & ~B_TO_JOINT)
    await tb.clocks(1)
    assert tb.drives() == [0, 0]


@card_test("LAT-1", "CRD-1")
@cocotb.parametrize(sclock=[False, True])
async def software_latch_is_one_instant(dut, tb, sclock):
    """The first clock of the command, however long it lasts; an SCLOCK within it latches again."""
    await tb.preset(0, 0)
    tb.pc.command = 60
    for _ in range(3):
        dut.pc_drq_i.value = 0
        turning = cocotb.start_soon(tb.enc[0].move(60, 300))
        await tb.us(2.5)
        latch = cocotb.start_soon(tb.pc.write(LATCH, 0))
        await FallingEdge(dut.pc_iow_ni)
        if sclock:
            await tb.us(4)
            await tb.clocks(1)
            dut.pc_drq_i.value = 1 << 2
        at = tb.enc[0].count
        await latch
        await turning
        latched = await tb.encoder(0)
        assert at - 2 <= latched <= at + 1, f"{latched} latched at {at}"
        await tb.enc[0].move(-60, 300)
        await tb.us(1)


@driving_test("CRD-1", "LAT-1")
async def an_address_alone_does_nothing(tb):
    """Every register's address stands on the bus; without IOR# and IOW# nothing comes of it."""
    await tb.preset(0, 100)
    for register in range(32):
        tb.bus.a.value = tb.pc.base | register
        tb.bus.d.value = 0
        await tb.clocks(6)
        assert not int(tb.bus.q_oe.value)
    await tb.enc[0].move(5, 300)
    await tb.us(1)
    assert await tb.encoder(0) == 105, "latched"
    assert await tb.pc.read(PORT_C) & (C_DONE | C_BEAT1 | C_BEAT2) == C_DONE, "converting, beating"
    assert tb.drives() == [volts_of(code) for code in CODES]


@driving_test("CRD-1", "DAC-1", "ENC-1")
async def writing_what_is_read_only_writes_nothing(tb):
    """The A/D registers and all holes, each with its own data."""
    await tb.preset(0, 0x1234)
    await tb.preset(1, 0x5678)
    for register in (*range(12, 16), 17, *range(19, 32)):
        await tb.pc.write(register, 0x40 | register)
        assert not await tb.pc.read(PORT_C) & (C_BEAT1 | C_BEAT2), f"write of {register:02X}"
    for joint, code in enumerate(CODES):
        await tb.pc.write(DAC1 + 2 * joint + 1, code >> 8)
    assert tb.drives() == [volts_of(code) for code in CODES]
    assert [await tb.encoder(j) for j in (0, 1)] == [0x1234, 0x5678]
    assert await tb.pc.read(PORT_B) == RUN


@driving_test("DIA-1")
async def the_relay_takes_the_same_time_each_time(dut, tb):
    """From whichever clock its coil is switched, and also when it was switched back half-way."""
    clocks = tb.parameters["RelayUs"] * 8
    times = set()
    for wait in range(6):
        await tb.pc.write(PORT_B, RUN & ~B_TO_JOINT)
        await tb.relay()
        await tb.clocks(wait)
        if wait > 2:
            await tb.pc.write(PORT_B, RUN)
            await tb.us(tb.parameters["RelayUs"] / 2)
            await tb.pc.write(PORT_B, RUN & ~B_TO_JOINT)
            await tb.clocks(3 + wait)
        assert tb.volts(0) == 0
        await tb.pc.write(PORT_B, RUN)
        begin = tb.now()
        await dut.drive_v_o.value_change
        times.add(tb.clks(tb.now() - begin))
        assert tb.volts(0) == volts_of(CODES[0])
    for before in range(-2, 12):  # switched back around the very clock in which it has closed
        await tb.pc.write(PORT_B, RUN & ~B_TO_JOINT)
        await tb.relay()
        await tb.pc.write(PORT_B, RUN)
        await tb.clocks(clocks - before)
        await tb.pc.write(PORT_B, RUN & ~B_TO_JOINT)
        await tb.relay()
        await tb.pc.write(PORT_B, RUN)
        begin = tb.now()
        await dut.drive_v_o.value_change
        times.add(tb.clks(tb.now() - begin))
    kept = 0  # how often its contacts had not left the joints yet
    for before in range(-2, 12):  # and switched on again around the one in which it has opened
        await tb.pc.write(PORT_B, RUN & ~B_TO_JOINT)
        await tb.clocks(clocks - before)
        await tb.pc.write(PORT_B, RUN)
        begin = tb.now()
        await tb.clocks(1)
        if tb.volts(0):
            kept += 1
            continue
        await dut.drive_v_o.value_change
        times.add(tb.clks(tb.now() - begin))
    assert 0 < kept < 14
    assert len(times) == 1 and clocks - 3 <= times.pop() <= clocks + 1


@card_test("PPI-1", b=RUN)
async def a_write_to_open_ports_reaches_nothing(tb):
    """The latches behind inputs take it; the board sees open pins."""
    await tb.pc.write(PPI_CONTROL, 0x9B)  # all inputs
    for data in (0xFF, 0x04, 0x20):
        for port in (PORT_A, PORT_B):
            await tb.pc.write(port, data)
        assert [await tb.pc.read(port) for port in (PORT_A, PORT_B)] == [0, 0]


@card_test("CAL-1", b=RUN | B_INDEX)
async def an_index_that_stays_latches_once(dut, tb):
    await tb.preset(0, 100)
    tb.enc[0].lines = 0
    dut.enc_i_i.value = 1
    await tb.us(1)
    await tb.enc[0].move(7, 300)
    await tb.us(1)
    assert [await tb.encoder(0) for _ in range(2)] == [100, 107]
    dut.enc_i_i.value = 0


@card_test("ENC-2", b=RUN)
async def another_register_ends_a_pair(tb):
    """After it a lone low byte is that of the present count, not of the high byte's."""
    for between in (None, PORT_A):
        await tb.preset(0, 0x1234)
        assert await tb.pc.read(ENC1) == 0x12
        await tb.enc[0].move(5, 300)
        await tb.us(1)
        if between is not None:
            await tb.pc.read(between)
        assert await tb.pc.read(ENC1 + 1) == (0x34 if between is None else 0x39)
        await tb.encoder(0)


@card_test("CAL-1", "PCB-1", b=RUN | B_INDEX)
async def an_index_of_one_sample_latches(dut, tb):
    """A sample is a tick of the PC's CLK: an index between two ticks is kept for the next one."""
    await tb.preset(0, 100)
    tb.enc[0].lines = 0

    async def index(clocks: int) -> None:
        dut.enc_i_i.value = 1
        await tb.clocks(clocks)
        dut.enc_i_i.value = 0
        await tb.clocks(8)

    await index(1)
    await tb.enc[0].move(7, 300)
    await tb.us(1)
    assert await tb.pc.read(PORT_C) & C_INDEX1
    assert [await tb.encoder(0) for _ in range(2)] == [100, 107]
    await tb.pc.write(PORT_B, RUN)
    await tb.pc.write(PORT_B, RUN | B_INDEX)
    for tick in (0, 1):
        dut.pc_clk_en_i.value = 0
        await tb.clocks(3)
        await index(5)
        for _ in range(6):
            dut.pc_clk_en_i.value = 1
            await tb.clocks(1)
            dut.pc_clk_en_i.value = 0
            await tb.clocks(2)
        dut.pc_clk_en_i.value = 1
        assert await tb.pc.read(PORT_C) & C_INDEX1, f"between ticks, {tick}"
        await tb.pc.write(PORT_B, RUN)
        assert not await tb.pc.read(PORT_C) & C_INDEX1
        await tb.pc.write(PORT_B, RUN | B_INDEX)
    for wait in range(4):
        await tb.pc.write(PORT_B, RUN)
        await tb.pc.write(PORT_B, RUN | B_INDEX)
        dut.pc_clk_en_i.value = 0
        await tb.clocks(2)
        dut.enc_i_i.value = 1
        for tick in range(3):
            await tb.clocks(wait + 1)
            dut.pc_clk_en_i.value = 1
            await tb.clocks(1)
            dut.pc_clk_en_i.value = 0
            await tb.clocks(wait + 2)
            seen = bool(await tb.pc.read(PORT_C) & C_INDEX1)
            assert seen == (tick == 2), f"tick {tick}"
        dut.pc_clk_en_i.value = 1
        dut.enc_i_i.value = 0
        await tb.clocks(6)


@card_test("PPI-1", "HB-1", "CAL-1", b=RUN | B_INDEX)
async def every_status_bit_by_itself(dut, tb):
    """Heartbeats and indices of both joints in port C; an open port B reads 0 (PpiFloatB)."""
    await tb.relay()
    for index in range(4):
        await tb.pc.write(PORT_B, RUN)
        await tb.pc.write(PORT_B, RUN | B_INDEX)
        dut.enc_i_i.value = index
        await tb.clocks(8)
        dut.enc_i_i.value = 0
        want = C_DONE | (index & 1) * C_INDEX1 | (index >> 1) * 8
        for joint, beat in ((None, 0), (0, C_BEAT1), (1, C_BEAT2)):
            if joint is not None:
                await tb.pc.write(DAC1 + 2 * joint, 0)
            assert await tb.pc.read(PORT_C) & 0x1F == want | beat, f"{index} {joint}"
            await tb.us(tb.parameters["HeartbeatUs"] + 2)
    await tb.pc.write(PPI_CONTROL, 0x8B)  # port B an input
    assert await tb.pc.read(PORT_B) == 0


@driving_test("PPI-1", "LAT-1", "CRD-2")
async def free_bits_of_port_b_lead_nowhere(tb):
    """Bits 7-5 hold what is written and move nothing: SCLOCK latches where bit 2 says so, and only
    there. Port C shows 1 in these places."""
    for high in range(8):
        for enabled in (B_SCLOCK, 0):
            value = RUN & ~B_SCLOCK | enabled | high << 5
            await tb.pc.write(PORT_B, value)
            assert await tb.pc.read(PORT_B) == value
            assert await tb.pc.read(PORT_C) & 0xE0 == 0xE0
            assert tb.drives() == [volts_of(code) for code in CODES]
            await tb.preset(0, 100)
            await tb.pulse()
            await tb.enc[0].move(5, 300)
            await tb.us(1)
            assert await tb.encoder(0) == (100 if enabled else 105), f"{high} {enabled}"
            await tb.encoder(0)


@card_test("LED-2", "PAN-2", "HB-2")
async def lights_follow_port_a_and_a_card_without_power_is_dark(dut, tb):
    """Bits 3 and 4 light the two lights, whatever the rest; no power: no light, PANIC, data."""
    for value in range(32):
        await tb.pc.write(PORT_A, QUAD | value << 3)
        await tb.clocks(2)
        assert (tb.led(0, "gp1"), tb.led(0, "gp2")) == (value & 1, value >> 1 & 1), f"{value:02X}"
    await tb.us(tb.parameters["HeartbeatUs"] + 2)
    dut.enc_a_i.value = dut.enc_b_i.value = dut.enc_i_i.value = 3
    await tb.clocks(8)
    assert int(dut.leds_o.value) == 0x7FF & ~(3 << 6) and tb.panic()
    dut.power_i.value = 0
    await tb.clocks(2)
    assert not tb.panic() and not int(dut.leds_o.value)
    assert {await tb.pc.read(register) for register in range(32)} == {0xFF}
    dut.power_i.value = 1
    await tb.clocks(2)


class Numbered(Slot):
    """A card whose number changes."""

    async def number(self, dip: int) -> None:
        self.dut.dip_i.value = dip
        self.pc.base = 0x300 | dip << 10
        await self.pc.write(PPI_CONTROL, PPI_SETUP)

    async def driven(self, address: int) -> int | None:
        """What the card answers with, None if it stays away."""
        dut = self.dut
        seen = []

        async def look():
            await dut.pc_ior_ni.value_change
            await self.clocks(2)
            seen.append(int(dut.pc_d_oe_o.value))

        task = cocotb.start_soon(look())
        value = await self.pc.inb(address)
        await task
        return value if seen[0] else None


numbered_test = tests_on(Numbered)


@numbered_test("CRD-1", "MAP-1")
async def every_number_at_every_setting(tb):
    """A card answers to the number of its switches alone, and takes only its own writes."""
    for dip in range(16):
        await tb.number(dip)
        kept = 0
        for number in range(16):
            address = 0x300 | number << 10 | PORT_A
            value = tb.random.randrange(1, 255)
            await tb.pc.outb(address, value)
            if number == dip:
                kept = value
            assert await tb.pc.read(PORT_A) == kept
            assert await tb.driven(address) == (kept if number == dip else None)


@numbered_test("CRD-1")
async def every_register_of_every_number(tb):
    """Only what is readable is ever driven; no write but its own reaches port A."""
    for dip in range(16):
        await tb.number(dip)
        kept = 0
        for register in range(32):
            name = f"{register:02X}"
            value = PPI_SETUP if register == PPI_CONTROL else tb.random.randrange(1, 255)
            await tb.pc.write(register, value)
            if register in (PORT_A, PPI_CONTROL):
                kept = value if register == PORT_A else 0
            assert await tb.pc.read(PORT_A) == kept, f"card {dip}, write to {name}"
            read = await tb.driven(tb.pc.base | register)
            assert (read is not None) == (register in READABLE), f"card {dip}, read of {name}"
