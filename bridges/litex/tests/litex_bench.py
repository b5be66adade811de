# SPDX-License-Identifier: Apache-2.0
"""Both joints of the SoC's card: motors of whole numbers on its pins; until gp1 is lit."""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge, Timer, ValueChange, gather
from cocotbext.analog import AnalogSink
from cocotbext.quadrature import Pins, QuadratureSource

GOALS, NEAR, GP1, LIMIT = (200, -120), 4, 8, 300  # SCLOCKs in which the program must be done


class Motor:
    """What a code of the D/A drives against viscous friction; counts on the encoder's pins."""

    def __init__(self, dut, pins: list, lane: int):
        self.encoder = QuadratureSource(*pins, lane)
        self.sink, self.drives = AnalogSink(dut.drive_v, lane), set()
        self.position = self.speed = 0

    async def step(self) -> None:
        drive = self.sink.raw()
        self.drives.add(drive)
        self.speed = max(-160, min(160, self.speed + drive // 256 - self.speed // 8))
        self.position += self.speed // 8
        await self.encoder.move(self.speed // 8, 1000)


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
async def the_processor_moves_two_motors(dut):
    """LiteX's CPU runs the driver: interrupt, Wishbone, card, D/A, encoder, and back."""
    dut.rst.value, dut.axis_enable.value = 1, 3
    dut.estop_closed.value, dut.pc_power.value = 1, 1
    pins = [Pins(handle) for handle in (dut.enc_a, dut.enc_b, dut.enc_i)]
    motors = [Motor(dut, pins, lane) for lane in range(2)]
    Clock(dut.clk, 41.666, "ns").start()
    await ClockCycles(dut.clk, 8)
    dut.rst.value = 0
    said = []
    register = next(handle for handle in dut if handle._name.endswith("scratch_storage"))
    cocotb.start_soon(hear(register, said))
    for _ in range(LIMIT):
        await RisingEdge(dut.sclock)
        await ClockCycles(dut.clk, 12)
        assert not said, f"the program on LiteX's processor ends with: {'; '.join(said)}"
        await gather(*(motor.step() for motor in motors))
        if int(dut.card_leds.value) >> GP1 & 1:
            break
    positions = [motor.position for motor in motors]
    dut._log.info("positions %s", positions)
    assert int(dut.card_leds.value) >> GP1 & 1, f"not there: {positions}"
    for motor, goal in zip(motors, GOALS, strict=True):
        assert abs(motor.position - goal) <= NEAR and len(motor.drives) > 10
    assert int(dut.brake_release.value)
    dut.estop_closed.value = 0
    await Timer(1, "ns")
    assert not int(dut.brake_release.value), "the button closes the brakes"
