# SPDX-License-Identifier: Apache-2.0
"""The adaptor's five functions behind the host port of its core. §4.2.1, §4.3.8"""

import cocotb
from cocotb.triggers import FallingEdge, RisingEdge, Timer
from cocotbext.pcbus import PcBus, PcBusSlave

from cocotb_tests.adaptor.fronts import HostPort
from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import PCCSR, VECTOR

TOPLEVEL = "adaptor_core"
VARIANTS = {
    "8MHz": {},
    "slow-bus": {"ClkHz": 16_000_000, "SysClkMHz": 2, "CmdNs": 1000, "IochrdyLimitClks": 3},
}


port_test = tests_on(HostPort)
usual_test = tests_on(HostPort, "8MHz")


@port_test("ADP-1", "VME-5", "CSR-1")
async def own_registers(dut, tb):
    """PCCSR and vector by the port alone; every other offset of the upper half reads 0xFF."""
    assert int(dut.vector_o.value) == 0x0F
    for value in (0x00, 0x1F, 0x98, 0xA5):
        await tb.wr(VECTOR, value)
        assert int(dut.vector_o.value) == value
        await tb.wr(PCCSR, value)
        assert await tb.rd(PCCSR) == value & 0x9F
    await tb.wr(PCCSR, 0)
    for offset in range(0x401, 0x800, 2):
        low = offset & 0x7F
        if low >= 0x10:
            assert await tb.rd(offset) == 0xFF, f"{offset:03X}"
    assert int(dut.vector_o.value) == 0xA5


@port_test("ADP-1", "MAP-1", "VME-4")
async def own_accesses_become_pc_cycles(dut, tb):
    """Every address of the lower half, at random bases; the cards take their time."""
    bus, seen, expected = PcBus.from_prefix(dut, "pc"), [], []

    def on_read(address: int) -> int:
        seen.append(address)
        return address >> 3 & 0xFF

    PcBusSlave(bus, base=0, size=1 << 14, on_read=on_read, access_ns=(0, 300), wait_ns=(0, 900))
    base = None
    for n, offset in enumerate(tb.random.sample(range(1, 0x400, 2), 256)):
        if n % 16 == 0:
            base = tb.random.randrange(32)
            await tb.wr(PCCSR, base)
        address = (offset >> 1 & 0x1F) | base << 5 | (offset >> 6 & 15) << 10
        expected.append(address)
        assert await tb.rd(offset) == address >> 3 & 0xFF
    assert seen == expected


@port_test("ADP-1")
async def answer_stays_until_the_next(dut, tb):
    """Of the adaptor's own registers and of the PC bus; reset leaves 0xFF."""
    await tb.wr(PCCSR, 0x15)
    for offset, value in ((PCCSR, 0x15), (0x011, 0x6A), (PCCSR, 0x15)):
        dut.pc_d_i.value = value
        assert await tb.rd(offset) == value
        dut.pc_d_i.value = 0xFF
        await tb.clocks(20)
        assert int(dut.hp_rdata_o.value) == value
    dut.rst_ni.value = 0
    await tb.clocks(2)
    dut.rst_ni.value = 1
    await tb.clocks(2)
    assert int(dut.hp_rdata_o.value) == 0xFF


