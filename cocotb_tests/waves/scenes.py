# SPDX-License-Identifier: Apache-2.0
"""A short scene for each diagram of docs/waves.toml; no tests: tools/wavegen.py runs them.

A scene calls mark() where its diagram begins and ends.
"""

import contextlib
import os
from pathlib import Path

import cocotb
from cocotb.triggers import FallingEdge, RisingEdge, Timer
from cocotb.utils import get_sim_time
from cocotbext.vme import BusTimeout

from cocotb_tests.lib.tb import (
    ARMED,
    B_DOUBLE,
    B_INDEX,
    B_SCLOCK,
    BASE,
    LATCH,
    PCCSR,
    PORT_B,
    PORT_C,
    RUN,
    SCLOCK_IRQ,
    VECTOR,
    Machine,
)

TOPLEVEL = "mmcs"
PARAMETERS = {"NumCards": 1, "HeartbeatUs": 400, "RelayUs": 20}


def mark() -> None:
    with Path(os.environ.get("MMCS_MARKS", os.devnull)).open("a") as file:
        file.write(f"{get_sim_time('ps'):.0f}\n")


async def machine(dut, **how) -> Machine:
    tb = Machine(dut)
    tb.limit_ms = 1000
    await tb.start(**how)
    return tb


@cocotb.test()
async def vme_read(dut):
    tb = await machine(dut, setup=True)
    mark()
    await tb.crd(0, PORT_B)
    mark()


@cocotb.test()
async def vme_write(dut):
    tb = await machine(dut, setup=True)
    mark()
    await tb.cwr(0, PORT_B, 0x55)
    mark()


@cocotb.test()
async def even_byte(dut):
    tb = await machine(dut)
    mark()
    with contextlib.suppress(BusTimeout):
        await tb.rd(0x408)
    await tb.rd(PCCSR)
    mark()


@cocotb.test()
async def iack(dut):
    tb = await machine(dut)
    await tb.wr(VECTOR, 0x42)
    await tb.sclock(4, 20)
    await tb.wr(PCCSR, BASE | ARMED | SCLOCK_IRQ)
    await FallingEdge(dut.sclock_o)
    mark()
    await RisingEdge(dut.led_irq_o)
    await Timer(300, "ns")
    assert await tb.vme.iack(5) == 0x42
    mark()


@cocotb.test()
async def pccsr_rearm(dut):
    tb = await machine(dut)
    await tb.sclock(4, 14)
    await tb.wr(PCCSR, BASE | ARMED | SCLOCK_IRQ)
    await RisingEdge(dut.led_irq_o)
    mark()
    await tb.rd(PCCSR)
    await tb.wr(PCCSR, BASE)
    await tb.wr(PCCSR, BASE | ARMED | SCLOCK_IRQ)
    await RisingEdge(dut.led_irq_o)
    await Timer(1, "us")
    mark()


@cocotb.test()
async def missed_sclock(dut):
    tb = await machine(dut)
    await tb.timer(2, 0)
    await tb.sclock(4, 20)
    await tb.wr(PCCSR, BASE | ARMED | SCLOCK_IRQ)
    await FallingEdge(dut.sclock_o)
    mark()
    for _ in range(2):  # nobody serves the first before the second
        await RisingEdge(dut.sclock_o)
    await tb.wr(PCCSR, BASE)
    await tb.wr(PCCSR, BASE | ARMED | SCLOCK_IRQ)
    await RisingEdge(dut.sclock_o)
    await Timer(1, "us")
    mark()


@cocotb.test()
async def pc_cycles(dut):
    tb = await machine(dut, setup=True)
    mark()
    await tb.cwr(0, PORT_B, 0x15)
    await tb.crd(0, PORT_B)
    mark()


@cocotb.test()
async def pit_cascade(dut):
    tb = await machine(dut)
    await tb.timer(2, 0, 2)
    await tb.sclock(4, 3)
    await RisingEdge(dut.sclock_o)
    await FallingEdge(dut.sclock_o)
    mark()
    await RisingEdge(dut.sclock_o)
    await RisingEdge(dut.sclock_o)
    await Timer(300, "ns")
    mark()


@cocotb.test()
async def latch_encoder(dut):
    tb = await machine(dut, setup=True)
    await tb.preset(0, 0x12FD)
    await tb.sclock(4, 60)
    cocotb.start_soon(tb.enc[0].move(400, 500))
    await FallingEdge(dut.sclock_o)
    mark()
    await RisingEdge(dut.sclock_o)
    await tb.us(0.5)
    await tb.encoder(0)
    await tb.encoder(0)
    mark()


@cocotb.test()
async def dac_double(dut):
    tb = await machine(dut, setup=True)
    await tb.beat()
    await tb.us(30)
    await tb.sclock(4, 30)
    await tb.cwr(0, PORT_B, RUN | B_DOUBLE)
    await RisingEdge(dut.sclock_o)
    mark()
    await tb.dac(0, 0xC00)
    await RisingEdge(dut.sclock_o)
    await tb.us(0.5)
    await tb.dac(0, 0x400)
    await RisingEdge(dut.sclock_o)
    await tb.us(1)
    mark()


@cocotb.test()
async def adc_conversion(dut):
    tb = await machine(dut, setup=True)
    tb.inputs([8192, -8192])
    await tb.us(25)  # the relay
    mark()
    await tb.cwr(0, LATCH, 0)
    await tb.adc(0)
    for _ in range(15):
        await tb.crd(0, PORT_C)
    await tb.adc(0)
    mark()


@cocotb.test()
async def heartbeat_panic(dut):
    tb = await machine(dut, setup=True)
    mark()
    await tb.us(50)
    await tb.dac(0, 0x800)
    await tb.us(50)
    await tb.dac(1, 0x800)
    await tb.us(250)
    await tb.dac(0, 0x800)
    await tb.dac(1, 0x800)
    await tb.us(200)
    await tb.dac(0, 0x800)  # axis 1 is left to die
    await tb.us(350)
    mark()


@cocotb.test()
async def index_calibration(dut):
    tb = await machine(dut, setup=True)
    await tb.preset(0, 0x00FC)
    await tb.cwr(0, PORT_B, RUN & ~B_SCLOCK | B_INDEX)
    tb.enc[0].lines, tb.enc[0].count = 4, -8
    mark()
    cocotb.start_soon(tb.enc[0].move(30, 500))
    await tb.us(5)
    await tb.crd(0, PORT_C)
    await tb.encoder(0)
    mark()
