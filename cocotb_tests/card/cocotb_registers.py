# SPDX-License-Identifier: Apache-2.0
"""The card's address, its registers and ports, lights, power; random traffic. §5.3.1, §5.4.2"""

from cocotb.triggers import ClockCycles

from cocotb_tests.card import host
from cocotb_tests.card.host import card_test, rack_test, slot_test
from cocotb_tests.lib.tb import (
    C_BEAT1,
    C_DONE,
    DAC1,
    LATCH,
    LATCH_ALL,
    PORT_A,
    PORT_B,
    PORT_C,
    PPI_CONTROL,
    PPI_SETUP,
    QUAD,
    RUN,
)

TOPLEVEL, VARIANTS = host.TOPLEVEL, host.VARIANTS


@slot_test("CRD-1", "CRD-2")
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
    for register in (LATCH, LATCH_ALL):
        await tb.pc.inb(tb.pc.base | register, aen=1)
        assert await tb.pc.read(PORT_C) & C_DONE, "a latch starts a conversion"


@card_test("CRD-1", "PPI-1")
async def every_register(tb):
    """What each of the 32 offsets reads; holes and write-only ones are 0xFF."""
    card = tb.cards - 1
    await tb.relay()
    await tb.preset(2 * card, 0x1234)
    await tb.preset(2 * card + 1, 0x5678)
    tb.inputs([0x1230, 0x4560] * tb.cards)
    await tb.cwr(card, LATCH, 0)
    await tb.converted()
    expected = {0: QUAD, 1: RUN, 2: 0xF0, 4: 0x12, 5: 0x34, 6: 0x56, 7: 0x78}
    expected |= {0x0C: 0x23, 0x0D: 0x56, 0x0E: 0xC9}
    for register in range(32):
        if register not in (LATCH, LATCH_ALL):
            value = await tb.crd(card, register)
            assert value == expected.get(register, 0xFF), f"offset {register:02X}: {value:02X}"


@slot_test("PPI-1")
async def reset_drv_makes_ports_inputs(dut, tb):
    """RESET DRV: safe board, counters 0; D/A and one-shot untouched. The mode word clears ports."""
    await tb.relay()
    await tb.preset(0, 77)
    await tb.dac(0, 0xC00)
    assert tb.volts(0) == 0x4000
    dut.pc_reset_drv_i.value = 1
    await tb.us(2)
    dut.pc_reset_drv_i.value = 0
    await ClockCycles(dut.clk_i, 2)
    assert tb.led(0, "beat1") == 1
    assert tb.volts(0) == 0
    for a, b in ((0x55, RUN), (0x3C, 0x60)):
        await tb.pc.write(PORT_A, a)
        await tb.pc.write(PORT_B, b)
        await tb.pc.write(PPI_CONTROL, PPI_SETUP)
        assert await tb.pc.read(PORT_A) == 0 and await tb.pc.read(PORT_B) == 0
        assert await tb.pc.read(PORT_C) & 0xE0 == 0xE0
    await tb.pc.write(PORT_B, RUN)
    await tb.relay()
    assert tb.volts(0) == 0x4000
    assert await tb.encoder(0) == 0


@rack_test("LED-2")
async def card_leds(dut, tb):
    """Every LED follows its signal, on its own card only."""
    assert all(tb.led(c, "power") for c in range(3))
    for axis in range(6):
        card, joint = axis // 2, axis % 2 + 1
        for name, pins in (("a", tb.enc[axis].a), ("b", tb.enc[axis].b), ("i", tb.enc[axis].i)):
            for level in (1, 0):
                before = int(dut.card_leds_o.value)
                pins.set(axis, level)
                await tb.us(1)
                assert tb.led(card, f"{name}{joint}") == level
                assert bin(before ^ int(dut.card_leds_o.value)).count("1") == level or not level
    for card in range(3):
        for name, bit in (("gp1", 3), ("gp2", 4)):
            await tb.cwr(card, PORT_A, QUAD | 1 << bit)
            lit = [(c, n) for c in range(3) for n in ("gp1", "gp2") if tb.led(c, n)]
            assert lit == [(card, name)]
            await tb.cwr(card, PORT_A, QUAD)


@rack_test("HB-1", "LED-2")
async def heartbeat_leds_and_port_c(tb):
    """Writing a D/A low byte starts that axis's heartbeat; the high nibble does not."""
    for axis in range(6):
        card, joint = axis // 2, axis % 2
        await tb.cwr(card, DAC1 + 2 * joint + 1, 8)
        assert not await tb.crd(card, PORT_C) & C_BEAT1 << 2 * joint
        await tb.cwr(card, DAC1 + 2 * joint, 0)
        assert await tb.crd(card, PORT_C) & C_BEAT1 << 2 * joint
        assert tb.led(card, f"beat{joint + 1}")
    await tb.us(420)
    assert [await tb.crd(c, PORT_C) & 5 for c in range(3)] == [0, 0, 0]
    assert not any(tb.led(c, f"beat{j}") for c in range(3) for j in (1, 2))


@card_test("CRD-1", "CRD-2", "MAP-1", "DAC-1", "ENC-1", "ANA-1")
async def random_traffic(tb):
    """400 random accesses against a model of all ports, D/As and encoders."""
    await tb.relay()
    ports = [QUAD] * tb.cards
    low, volts, counts = ([0 for _ in tb.axes()] for _ in range(3))
    for axis in tb.axes():
        await tb.preset(axis, 0)
        await tb.dac(axis, 0x800)
    compared = 0
    for _ in range(400):
        axis, value = tb.random.choice(tb.axes()), tb.random.getrandbits(8)
        card, joint = axis // 2, axis % 2
        kind = tb.random.randrange(7)
        if kind == 0:
            ports[card] = QUAD | value & 0xF8
            await tb.cwr(card, PORT_A, ports[card])
        elif kind == 1:
            await tb.cwr(card, DAC1 + 2 * joint, value)
            low[axis] = value
        elif kind == 2:
            await tb.cwr(card, DAC1 + 2 * joint + 1, value)
            volts[axis] = (((value & 15) << 8 | low[axis]) - 0x800) * 16
        elif kind == 3:
            counts[axis] = value << 8 | value ^ 0x5A
            await tb.preset(axis, counts[axis])
        elif kind == 4:
            move = tb.random.choice((-3, -1, 1, 2, 7))
            await tb.enc[axis].move(move, host.NS_PER_COUNT)
            await tb.us(0.5)
            counts[axis] = (counts[axis] + move) & 0xFFFF
        elif kind == 5:
            assert await tb.crd(card, PORT_A) == ports[card]
            compared += 1
        else:
            assert await tb.encoder(axis) == counts[axis]
            compared += 1
        assert tb.drives() == volts
    assert compared > 80
    assert await tb.counts() == counts
    assert [await tb.crd(card, PORT_A) for card in range(tb.cards)] == ports
