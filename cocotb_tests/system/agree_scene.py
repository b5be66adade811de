# SPDX-License-Identifier: Apache-2.0
"""Random traffic on the whole machine with every output written down on every clock. §4, §5

Not a test by itself: test_simulators_agree.py runs it on both simulators and compares.
"""

from pathlib import Path

import cocotb
from cocotb.triggers import FallingEdge, Timer
from cocotbext.vme import VmeTiming

from cocotb_tests.lib.tb import (
    ADC_HI,
    ARMED,
    BASE,
    LATCH_ALL,
    PCCSR,
    PORT_B,
    PORT_C,
    SCLOCK_IRQ,
    Machine,
)

CLOCKS = 12_000
FILE = "outputs.txt"


async def write_down(dut) -> None:
    pins = [h for h in dut if h._name.endswith(("_o", "_no"))]
    pins.sort(key=lambda h: h._name)
    with Path(FILE).open("w") as out:
        print(*(h._name for h in pins), file=out)
        for _ in range(CLOCKS):
            await FallingEdge(dut.clk_i)
            await Timer(13, "ps")  # an instant at which no input changes
            print(*(h.value for h in pins), file=out)


@cocotb.test()
async def random_traffic(dut):
    # a master that gives up a cycle leaves the slave two clocks to see it
    tb = Machine(dut, skew=30, timing=VmeTiming(ds_high=300))
    # A strobe in the very instant of a clock edge is taken or not, as in life. The master's times
    # are whole nanoseconds after clock edges: this period is no fraction of any of them.
    tb.period += 2
    await tb.start(setup=True, beat=True)
    watch = cocotb.start_soon(write_down(dut))
    for axis, source in enumerate(tb.enc):
        cocotb.start_soon(source.move((-1) ** axis * 2000, 700 + 90 * axis))
    tb.inputs([3000 * n - 8000 for n in range(2 * tb.cards)])
    await tb.sclock(8, 90)
    await tb.wr(PCCSR, ARMED | SCLOCK_IRQ | BASE)
    while not watch.done():
        kind, axis = tb.random.randrange(9), tb.random.randrange(2 * tb.cards)
        card = axis // 2
        if kind == 0:
            await tb.dac(axis, tb.random.getrandbits(12))
        elif kind == 1:
            await tb.encoder(axis)
        elif kind == 2:
            await tb.preset(axis, tb.random.getrandbits(16))
        elif kind == 3:
            await tb.crd(card, tb.random.choice((PORT_C, ADC_HI, LATCH_ALL)))
        elif kind == 4:
            await tb.cwr(card, PORT_B, 7 | tb.random.choice((0, 8, 16)))
        elif kind == 5:
            await tb.timer_value(tb.random.randrange(3))
        elif kind == 6:
            await tb.vme.init_iack(tb.random.choice((4, 5)), withdraw_ns=1500).wait()
        elif kind == 7:
            await tb.vme.init_read(0x6000 | tb.random.getrandbits(11), withdraw_ns=900).wait()
        else:
            await tb.wr(PCCSR, BASE)
            await tb.wr(PCCSR, ARMED | SCLOCK_IRQ | BASE)
        dut.estop_closed_i.value = tb.random.random() > 0.02
    await watch
