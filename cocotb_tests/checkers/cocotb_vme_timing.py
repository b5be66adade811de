# SPDX-License-Identifier: Apache-2.0
"""Each limit of the VME tables goes red just past it, and holds just at it. §4.3.1"""

import cocotb

from cocotb_tests.checkers.drive import Timed
from cocotb_tests.lib.req import test

TOPLEVEL = "vme_timing"
SOURCES = ("../../rtl/checkers/vme_timing.sv",)
PARAMETERS = {"Stop": 0}
NAMES = [
    "addr_setup", "as_high", "write_setup", "data_setup", "as_to_ds", "ds_skew", "ds_high",
    "addr_hold", "data_hold", "strobe_hold", "next_strobe", "ds_to_dtack", "answer",
    "data_to_dtack", "data_off", "off_to_dtack", "dtack_rise", "iackout_rise", "irq_release",
]  # fmt: skip

# One exact cycle: every time of the table in ns, at its limit where it has one.
TIMES = {
    "setup": 10,
    "as_to_ds": 0,
    "ds_skew": 20,
    "ds_to_dtack": 30,
    "data_to_dtack": 0,
    "strobe_hold": 0,
    "data_off": 0,
    "off_to_dtack": 0,
    "high": 30,  # AS* and DS* between cycles
}


class Bus(Timed):
    async def cycle(self, address=0x3204, write=False, **times):
        """One cycle with both strobes, then the pause to the next."""
        t = TIMES | times
        # each cycle moves every line that has a set-up time
        self.put(vme_a_i=address, vme_write_ni=0 if write else 1, vme_d_i=address & 0xFF)
        await self.after(t["setup"])
        if t["as_to_ds"] < 0:
            self.put(vme_ds_ni=2)
            await self.after(-t["as_to_ds"], vme_as_ni=0)
        else:
            self.put(vme_as_ni=0)
            await self.after(t["as_to_ds"], vme_ds_ni=2)
        await self.after(t["ds_skew"], vme_ds_ni=0)
        if not write:
            wait = t["ds_to_dtack"] - t["ds_skew"] - t["data_to_dtack"]
            await self.after(wait, vme_d_oe_o=1, vme_d_o=0x5A)
            await self.after(t["data_to_dtack"], vme_dtack_no=0)
        else:
            await self.after(t["ds_to_dtack"] - t["ds_skew"], vme_dtack_no=0)
        await self.after(max(t["strobe_hold"], 1), vme_as_ni=1, vme_ds_ni=3)
        await self.after(t["data_off"], vme_d_oe_o=0)
        await self.after(max(t["off_to_dtack"], 1), vme_dtack_no=1)
        await self.after(t["high"] - 1 - t["setup"] - t["data_off"])


async def good(b):
    for n in range(4):
        await b.cycle(0x3204 + n, write=bool(n & 1))


async def addr_setup(b):
    await b.cycle()
    b.put(vme_write_ni=1)
    await b.after(20)
    await b.after(1, vme_a_i=0x3300)
    await b.after(9.9, vme_as_ni=0)
    await b.after(1, vme_as_ni=1)


async def as_high(b):
    await b.cycle()
    await b.after(40, vme_as_ni=0)
    await b.after(50, vme_as_ni=1)
    await b.after(29.9, vme_as_ni=0)


async def write_setup(b):
    await b.cycle()
    await b.after(100, vme_as_ni=0)
    await b.after(20, vme_write_ni=0)
    await b.after(9.9, vme_ds_ni=2)


async def data_setup(b):
    await b.cycle()
    await b.after(100, vme_as_ni=0, vme_write_ni=0)
    await b.after(20, vme_d_i=0x77)
    await b.after(9.9, vme_ds_ni=2)


async def as_to_ds(b):
    await b.cycle(as_to_ds=-10.1, ds_skew=5, ds_to_dtack=60)


