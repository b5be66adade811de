# SPDX-License-Identifier: Apache-2.0
"""One way to each host: rd(offset), wr(offset, value) by the offsets of the VME window, and raw().

The masters of bus fronts are packages that others wrote, so that both sides of a handshake are not
ours. The host port of the core alone is driven by HostPort.
"""

import logging
import os

from cocotb.triggers import FallingEdge, RisingEdge
from cocotbext.apb import ApbBus, ApbMaster
from cocotbext.axi import AxiLiteBus, AxiLiteMaster
from cocotbext.vme import VmeBus, VmeMaster
from cocotbext.wishbone.driver import WBOp, WishboneMaster

from cocotb_tests.lib.tb import Host

VME, AXIL, WB, WB_PIPELINED, APB, WB_BYTES, APB_BYTES = range(7)
NAMES = ("vme", "axil", "wb", "wb-pipelined", "apb", "wb-8bit", "apb-8bit")  # variants of the tests
PREFIX = {WB: "wb", WB_PIPELINED: "wb", WB_BYTES: "wb", APB: "apb", APB_BYTES: "apb"}


class Refused(Exception):
    """The bus's own error."""


WB_PINS = {"cyc": "cyc_i", "stb": "stb_i", "we": "we_i", "adr": "adr_i", "sel": "sel_i",
           "datwr": "dat_i", "datrd": "dat_o", "ack": "ack_o", "err": "err_o"}  # fmt: skip
LIMIT_CLOCKS = 200  # in which a Wishbone front answers: simulated time, not the wall's


class Front(Host):
    """The bench behind the master of its front."""

    limit_ms = 200

    def __init__(self, dut):
        super().__init__(dut)
        self.front = NAMES.index(os.environ["MMCS_VARIANT"])
        self.width = 8 if self.front in (WB_BYTES, APB_BYTES) else 32

    async def start(self):
        dut, front = self.dut, self.front
        await super().start()
        dut.axis_enable_i.value = 3
        self.irq = dut.led_irq_o if front == VME else dut.irq_o
        if front != VME:
            for name in ("awvalid", "wvalid", "arvalid", "bready", "rready"):
                getattr(dut, f"s_axil_{name}").value = 0
            dut.apb_psel.value = dut.apb_penable.value = 0
            dut.front_i.value = front
        self.enc = self.encoders(2)
        self._take_master(PREFIX.get(front))
        await self.clocks(4)
        return self

    def _take_master(self, prefix: str | None) -> None:
        dut, front = self.dut, self.front
        if front == VME:
            self.vme = VmeMaster(VmeBus.from_prefix(dut, "vme"))
        elif front == AXIL:
            bus = AxiLiteBus.from_prefix(dut, "s_axil")
            self.axil = AxiLiteMaster(bus, dut.clk_i, dut.rst_ni, reset_active_level=False)
        elif front in (APB, APB_BYTES):
            self.apb = ApbMaster(ApbBus.from_prefix(dut, prefix), dut.clk_i)
            self.apb.return_int = True
            self.apb.log.setLevel(logging.WARNING)
        else:
            pins = WB_PINS | ({"stall": "stall_o"} if front == WB_PIPELINED else {})
            self.wb = WishboneMaster(
                dut, prefix, dut.clk_i, timeout=LIMIT_CLOCKS, width=self.width, signals_dict=pins
            )

    async def raw(self, address: int, value: int | None = None, strobe: int | None = None) -> int:
        """An access as the bus has it: byte address, byte lanes; Refused if it ends in an error."""
        whole = (1 << self.width // 8) - 1
        lanes = whole if strobe is None else strobe
        if self.front == AXIL:
            return await self._axil(address, value, lanes)
        if self.front in (APB, APB_BYTES):
            return await self._apb(address, value, lanes)
        (result,) = await self.wb.send_cycle([WBOp(address, value, sel=lanes)])
        if result.ack == 2:
            raise Refused
        return int(result.datrd) if value is None else 0

    async def _axil(self, address: int, value: int | None, lanes: int) -> int:
        if value is None:
            got = await self.axil.read(address, 4)
            if got.resp:
                raise Refused(got.resp.name)
            return int.from_bytes(got.data, "little")
        low = (lanes & -lanes).bit_length() - 1 if lanes else 0
        data = value.to_bytes(4, "little")[: lanes.bit_length() - low or 1]
        done = await self.axil.write(address + low, data)
        if done.resp:
            raise Refused(done.resp.name)
        return 0

    async def _apb(self, address: int, value: int | None, lanes: int) -> int:
        # The package compares with what is expected, in a coroutine of its own, and fails the test.
        expected = self.expects_error(address, lanes, value is not None)
        if value is None:
            got = await self.apb.read(address, error_expected=expected)
        else:
            got = await self.apb.write(address, value, strb=lanes, error_expected=expected)
        await RisingEdge(self.dut.clk_i)
        if expected:
            raise Refused("PSLVERR")
        return got or 0

    def expects_error(self, address: int, lanes: int, write: bool) -> bool:
        """What the documentation says of an access."""
        if self.width == 8:
            return address >= 1 << 11 or address % 2 == 0
        bad = write and lanes not in (0, 1, 15)
        return address >= 1 << 12 or address % 4 != 0 or bad

    def place(self, offset: int) -> int:
        """Byte address of the register at this offset of the VME window."""
        return offset if self.width == 8 else offset // 2 * 4

    async def rd(self, offset: int) -> int:
        if self.front == VME:
            return await super().rd(offset)
        return await self.raw(self.place(offset))

    async def wr(self, offset: int, value: int) -> None:
        if self.front == VME:
            await super().wr(offset, value)
        else:
            await self.raw(self.place(offset), value)


class HostPort(Host):
    """One request at a time, as a host front makes them."""

    async def start(self):
        await super().start()
        self.dut.pc_d_i.value = 0xFF
        return self

    async def access(self, offset: int, value: int | None = None, wait: int = 1000) -> int:
        dut = self.dut
        dut.hp_a_i.value = offset >> 1
        dut.hp_write_i.value = int(value is not None)
        dut.hp_wdata_i.value = value or 0
        dut.hp_req_i.value = 1
        for n in range(wait):
            await FallingEdge(dut.clk_i)  # between the edges all is settled
            if int(dut.hp_ack_o.value):
                data = int(dut.hp_rdata_o.value)
                await RisingEdge(dut.clk_i)
                dut.hp_req_i.value = 0
                await RisingEdge(dut.clk_i)
                assert not int(dut.hp_ack_o.value), "one clock of answer"
                assert int(dut.hp_rdata_o.value) == data, "held after the answer"
                self.took = n + 1
                return data
        raise AssertionError(f"no answer at {offset:03X}")

    async def rd(self, offset: int) -> int:
        return await self.access(offset)

    async def wr(self, offset: int, value: int) -> None:
        assert await self.access(offset, value) == 0xFF, "a write answers nothing"
