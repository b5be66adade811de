# SPDX-License-Identifier: Apache-2.0
# Length: many short cases of one block, read one at a time.
"""VME as the host of the machine: its cycles, and what breaks them. §4.3.1-4.3.3

Every address, size and modifier: system/cocotb_window.py.
"""

import cocotb
from cocotb.triggers import FallingEdge, RisingEdge, Timer
from cocotbext.vme import AM_SUPERVISOR, AM_USER, BusTimeout, VmeMonitor, VmeTiming

from cocotb_tests.lib.play import drive
from cocotb_tests.lib.req import test, tests_on
from cocotb_tests.lib.tb import BASE, PCCSR, PIT, PORT_A, Machine
from cocotb_tests.system.machine import USUAL

TOPLEVEL = "mmcs"
PARAMETERS = USUAL
# A master that breaks a cycle off leaves the slave two clocks to see it.
AFTER_WITHDRAWAL = VmeTiming(ds_high=300)
machine_test = tests_on(Machine)


@machine_test("VME-5", "PIT-1")
async def timer_registers_are_where_they_should_be(tb):
    """0x401, 0x403, 0x405, 0x407, and the same with A09-A07 set."""
    for mirror in (0x000, 0x080, 0x380):
        for n in range(3):
            await tb.wr(mirror | PIT + 6, n << 6 | 0x30)  # mode 0, two bytes
            await tb.wr(mirror | PIT + 6, 0xE0 | 2 << n)  # read back the status alone
            assert await tb.rd(mirror | PIT + 2 * n) & 0x7F == 0x70
        assert await tb.rd(mirror | PIT + 6) == 0xFF


@test("VME-1", "VME-6")
async def address_modifiers(dut):
    """Of the 64 codes only 0x29 and 0x2D are answered."""
    tb = await Machine(dut).start()
    answered = [am for am in range(64) if await tb.vme.answers(0x6409, am=am)]
    assert answered == [AM_USER, AM_SUPERVISOR]
    assert tb.vme.timeouts == 62


@machine_test("VME-2", "VME-6", "API-1")
async def access_sizes(tb):
    """Odd byte and 16 bits are answered; an even byte and LWORD* low are not."""
    for offset in (0x001, 0x0C9, 0x401, 0x409, 0x441, 0x7FF):
        byte = await tb.rd(offset)
        even = 0x6000 | offset - 1
        word = await tb.vme.read(even, size=2)
        assert word >> 8 == 0xFF
        assert word & 0xFF == byte or offset == 0x401, "a counter's bytes alternate"
        for size, address in ((1, even), (4, even & ~3)):
            for op in (tb.vme.init_read(address, size), tb.vme.init_write(address, 0, size)):
                await op.wait()
                assert isinstance(op.error, BusTimeout), f"size {size} was answered"
        assert await tb.vme.answers(0x6409)


@machine_test("VME-2")
async def word_write_takes_the_low_byte(tb):
    await tb.vme.write(0x6408, 0xA512, size=2)
    assert await tb.rd(PCCSR) == 0x12
    await tb.vme.write(0x6408, 0x00 | BASE, size=2)
    await tb.setup(1)
    await tb.vme.write(0x6000 | tb.creg(1, PORT_A) - 1, 0x5A0D, size=2)
    assert await tb.crd(1, PORT_A) == 0x0D


@machine_test("VME-4", setup=True)
async def absent_card_reads_ff(tb):
    """Cards 3 to 15 are not there: 0xFF, acknowledged, and nothing else is disturbed."""
    for card in range(3, 16):
        await tb.cwr(card, PORT_A, 0x5A)
        for register in (0, 4, 8, 12, 31):
            assert await tb.crd(card, register) == 0xFF
    assert await tb.crd(0, PORT_A) == 5


@test("VME-3")
@cocotb.parametrize(skew=[0, 20, 90, 250])
async def random_legal_timing(dut, skew):
    """A mixed stream with random skew; every read is checked against a model of the registers."""
    tb = Machine(dut, skew=skew, timing=VmeTiming(ds_skew=10))
    await tb.start(setup=True)
    monitor, before = VmeMonitor(tb.bus, at="master"), tb.vme.count
    model = {(c, r): v for c in range(3) for r, v in ((0, 5), (1, 7))}
    pccsr, reads = BASE, 0
    for _ in range(150):
        kind = tb.random.randrange(6)
        card, register = tb.random.randrange(3), tb.random.randrange(2)
        value = tb.random.getrandbits(8)
        if kind == 0:
            await tb.cwr(card, register, value)
            model[card, register] = value
        elif kind == 1:
            await tb.vme.write(0x6000 | tb.creg(card, register) - 1, value, size=2)
            model[card, register] = value
        elif kind == 2:
            pccsr = tb.random.choice((0x00, 0x80)) | BASE
            await tb.wr(PCCSR, pccsr)
        elif kind == 3:
            assert await tb.rd(PCCSR) & 0x9F == pccsr
            reads += 1
        else:
            assert await tb.crd(card, register) == model[card, register]
            reads += 1
    assert reads > 40
    assert len(monitor.cycles) == tb.vme.count - before
    assert {c.outcome for c in monitor.cycles} == {"DTACK*"}


