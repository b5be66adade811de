# SPDX-License-Identifier: Apache-2.0
"""The PC bus's lines where its cable or its power-on is in between. §4.2.1, §4.3.8"""

import cocotb
from cocotb.triggers import FallingEdge, Timer

from cocotb_tests.adaptor.cocotb_host_port import HostPort
from cocotb_tests.lib.req import test

TOPLEVEL = "adaptor_core"


@test("PCB-1", "CSR-1")
async def reset_drv_stands_from_power_on(dut):
    """It is high while the power-on reset is, and until SYSRESET* has ended."""
    tb = await HostPort(dut).start()
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


@test("PCB-1", "PAN-2")
async def cable_that_bounces_in_a_command(dut):
    """Out and back at any clock of an access: one command at most, and what is cut reads 0xFF."""
    tb = await HostPort(dut).start()
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
