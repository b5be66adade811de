# SPDX-License-Identifier: Apache-2.0
"""The card alone at a PC's 4.77 MHz, which is no multiple of a megahertz. §5.3"""

from math import ceil

import cocotb

from cocotb_tests.lib.req import test
from cocotb_tests.lib.tb import DAC1
from cocotb_tests.mark1.cocotb_mark1 import Card

TOPLEVEL = "mark1"
PARAMETERS = {"ClkHz": 4_772_727, "HeartbeatUs": 5_000}


@test("HB-1")
async def the_heartbeat_is_as_long_as_it_says(dut):
    """5 ms to the clock, not 4.19: the rate is not rounded to megahertz."""
    tb = await Card(dut).start()
    dut.axis_enable_i.value = 1
    write = cocotb.start_soon(tb.pc.write(DAC1, 0))
    begin = await tb.led_edge("beat1", 1)
    await write
    end = await tb.led_edge("beat1", 0)
    assert tb.clks(end - begin) == ceil(5e-3 * PARAMETERS["ClkHz"])
