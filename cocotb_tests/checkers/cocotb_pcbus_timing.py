# SPDX-License-Identifier: Apache-2.0
"""Each limit of the PC bus goes red just past it, and holds just at it. §4.3.2"""

import cocotb

from cocotb_tests.checkers.drive import BENCH, Timed
from cocotb_tests.lib.req import test

TOPLEVEL, SOURCES = BENCH
CHECKER = "pcbus_timing"
NAMES = [
    "addr_setup", "command", "longest", "addr_hold", "data_setup", "data_hold", "read_setup",
    "recovery",
]  # fmt: skip
EXACT = {
    "setup": 125,
    "command": 500,
    "hold": 30,
    "data": 100,  # write data before the end of IOW#
    "read": 75,  # read data before the end of IOR#
    "pause": 95,
    "link": 1,
}


class Bus(Timed):
    flip = 0

    async def cycle(self, write, **times):
        t = EXACT | times
        self.flip ^= 1
        self.put(pc_a_i=0x300 + self.flip)
        await self.after(t["setup"], **{"pc_iow_ni" if write else "pc_ior_ni": 0})
        self.put(link_ok_i=t["link"])
        early = t["data"] if write else t["read"]
        ready = {"pc_d_i": 0x40 + self.flip} if write else {"driven_i": 1, "pc_rdata_i": 0x55}
        await self.after(t["command"] - early, **ready)
        await self.after(early, pc_iow_ni=1, pc_ior_ni=1)
        self.put(driven_i=0, pc_rdata_i=0xFF)
        await self.after(t["hold"], pc_a_i=0x310)
        if write:
            self.put(pc_d_i=0xFF)
        self.put(link_ok_i=1)
        await self.after(t["pause"])


WRITE, READ = True, False
FAULTS = {
    "addr_setup": (WRITE, {"setup": 124.9, "pause": 200}),
    "command": (READ, {"command": 499.9}),
    "longest": (READ, {"command": 1875.1}),
    "addr_hold": (READ, {"hold": 19.9, "pause": 200}),
    "data_setup": (WRITE, {"data": 99.9}),
    "data_hold": (WRITE, {"hold": 29.9, "pause": 200}),
    "read_setup": (READ, {"read": 74.9}),
    "recovery": (READ, {"pause": 94.9}),
}


@test("PCB-1")
async def limits_met_exactly_are_good(dut):
    b = await Bus(dut, CHECKER, NAMES).start()
    for write in (WRITE, READ, WRITE, READ):
        await b.cycle(write)
    await b.cycle(WRITE, command=1875)
    await b.cycle(READ, command=200, hold=5, pause=200, link=0)  # cable out: no fault
    await b.cycle(READ)
    assert await b.broken() == []


@test("PCB-1")
@cocotb.parametrize(name=list(FAULTS))
async def limit_goes_red(dut, name):
    write, times = FAULTS[name]
    b = await Bus(dut, CHECKER, NAMES).start()
    await b.cycle(write, pause=200)
    await b.cycle(write, **times)
    if name == "addr_setup":
        await b.after(100)
    else:
        await b.cycle(write)
    assert await b.broken() == [name]
