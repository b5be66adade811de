# SPDX-License-Identifier: Apache-2.0
"""A slave that pulls DTACK* with no strobe: what test_stop.py runs to see the simulation end."""

import cocotb

from cocotb_tests.checkers.cocotb_vme_slave_checker import FAULTS
from cocotb_tests.checkers.drive import Pins


@cocotb.test()
async def dtack_without_strobe(dut):
    pins = await Pins(dut).start()
    await pins.play(f"{FAULTS['dtack_alone'][1]} 5")