@machine_test("VME-3")
async def dtack_and_drivers_at_the_end_of_a_read(dut, tb):
    """Drivers off with the strobes, without a clock; DTACK* up one or two clocks later."""
    ends = tb.times(RisingEdge, dut.vme_dtack_no)
    for phase in range(0, 130, 10):  # strobes move through the clock period
        await Timer(phase + 1, "ns")
        ends.clear()
        op = await tb.vme.init_read(0x6409).wait()
        assert op.data == BASE  # the master checked drivers and order
        released = op.end_ns * 1000
        assert len(ends) == 1 and ends[0] <= released
    for release in (0, 30, 62, 100):  # and the rise of DTACK*, counted in clocks
        tb.vme.timing.release = release
        op = tb.vme.init_read(0x6409)
        while int(dut.vme_ds_ni.value) == 0b11:
            await dut.vme_ds_ni.value_change
        while int(dut.vme_ds_ni.value) != 0b11:
            await dut.vme_ds_ni.value_change
        away = tb.now()
        await RisingEdge(dut.vme_dtack_no)
        clocks = (tb.now() - away) / tb.period
        assert 0 < clocks <= 2.01, f"DTACK* rose {clocks} clocks after the strobes"
        await op.wait()


@machine_test("VME-3")
async def no_dtack_without_a_strobe(dut, tb):
    """Address, AS* and WRITE* alone start nothing; DTACK* comes only after DS0*."""
    monitor = tb.pc_monitor()
    answers = tb.times(FallingEdge, dut.vme_dtack_no)
    await drive(tb.bus, f"a={0x6001 >> 1} am={AM_USER} as_n=0 3000 as_n=1 500")
    await drive(tb.bus, "ds_n=2 3000 ds_n=3 500")  # without AS* it is no cycle either
    assert not answers and not monitor.cycles
    assert await tb.rd(PCCSR) == BASE


@machine_test("VME-3", "VME-4", setup=True)
async def master_that_holds_the_strobes(tb):
    """However long the strobes stay, there is one PC cycle, and data and DTACK* stand."""
    monitor = tb.pc_monitor()
    tb.vme.timing.release = 5000
    assert await tb.crd(2, PORT_A) == 5
    await tb.cwr(2, PORT_A, 6)
    assert [c.kind for c in monitor.cycles] == ["read", "write"]


@test("VME-3", "VME-6")
async def withdrawn_and_another_address_at_once(dut):
    """What stands on the bus right after a withdrawn strobe is not answered with the old data."""
    tb = await Machine(dut, timing=AFTER_WITHDRAWAL).start(setup=True)
    await tb.cwr(1, PORT_A, 0x2A)
    for ns in range(20, 1500, 35):
        await tb.vme.init_read(0x6000 | tb.creg(1, PORT_A), withdraw_ns=ns).wait()
        assert await tb.rd(PCCSR) == BASE, f"withdrawn after {ns} ns"
        await tb.vme.init_read(0x6409, withdraw_ns=ns).wait()
        assert await tb.crd(1, PORT_A) == 0x2A


@machine_test("VME-3", setup=True)
async def withdrawn_and_anothers_strobe_at_once(dut, tb):
    """The read that still runs does not drive into a cycle of another board. Found by a proof."""
    for ns in range(400, 1000, 50):
        ours = (0x6000 | tb.creg(0, PORT_A)) >> 1
        await drive(tb.bus, f"a={ours} am={AM_USER} write_n=1 as_n=0 10 ds_n=2 {ns} ds_n=3 as_n=1")
        # one or two clock edges see it
        await drive(tb.bus, "150 am=0x39 as_n=0 ds_n=1")
        for _ in range(40):
            await Timer(20, "ns")
            assert not int(dut.vme_d_oe_o.value), f"withdrawn after {ns} ns"
        await drive(tb.bus, "ds_n=3 as_n=1")
        await tb.clocks(30)
    assert await tb.rd(PCCSR) == BASE


@machine_test("VME-3", setup=True)
async def strobe_glitches(dut, tb):
    """Pulses of a few ns on DS0* leave no trace, wherever they fall in the clock."""
    for step in range(40):
        ours = (0x6000 | tb.creg(0, PORT_A)) >> 1
        await drive(tb.bus, f"a={ours} am={AM_USER} write_n=0 d=0x77 as_n=0 {10 + 13 * step}")
        await drive(tb.bus, "ds_n=2 5 ds_n=3 20 as_n=1 1500")
        assert int(dut.vme_dtack_no.value) == 1
        if step % 8 == 0:
            value = await tb.crd(0, PORT_A)
            assert value in (5, 0x77)  # caught by a clock edge or not: never anything else
            await tb.cwr(0, PORT_A, 5)
    assert await tb.rd(PCCSR) == BASE


@machine_test("VME-3", "PCB-1", setup=True)
async def write_data_is_captured_first(tb):
    """The strobe goes, the data changes before and while IOW# is low: the first is written."""
    monitor = tb.pc_monitor()
    for ns in range(130, 900, 17):
        value = tb.random.getrandbits(8)
        seen = len(monitor.cycles)
        op = tb.vme.init_write(0x6000 | tb.creg(0, PORT_A), value, withdraw_ns=ns)
        await op.wait()
        await Timer(1500, "ns")
        assert [c.data for c in monitor.cycles[seen:]] == [value] * (len(monitor.cycles) - seen)
        assert len(monitor.cycles) == seen + 1 or ns < 500
    assert len(monitor.cycles) > 25


@machine_test("VME-1")
async def iack_cycle_is_no_data_cycle(tb):
    """IACK* low with the slave's address on the bus: no register is touched, nothing answers."""
    monitor = tb.pc_monitor()
    for am in (AM_USER, AM_SUPERVISOR):
        op = tb.vme.init_iack(5)
        op.address, op.am = 0x6409, am
        await op.wait()
        assert isinstance(op.error, BusTimeout)
    assert not monitor.cycles
    assert await tb.rd(PCCSR) == BASE
