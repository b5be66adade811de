# SPDX-License-Identifier: Apache-2.0
# ruff: noqa: F401  (the names that are offered)
"""VMEbus models for cocotb: master, slave, interrupts, monitor. See README.md."""

from cocotbext.mmcs.bus import ProtocolError
from cocotbext.vme.bus import (
    AM_A24_SUPERVISOR,
    AM_A24_USER,
    AM_A32_SUPERVISOR,
    AM_A32_USER,
    AM_SUPERVISOR,
    AM_USER,
    DS_BOTH,
    DS_EVEN,
    DS_NONE,
    DS_ODD,
    BusError,
    BusTimeout,
    VmeBus,
    VmeTiming,
)
from cocotbext.vme.interrupts import VmeInterrupter, VmeInterruptHandler
from cocotbext.vme.master import Operation, VmeMaster
from cocotbext.vme.monitor import VmeCycle, VmeMonitor
from cocotbext.vme.slave import VmeSlave