async def ds_skew(b):
    await b.cycle(ds_skew=20.1, ds_to_dtack=60)


async def ds_high(b):
    await b.cycle()
    await b.after(50, vme_as_ni=0)
    await b.after(50, vme_ds_ni=2)
    await b.after(50, vme_ds_ni=3)
    await b.after(29.9, vme_ds_ni=2)


async def addr_hold(b):
    await b.after(50, vme_as_ni=0, vme_ds_ni=2)
    await b.after(50, vme_a_i=0x3300)
    await b.after(1, vme_d_oe_o=1, vme_dtack_no=0)


async def data_hold(b):
    await b.after(50, vme_as_ni=0, vme_write_ni=0)
    await b.after(50, vme_ds_ni=2)
    await b.after(50, vme_d_i=0x66)
    await b.after(1, vme_dtack_no=0)


async def next_strobe(b):
    await b.after(50, vme_as_ni=0, vme_ds_ni=2)
    await b.after(50, vme_d_oe_o=1, vme_dtack_no=0)
    await b.after(50, vme_d_oe_o=0, vme_ds_ni=3)
    await b.after(50, vme_ds_ni=2)


async def ds_to_dtack(b):
    await b.cycle(ds_to_dtack=29.9)


async def answer(b):
    await b.cycle(ds_to_dtack=16_001)


async def data_to_dtack(b):
    await b.after(50, vme_as_ni=0, vme_ds_ni=2)
    await b.after(50, vme_dtack_no=0)
    await b.after(1, vme_d_oe_o=1)


async def data_off(b):
    await b.cycle(data_off=0.5, off_to_dtack=5)


async def off_to_dtack(b):
    await b.after(50, vme_as_ni=0, vme_ds_ni=2)
    await b.after(50, vme_d_oe_o=1)
    await b.after(50, vme_dtack_no=0)
    await b.after(50, vme_ds_ni=3)
    await b.after(5, vme_dtack_no=1)
    await b.after(5, vme_d_oe_o=0)


async def dtack_rise(b):
    await b.after(50, vme_write_ni=0)
    await b.after(50, vme_as_ni=0, vme_ds_ni=2)
    await b.after(50, vme_dtack_no=0)
    await b.after(50, vme_dtack_no=1)


async def iackout_rise(b):
    await b.after(50, vme_iack_ni=0)
    await b.after(50, vme_as_ni=0)
    await b.after(50, vme_iackout_no=0)
    await b.after(50, vme_as_ni=1, vme_iack_ni=1)
    await b.after(40.1, vme_iackout_no=1)


async def irq_release(b):
    await b.after(50, vme_irq_no=0x6F)
    await b.after(50, vme_as_ni=0, vme_ds_ni=2)
    await b.after(50, vme_as_ni=1, vme_ds_ni=3)
    await b.after(2000.1, vme_irq_no=0x7F)


# What a late release of the data does to its neighbours is a fault of its own.
ALSO = {"off_to_dtack": ["data_off", "off_to_dtack"]}
# strobe_hold cannot go red: without DTACK* there is nothing to measure from; the clocked checker
# of the master has that rule.
FAULTS = {f.__name__: f for f in (
    addr_setup, as_high, write_setup, data_setup, as_to_ds, ds_skew, ds_high, addr_hold, data_hold,
    next_strobe, ds_to_dtack, answer, data_to_dtack, data_off, off_to_dtack, dtack_rise,
    iackout_rise, irq_release,
)}  # fmt: skip


@test("VME-3")
async def limits_met_exactly_are_good(dut):
    b = await Bus(dut, NAMES).start()
    await good(b)
    assert await b.broken() == []


@test("VME-3")
@cocotb.parametrize(name=list(FAULTS))
async def limit_goes_red(dut, name):
    b = await Bus(dut, NAMES).start()
    await FAULTS[name](b)
    assert await b.broken() == (ALSO.get(name) or [name])
