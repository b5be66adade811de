# SPDX-License-Identifier: Apache-2.0
"""Analog pins of converters for cocotb: volts as signed numbers on a bus. See README.md."""

from cocotbext.analog.pins import AnalogSink, AnalogSource
from cocotbext.mmcs import Pins

__all__ = ["AnalogSink", "AnalogSource", "Pins"]
