# SPDX-License-Identifier: Apache-2.0
"""A third-party card on the expansion connector, reached through another PCCSR base. §4.2.2"""

from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import ARMED, BASE, HEALTH_CLKS, PANIC_IRQ, PCCSR, PORT_A, QUAD, Machine

TOPLEVEL = "bench_expansion"
SOURCES = ["dio_card.sv", "bench_expansion.sv"]
DIO_BASE = 0x2A0 >> 5  # what PCCSR bits 4-0 must be
OUT, IN, CONTROL, IDENTITY = (n << 1 | 1 for n in range(4))  # VME offsets, A09-A06 = 0
LIMIT = 10


async def machine(dut) -> Machine:
    tb = await Machine(dut).start()
    await tb.setup(0)
    await tb.wr(PCCSR, DIO_BASE)
    return tb


machine_test = tests_on(machine)


@machine_test("PCB-2", "MAP-1")
async def registers_of_the_card(dut, tb):
    assert await tb.rd(IDENTITY) == 0xD1
    for value in (0x00, 0x5A, 0xFF):
        await tb.wr(OUT, value)
        assert int(dut.dio_o.value) == value and await tb.rd(OUT) == value
        dut.dio_i.value = value ^ 0x3C
        await tb.clocks(2)
        assert await tb.rd(IN) == value ^ 0x3C


@machine_test("PCB-2", "CRD-1")
async def the_bases_do_not_meet(dut, tb):
    """At the cards' base the card is silent, at its own the Mark I card is."""
    await tb.wr(OUT, 0x77)
    await tb.wr(PCCSR, BASE)
    assert await tb.crd(0, PORT_A) == QUAD
    await tb.cwr(0, PORT_A, 0x1D)
    assert int(dut.dio_o.value) == 0x77
    for base in range(32):
        await tb.wr(PCCSR, base)
        expected = {DIO_BASE: 0xD1}.get(base, 0xFF)
        assert await tb.rd(IDENTITY) == expected
    await tb.wr(PCCSR, BASE)
    assert await tb.crd(0, PORT_A) == 0x1D


@machine_test("PCB-1", "PCB-2", "VME-4")
async def wait_states(tb):
    """IOCHRDY stretches reads and writes by whole CLKs and is given up at the limit."""
    monitor = tb.pc_monitor()
    lengths = []
    for waits in range(16):
        await tb.wr(CONTROL, waits)
        monitor.cycles.clear()
        await tb.wr(OUT, 0xA0 + waits)
        value = await tb.rd(OUT)
        write, read = monitor.cycles
        lengths.append(read.command)
        assert write.command == read.command
        # four CLKs of command and ten of patience; one either way is the bus's own business
        if abs(waits - 4 - LIMIT) > 1:
            assert value == (0xFF if waits > 4 + LIMIT else 0xA0 + waits)
        assert read.command >= min(waits * 125, 500)
    assert lengths == sorted(lengths) and lengths[0] == 500 and lengths[12] > lengths[6]
    await tb.wr(CONTROL, 0)


@machine_test("PCB-2", "PAN-1")
async def its_interrupt_line(dut, tb):
    """The example sits on IRQ7, the PANIC line: a card may panic too (wired OR)."""
    dut.axis_enable_i.value = 0
    await tb.wr(CONTROL, 0x80)
    await tb.wr(PCCSR, ARMED | PANIC_IRQ | DIO_BASE)
    assert not int(dut.panic_o.value)
    dut.dio_i.value = 0x80
    await tb.clocks(5)
    assert int(dut.panic_o.value)
    assert await tb.rd(PCCSR) == ARMED | PANIC_IRQ | DIO_BASE
    dut.dio_i.value = 0
    await tb.clocks(HEALTH_CLKS)
    assert not int(dut.panic_o.value)


@machine_test("PCB-1", "PCB-2")
async def reset_drv_reaches_it(dut, tb):
    await tb.wr(OUT, 0x99)
    dut.vme_sysreset_ni.value = 0
    await tb.us(2)
    dut.vme_sysreset_ni.value = 1
    await tb.us(1)
    assert int(dut.dio_o.value) == 0


@machine_test("PCB-2", "VME-3")
async def mixed_traffic(dut, tb):
    """Both cards in turn, with wait states: neither disturbs the other."""
    out, port = 0, QUAD
    for _ in range(60):
        value = tb.random.getrandbits(8)
        if tb.random.randrange(2):
            await tb.wr(PCCSR, DIO_BASE)
            await tb.wr(CONTROL, tb.random.randrange(12))
            assert await tb.rd(OUT) == out
            await tb.wr(OUT, value)
            out = value
        else:
            await tb.wr(PCCSR, BASE)
            assert await tb.crd(0, PORT_A) == port
            await tb.cwr(0, PORT_A, value)
            port = value
    assert int(dut.dio_o.value) == out
