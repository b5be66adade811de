# SPDX-License-Identifier: Apache-2.0
# ruff: noqa: F401  (the names that are offered)
"""Models of the 8-bit PC I/O bus for cocotb: master, slave, monitor. See README.md."""

from cocotbext.mmcs.bus import ProtocolError
from cocotbext.pcbus.bus import BusTimeout, PcBus
from cocotbext.pcbus.master import PcBusMaster
from cocotbext.pcbus.monitor import PcBusMonitor, PcCycle
from cocotbext.pcbus.slave import PcBusSlave
