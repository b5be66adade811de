# SPDX-License-Identifier: Apache-2.0
"""Joint 1 of the SoC's card: a motor of whole numbers on its pins; until gp1 is lit."""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge, Timer, ValueChange
from cocotbext.analog import AnalogSink
from cocotbext.quadrature import Pins, QuadratureSource

GOAL, NEAR, GP1, LIMIT = 200, 4, 8, 300  # SCLOCKs in which the program must be done


async def hear(register, lines: list) -> None:
    """What the program says through LiteX's scratch register: characters, each with its number."""
    text = ""
    while True:
        await ValueChange(register)
        character = chr(int(register.value) & 0xFF)
        if character == "\n":
            lines.append(text)
        text = "" if character == "\n" else text + character


@cocotb.test()
async def the_processor_moves_the_motor(dut):
    """LiteX's CPU runs the driver: interrupt, Wishbone, card, D/A, encoder, and back."""
    dut.rst.value, dut.axis_enable.value = 1, 3
    dut.estop_closed.value, dut.pc_power.value = 1, 1
    encoder = QuadratureSource(*(Pins(h) for h in (dut.enc_a, dut.enc_b, dut.enc_i)), 0)
    Clock(dut.clk, 125, "ns").start()
    await ClockCycles(dut.clk, 8)
    dut.rst.value = 0
    y, v, drives, there, said = 0, 0, set(), None, []
    cocotb.start_soon(hear(dut.scratch_storage, said))
    for n in range(LIMIT):
        await RisingEdge(dut.sclock)
        await ClockCycles(dut.clk, 4)
        assert not said, f"the program on LiteX's processor ends with: {'; '.join(said)}"
        drive = AnalogSink(dut.drive_v).raw()
        drives.add(drive)
        v = max(-160, min(160, v + drive // 256 - v // 8))
        await encoder.move(v // 8, 1000)
        y += v // 8
        if abs(y - GOAL) <= NEAR and there is None:
            there = n
        if int(dut.card_leds.value) >> GP1 & 1:
            break
    dut._log.info("position %d, there after %s SCLOCKs, told after %d", y, there, n)
    assert int(dut.card_leds.value) >> GP1 & 1, f"not there: {y}, D/A values {sorted(drives)[:9]}"
    assert abs(y - GOAL) <= NEAR and len(drives) > 10
    assert int(dut.brake_release.value)
    dut.estop_closed.value = 0
    await Timer(1, "ns")
    assert not int(dut.brake_release.value), "the button closes the brakes"
