# SPDX-License-Identifier: Apache-2.0
"""Each rule of the edge checker goes red by what lasts a few nanoseconds between clock edges."""

from cocotb.triggers import Timer

from cocotb_tests.checkers.drive import idle
from cocotb_tests.lib.req import test

TOPLEVEL = "vme_edge_checker"
SOURCES = ("../../rtl/checkers/vme_edge_checker.sv",)
PARAMETERS = {"Stop": 0}
OURS, OTHER = 0x6001 >> 1, 0x2001 >> 1
(STROBED, DTACK_OURS, STAYS, OFF, DRIVE_OURS, INSIDE, FATE) = range(7)


class Lines:
    def __init__(self, dut):
        self.dut = dut

    async def put(self, ns: float = 10, **pins) -> None:
        """All at one instant, then so many nanoseconds."""
        for name, value in pins.items():
            getattr(self.dut, f"vme_{name}").value = value
        await Timer(int(ns * 1000), "ps")

    async def start(self):
        self.dut.rst_ni.value = 0
        for name, value in idle(self.dut).items():
            getattr(self.dut, name).value = value
        await Timer(10, "ns")
        self.dut.rst_ni.value = 1
        await Timer(10, "ns")
        return self

    async def cycle(self, a=OURS, ack=False) -> None:
        await self.put(a_i=5 if ack else a, iack_ni=int(not ack))
        await self.put(as_ni=0)
        await self.put(ds_ni=2)

    async def end(self) -> None:
        await self.put(ds_ni=3, d_oe_o=0)
        await self.put(as_ni=1, iackin_ni=1, iackout_no=1, dtack_no=1, iack_ni=1)


async def expect(dut, stimulus, *rules: int) -> None:
    lines = await Lines(dut).start()
    await stimulus(lines)
    await lines.end()
    await lines.put(a_i=0x1234)  # the last instant is judged by the next
    bits = int(dut.broken_o.value)
    assert {n for n in range(7) if bits >> n & 1} == set(rules), f"{bits:07b}, {stimulus.__name__}"


async def good_read(s):
    await s.cycle()
    await s.put(d_oe_o=1)
    await s.put(dtack_no=0)


async def good_acknowledge(s):
    await s.cycle(ack=True)
    await s.put(iackin_ni=0)
    await s.put(d_oe_o=1)
    await s.put(dtack_no=0)


async def good_pass(s):
    await s.cycle(ack=True)
    await s.put(iackin_ni=0)
    await s.put(iackout_no=0)


async def dtack_without_strobe(s):
    await s.put(2, dtack_no=0)


async def dtack_to_another(s):
    await s.cycle(OTHER)
    await s.put(2, dtack_no=0)


async def dtack_to_an_old_strobe(s):
    """Our address is there, but the strobe fell under another's."""
    await s.cycle(OTHER)
    await s.put(a_i=OURS)
    await s.put(2, dtack_no=0)


async def dtack_drops(s):
    await good_read(s)
    await s.put(2, dtack_no=1)
    await s.put(2, dtack_no=0)


async def drivers_linger(s):
    await good_read(s)
    await s.put(2, ds_ni=3)


async def drivers_for_another(s):
    await s.cycle(OTHER)
    await s.put(2, d_oe_o=1)


async def pass_outlives_as(s):
    await good_pass(s)
    await s.put(2, as_ni=1)


async def passed_then_answered(s):
    await good_pass(s)
    await s.put(2, iackout_no=1)
    await s.put(d_oe_o=1)
    await s.put(2, dtack_no=0)


async def answered_then_passed(s):
    await good_acknowledge(s)
    await s.put(2, iackout_no=0)


@test("VME-3", "INT-2")
async def what_is_right_breaks_nothing(dut):
    for stimulus in (good_read, good_acknowledge, good_pass):
        await expect(dut, stimulus)


@test("VME-3")
async def dtack_at_the_wrong_moment(dut):
    await expect(dut, dtack_without_strobe, STROBED, DTACK_OURS)
    await expect(dut, dtack_to_another, DTACK_OURS)
    await expect(dut, dtack_to_an_old_strobe, DTACK_OURS)
    await expect(dut, dtack_drops, STAYS)


@test("VME-3")
async def drivers_at_the_wrong_moment(dut):
    await expect(dut, drivers_linger, OFF)
    await expect(dut, drivers_for_another, DRIVE_OURS)


@test("INT-2")
async def an_acknowledge_of_two_fates(dut):
    await expect(dut, pass_outlives_as, INSIDE)
    await expect(dut, passed_then_answered, FATE)
    await expect(dut, answered_then_passed, FATE)