@port_test("PCB-1", "ADP-1")
async def cycle_timing(dut, tb):
    """Address a full clock before the command, command as long as set, data held past it."""
    side = 125_000
    command = tb.parameters.get("CmdNs", 500) * 1000
    for n in range(6):
        write = n % 2 == 0
        strobe = dut.pc_iow_no if write else dut.pc_ior_no
        other = dut.pc_ior_no if write else dut.pc_iow_no
        task = cocotb.start_soon(tb.access(0x005 + 2 * n, 0xA0 + n if write else None))
        await dut.pc_a_o.value_change
        start = tb.now()
        await FallingEdge(strobe)
        fall = tb.now()
        assert fall - start >= side - 100
        assert not write or int(dut.pc_d_o.value) == 0xA0 + n
        assert int(dut.pc_d_oe_o.value) == write, "the adaptor drives a write's data alone"
        await RisingEdge(strobe)
        rise = tb.now()
        assert tb.clks(rise - fall) == -(-command // tb.period)
        address = int(dut.pc_a_o.value)
        await Timer(side - 2 * tb.period // 10, "ps")
        assert not write or int(dut.pc_d_o.value) == 0xA0 + n, "held past IOW#"
        assert int(dut.pc_d_oe_o.value) == write
        assert int(dut.pc_a_o.value) == address
        assert int(other.value) == 1 and int(dut.pc_aen_o.value) == 0
        await task
        assert not int(dut.pc_d_oe_o.value)


@port_test("PCB-1", "PIT-2")
async def system_clock_of_the_jumper(dut, tb):
    """CLK once a period, from reset on; SCLOCK counts its periods and moves half a period later."""
    div = tb.clk_hz // 1_000_000 // tb.parameters.get("SysClkMHz", 8)
    for before in (1, 2, 5):
        await tb.clocks(before)
        await FallingEdge(dut.clk_i)
        dut.rst_ni.value = 0
        await FallingEdge(dut.clk_i)
        assert int(dut.pc_clk_en_o.value)
        dut.rst_ni.value = 1
        for n in range(1, 4 * div):
            await FallingEdge(dut.clk_i)
            assert int(dut.pc_clk_en_o.value) == int(n % div == 0), f"clock {n} after reset"
    for timer in (0, 1):
        await tb.wr(0x407, timer << 6 | 0x14)  # low byte only, mode 2
        await tb.wr(0x401 + 2 * timer, 2 + timer)
    ticks, edges, last = 0, [], None
    for n in range(60 * div):
        await FallingEdge(dut.clk_i)
        level = int(dut.sclock_o.value)
        ticks = n if int(dut.pc_clk_en_o.value) else ticks
        if last is not None and level != last:
            edges.append((n, level))
            assert n - ticks == (div // 2 + 1) % div, "moves with the falling edge"
        last = level
    lows = [b - a for (a, at), (b, _) in zip(edges, edges[1:], strict=False) if not at]
    highs = [b - a for (a, at), (b, _) in zip(edges, edges[1:], strict=False) if at]
    assert len(highs) > 6 and set(lows) == {2 * div}, f"{lows}"
    assert set(highs[1:]) == {4 * div}, f"{highs}"


@port_test("PCB-1")
async def read_data_is_sampled_at_the_end(dut, tb):
    """What stands on the bus when IOR# rises counts, not what stood before."""
    for last in (0x12, 0xED):
        task = cocotb.start_soon(tb.access(0x011))
        await FallingEdge(dut.pc_ior_no)
        dut.pc_d_i.value = 0x77
        await Timer(tb.parameters.get("CmdNs", 500) - 200, "ns")
        dut.pc_d_i.value = last
        await RisingEdge(dut.pc_ior_no)
        dut.pc_d_i.value = 0x00
        assert await task == last


@port_test("PCB-1", "PCB-2")
async def iochrdy(dut, tb):
    """Extends by what it lasts; past the limit the cycle ends, reads 0xFF, and the next works."""
    dut.pc_d_i.value = 0x5A
    tick = 8_000_000 // (tb.parameters.get("SysClkMHz", 8) * 1_000_000) * 125
    limit = tb.parameters.get("IochrdyLimitClks", 10)
    command = tb.parameters.get("CmdNs", 500)
    for ticks in (0, 1, 2, limit - 1, limit + 4, 1000):
        task = cocotb.start_soon(tb.access(0x021))
        await FallingEdge(dut.pc_ior_no)
        start = tb.now()
        if ticks:
            dut.pc_wait_i.value = 1

            async def release(ns=command + ticks * tick):
                await Timer(ns - 60, "ns")
                dut.pc_wait_i.value = 0

            free = cocotb.start_soon(release())
        await RisingEdge(dut.pc_ior_no)
        length = (tb.now() - start) / 1000
        data = await task
        if ticks < limit:
            assert data == 0x5A
            assert command + ticks * tick - 130 <= length <= command + (ticks + 1) * tick + 130
        else:
            assert data == 0xFF
            # a slower clock is in the midst of a period when the waiting begins
            least = command + limit * tick - (tick if tick * 1000 > tb.period else 0)
            assert least - 1 <= length <= command + (limit + 1) * tick + 130
        if ticks:
            free.cancel()
        dut.pc_wait_i.value = 0
        assert await tb.rd(0x021) == 0x5A


@port_test("PAN-1", "PAN-2", "ADP-1")
async def safety_by_the_port(dut, tb):
    """Each of button, cable and power alone; without a link the PC bus reads 0xFF at full speed."""
    await tb.us(2)
    dut.pc_d_i.value = 0x33
    assert not int(dut.panic_o.value) and int(dut.brake_release_o.value)
    await tb.clocks(1)
    assert await tb.rd(0x001) == 0x33
    full_speed = tb.took
    for pin in (dut.estop_closed_i, dut.cable_ok_i, dut.pc_power_i):
        pin.value = 0
        await tb.clocks(5)
        assert int(dut.panic_o.value) and not int(dut.brake_release_o.value)
        linked = pin is dut.estop_closed_i
        dut.pc_wait_i.value = int(not linked)  # a dead card cannot hold the bus
        assert await tb.rd(0x001) == (0x33 if linked else 0xFF)
        assert tb.took == full_speed
        dut.pc_wait_i.value = 0
        assert await tb.rd(PCCSR) == 0
        await FallingEdge(dut.clk_i)
        pin.value = 1
        # What the pin set is cleared, two flip-flops, four clocks of health, and PANIC.
        for clocks_left in (7, 6, 5, 4, 3, 2, 1, 0):
            await FallingEdge(dut.clk_i)
            assert int(dut.panic_o.value) == (clocks_left > 0)
        await tb.us(60)
        assert not int(dut.panic_o.value)


@port_test("ADP-1", "PIT-1", "PIT-2")
async def timers_by_the_port(tb):
    """Latched reads of a running timer go down by the time that passed."""
    mhz = tb.parameters.get("SysClkMHz", 8)
    await tb.timer(0, 0)
    values = []
    for _ in range(4):
        await tb.wr(0x407, 0x00)
        at = tb.now()
        low = await tb.rd(0x401)
        values.append((at, low | await tb.rd(0x401) << 8))
        await tb.us(25)
    for (t0, v0), (t1, v1) in zip(values, values[1:], strict=False):
        ticks = (t1 - t0) / 1e6 * mhz
        assert abs(((v0 - v1) & 0xFFFF) - ticks) <= 1


@port_test("PIT-1", "PIT-2")
async def a_count_is_loaded_by_a_whole_pulse(dut, tb):
    """Timer 1, written while its clock OUT0 is high: the next fall is of a pulse that began before,
    the second one loads, the third one ends a count of 1."""
    await tb.wr(0x407, 0x14)  # timer 0, mode 2: OUT0 rises
    await tb.wr(0x407, 0x50)  # timer 1, low byte, mode 0: SCLOCK falls
    await tb.wr(0x403, 1)
    for ended in (False, False, True):
        await tb.wr(0x407, 0x10)  # timer 0, mode 0: OUT0 falls
        await tb.clocks(4)
        assert bool(int(dut.sclock_o.value)) == ended
        await tb.wr(0x407, 0x14)


@port_test("ADP-1")
async def random_requests(dut, tb):
    """A long mix at random gaps: each request gets exactly one answer, the right one."""
    answers = 0

    async def count():
        nonlocal answers
        while True:
            await FallingEdge(dut.clk_i)
            answers += int(dut.hp_ack_o.value)

    cocotb.start_soon(count())
    pccsr, requests = 0, 0
    dut.pc_d_i.value = 0x6B
    for _ in range(120):
        kind = tb.random.randrange(4)
        requests += 1
        if kind == 0:
            pccsr = tb.random.getrandbits(8)
            await tb.wr(PCCSR, pccsr)
        elif kind == 1:
            assert await tb.rd(PCCSR) & 0x9F == pccsr & 0x9F
        elif kind == 2:
            assert await tb.rd(tb.random.randrange(0x200) << 1 | 1) == 0x6B
        else:
            await tb.wr(tb.random.randrange(0x200) << 1 | 1, 0)
        await tb.clocks(tb.random.randrange(4))
    assert answers == requests


@usual_test("PCB-1", "CSR-1")
async def reset_drv_stands_from_power_on(dut, tb):
    """It is high while the power-on reset is, and until SYSRESET* has ended."""
    dut.sys_reset_i.value = 1
    dut.rst_ni.value = 0
    await Timer(10, "ns")
    assert int(dut.pc_reset_drv_o.value)
    for pin, value in ((dut.rst_ni, 1), (dut.sys_reset_i, 0)):
        for _ in range(30):
            await FallingEdge(dut.clk_i)
            assert int(dut.pc_reset_drv_o.value)
        pin.value = value
    await tb.clocks(4)
    assert not int(dut.pc_reset_drv_o.value)


@usual_test("PCB-1", "PAN-2")
@cocotb.parametrize(what=["cable", "power"])
async def a_link_that_is_gone_moves_nothing(dut, tb, what):
    """Whatever the host does, SCLOCK high, SYSRESET* low: no command, data, DRQ; without the cable
    no CLK and no RESET DRV either."""
    pin = {"cable": dut.cable_ok_i, "power": dut.pc_power_i}[what]
    lines = {dut.pc_ior_no: 1, dut.pc_iow_no: 1, dut.pc_d_oe_o: 0, dut.pc_drq_o: 0}
    if what == "cable":
        lines |= {dut.pc_clk_en_o: 0, dut.pc_reset_drv_o: 0}
    for mode in (0x70, 0x74):  # SCLOCK low, then high
        await tb.wr(0x407, mode)
    moved = set()

    async def watch():
        while True:
            await FallingEdge(dut.clk_i)
            moved.update(line._name for line, idle in lines.items() if int(line.value) != idle)

    watching = cocotb.start_soon(watch())
    for linked in (True, False):
        pin.value = int(linked)
        await tb.clocks(2)  # two flip-flops
        moved.clear()
        for offset in (0x001, 0x011):
            await tb.wr(offset, 0x55)
            await tb.rd(offset)
        dut.sys_reset_i.value = 1
        await tb.us(3)
        dut.sys_reset_i.value = 0
        await tb.clocks(4)
        assert moved == ({line._name for line in lines} if linked else set())
    watching.cancel()


@usual_test("PCB-1", "PAN-2")
async def cable_that_bounces_in_a_command(dut, tb):
    """Out and back at any clock of an access: one command at most, and what is cut reads 0xFF."""
    await tb.us(60)
    dut.pc_d_i.value = 0x33
    commands = cut = 0
    for write in (1, 0):
        strobe = dut.pc_iow_no if write else dut.pc_ior_no
        for begin in range(10):
            for length in (1, 2, 3, 5):
                task = cocotb.start_soon(tb.access(0x001, 0x77 if write else None))
                falls, before, low = 0, 1, 0
                for n in range(16):
                    await FallingEdge(dut.clk_i)
                    falls += before and not int(strobe.value)
                    before = int(strobe.value)
                    low += not before
                    out = begin + 2 <= n < begin + 2 + length  # synchronised
                    assert before or not out, "a command without a link"
                    dut.cable_ok_i.value = int(not begin <= n < begin + length)
                assert falls <= 1, f"{falls} commands, cable out in clock {begin} for {length}"
                assert await task == (0xFF if write or low < 4 else 0x33)
                commands += falls
                cut += low < 4
                await tb.clocks(8)
    assert commands >= 40 and cut >= 20
