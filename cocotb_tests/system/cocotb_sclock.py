# SPDX-License-Identifier: Apache-2.0
"""The servo clock at every clock rate and jumper of the system clock. §4.3.4"""

import cocotb
from cocotb.triggers import FallingEdge, ReadOnly, RisingEdge, Timer

from cocotb_tests.lib.req import test, tests_on
from cocotb_tests.lib.tb import (
    ADC_LO,
    B_INDEX,
    B_REAL_ENC,
    B_SCLOCK,
    C_DONE,
    LATCH,
    PCCSR,
    PORT_B,
    PORT_C,
    Machine,
)
from cocotb_tests.system.cocotb_jumpers import VARIANTS as JUMPERS
from cocotb_tests.system.machine import SINGLE

TOPLEVEL = "mmcs"
VARIANTS = {
    "8MHz": SINGLE,
    "16MHz-clk4": JUMPERS["mismatch"],
    "48MHz-clk1": {"ClkHz": 48_000_000, "SysClkMHz": 1, **SINGLE},
}
machine_test = tests_on(Machine)


def tick_ps(tb: Machine) -> float:
    """One period of the system clock, as the design makes it from clk_i."""
    mhz = tb.parameters.get("SysClkMHz", 8)
    return tb.clk_hz // 1_000_000 // mhz * tb.period


async def period(tb: Machine, times: int = 3) -> tuple[float, float]:
    """SCLOCK's period and low time in ps, equal over several."""
    seen = set()
    await RisingEdge(tb.dut.sclock_o)
    for _ in range(times):
        start = tb.now()
        await FallingEdge(tb.dut.sclock_o)
        low = tb.now()
        await RisingEdge(tb.dut.sclock_o)
        seen.add((tb.now() - start, tb.now() - low))
    assert len(seen) == 1, f"SCLOCK jitters: {seen}"
    return seen.pop()


@machine_test("PIT-2", "LED-1")
@cocotb.parametrize(
    (("n0", "n1", "mode"), [(2, 2, 2), (8, 10, 2), (5, 7, 2), (4, 6, 3), (3, 5, 3), (250, 2, 2)])
)
async def sclock_period(tb, n0, n1, mode):
    """N0 x N1 ticks of the system clock, timers 0 and 1 in cascade."""
    await tb.sclock(n0, n1, mode)
    whole, low = await period(tb)
    tick = tick_ps(tb)
    assert whole == n0 * n1 * tick
    assert low == n0 * (1 if mode == 2 else n1 // 2) * tick


@machine_test("PIT-2", "JMP-1")
async def sclock_is_on_its_own_line(dut, tb):
    """Of the three DRQ lines it has one; the others are low."""
    await tb.sclock(5, 4)
    seen = set()
    for _ in range(3 * 5 * 4):
        await Timer(tick_ps(tb), "ps")
        await ReadOnly()
        seen.add((int(dut.pcx_drq_o.value), int(dut.sclock_o.value)))
    assert seen == {(0, 0), (4, 1)}


@machine_test("PIT-2")
async def sclock_stands_until_programmed_and_after_mode_0(dut, tb):
    before = int(dut.sclock_o.value)
    await Timer(20, "us")
    assert int(dut.sclock_o.value) == before
    await tb.sclock(4, 4)
    await period(tb, 1)
    await tb.wr(0x407, 0x70)
    assert int(dut.sclock_o.value) == 0
    await Timer(20, "us")
    assert int(dut.sclock_o.value) == 0


@machine_test("PIT-2")
async def timer_2_counts_sclocks(dut, tb):
    await tb.timer(2, 0)
    n1 = max(10, int(30e6 / tick_ps(tb)) // 8)  # 30 us or so: longer than the reads
    await tb.sclock(8, n1)
    for _ in range(3):
        await FallingEdge(dut.sclock_o)
    first = await tb.timer_value(2)
    for n in range(1, 6):
        await FallingEdge(dut.sclock_o)
        assert (first - await tb.timer_value(2)) & 0xFFFF == n


@machine_test("PCB-1", "ADC-1", setup=True)
async def command_and_conversion_are_real_time(tb):
    """Whatever clk_i and CLK: 500 ns of command, 25 us of conversion."""
    monitor = tb.pc_monitor(setup_ns=124)
    await tb.crd(0, ADC_LO)
    await tb.cwr(0, LATCH, 0)
    start = tb.now()
    assert not await tb.crd(0, PORT_C) & C_DONE
    while not await tb.crd(0, PORT_C) & C_DONE:
        pass
    took = (tb.now() - start) / 1e6
    assert 23.0 < took < 28.0, f"a conversion took about {took} us"
    slack = 2e-3 * tb.period
    for cycle in monitor.cycles:
        assert 499 <= cycle.command <= 501 + slack, f"command {cycle.command} ns"
        assert cycle.setup >= 124


@machine_test("ENC-1", "PCB-1", setup=True)
async def encoder_sampling_follows_clk(tb):
    """Two CLK periods per count are followed exactly, at every rate of CLK."""
    await tb.cwr(0, 1, B_REAL_ENC | B_SCLOCK)
    await tb.preset(0, 0)
    await tb.enc[0].move(300, 2 * tick_ps(tb) / 1000)
    await tb.enc[0].move(-20, 2 * tick_ps(tb) / 1000)
    await Timer(round(10 * tick_ps(tb)), "ps")
    assert await tb.encoder(0) == 280


@machine_test("CAL-1", setup=True)
async def index_latches_its_own_count(tb):
    """Two CLK periods per count, either way, at every rate of CLK."""
    tb.enc[0].lines = 5  # an index every 20 counts
    await tb.enc[0].move(6, 300)
    for first, last in ((6, 34), (34, 6)):
        await tb.cwr(0, PORT_B, B_REAL_ENC)
        await tb.preset(0, first)
        await tb.cwr(0, PORT_B, B_REAL_ENC | B_INDEX)
        await Timer(2 + 2 * tb.random.randrange(tb.period), "ps")
        await tb.enc[0].move(last - first, 2 * tick_ps(tb) / 1000)
        await Timer(round(10 * tick_ps(tb)), "ps")
        assert [await tb.encoder(0), await tb.encoder(0)] == [20, last]


@machine_test("HB-1", setup=True)
async def heartbeat_is_real_time(dut, tb):
    dut.axis_enable_i.value = 1
    await tb.dac(0, 0x800)
    await tb.clocks(5)
    assert not int(dut.panic_o.value)
    await tb.wr(0x11, 0)  # D/A 1, low byte
    written = tb.now()
    await RisingEdge(dut.panic_o)
    took = (tb.now() - written) / 1e6
    assert abs(took - tb.parameters["HeartbeatUs"]) < 2, f"{took} us"


@test("VME-3", "CSR-1")
async def registers_at_this_rate(dut):
    tb = await Machine(dut, skew=80).start()
    for _ in range(20):
        value = tb.random.getrandbits(5)
        await tb.wr(PCCSR, value)
        assert await tb.rd(PCCSR) == value
