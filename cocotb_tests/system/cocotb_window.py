# SPDX-License-Identifier: Apache-2.0
"""Every address, access size and address modifier: answered, or left alone. §4.3.1-4.3.3"""

from itertools import product

import cocotb
from cocotb.triggers import FallingEdge
from cocotbext.vme import VmeTiming

from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import PCCSR, PIT, PORT_A, VECTOR, Machine
from cocotb_tests.system.machine import USUAL

TOPLEVEL = "mmcs"
PARAMETERS = USUAL
ELSEWHERE = 0x07  # a base at which no card listens
QUIET_NS = 1500  # an own register is answered by then, a PC cycle begun
NOTHING = 0xF0  # a read-back command that selects no counter
BYTES = {"even": 1, "odd": 1, "word": 2, "long": 4}
KINDS, MODIFIERS = ("read", "write"), (0x29, 0x2D)
TARGETS = {
    "card": Machine.creg(0, PORT_A),
    "absent card": Machine.creg(15, PORT_A),
    "counter 0": PIT,
    "counter 1": PIT + 2,
    "counter 2": PIT + 4,
    "control word": PIT + 6,
    "PCCSR": PCCSR,
    "hole": 0x411,
    "vector": VECTOR,
    "mirror": 0x789,
}


class Space(Machine):
    """The window with a model of what an access must do."""

    limit_ms = 200

    async def start(self):
        await super().start(base=ELSEWHERE)
        self.vme.timing = VmeTiming(ds_high=130)  # seen by the slave's clock even when unanswered
        self.base_bits = ELSEWHERE
        self.expected: list[tuple[str, int]] = []
        self.cycles: list[tuple[str, int]] = []
        for n in range(3):  # waits for a trigger that never comes: its count stays 0
            await self.wr(PIT + 6, n << 6 | 0x12)
        cocotb.start_soon(self._commands("read", self.dut.pcx_ior_no))
        cocotb.start_soon(self._commands("write", self.dut.pcx_iow_no))
        return self

    async def _commands(self, kind: str, strobe) -> None:
        while True:
            await FallingEdge(strobe)
            self.cycles.append((kind, int(self.dut.pcx_a_o.value)))

    def _effect(self, kind: str, offset: int, value: int) -> int:
        """Carries an answered access out on the model; what a read gives."""
        if not offset & 0x400:
            address = (offset >> 1 & 31) | self.base_bits << 5 | (offset >> 6 & 15) << 10
            self.expected.append((kind, address))
        elif not offset & 0x40 and offset & 0x38 == 8:
            if kind == "read":
                return self.base_bits
            self.base_bits = value & 0x1F
        elif not offset & 0x78 and offset & 6 != 6:
            return 0
        return 0xFF

    def _value(self, offset: int) -> int:
        """Something to write that stops no timer, arms nothing and stays clear of the cards."""
        if not offset & 0x440 and not offset & 0x38:
            return NOTHING if offset & 6 == 6 else self.random.getrandbits(8)
        if offset & 0x478 == 0x400:
            return NOTHING if offset & 6 == 6 else self.random.getrandbits(8)
        return self.random.randrange(0x18)

    async def access(self, address: int, size: str, am: int, kind: str, ours: bool) -> None:
        odd = address | 1
        where = odd if size == "odd" else address & ~(3 if size == "long" else 1)
        value = self._value(odd & 0x7FF)
        how = {"size": BYTES[size], "am": am}
        answered = ours and size in ("odd", "word")
        if not answered:
            how["withdraw_ns"] = QUIET_NS
        if kind == "read":
            op = self.vme.init_read(where, **how)
        else:
            op = self.vme.init_write(where, value, **how)
        await op.wait()
        what = f"{kind} {where:04X} {size} AM {am:02X}"
        assert op.error is None, f"{what}: {op.error}"
        assert op.answered == answered, what
        if answered:
            want = self._effect(kind, odd & 0x7FF, value)
            if kind == "read":
                assert op.data & 0xFF == want, f"{what}: {op.data:04X}, not {want:02X}"
        assert self.cycles == self.expected, f"{what}: wrong cycles on the PC bus"
        self.cycles.clear()
        self.expected.clear()


space_test = tests_on(Space)


@space_test("VME-1", "VME-2", "VME-4", "VME-5", "MAP-1")
@cocotb.parametrize(am=MODIFIERS)
async def every_address_and_size(tb, am):
    for offset, size, kind in product(range(0, 0x800, 2), BYTES, KINDS):
        await tb.access(0x6000 | offset, size, am, kind, True)


@space_test("VME-1", "VME-2", "VME-6")
async def every_modifier_and_size(tb):
    for am in range(64):
        for offset, size, kind in product(TARGETS.values(), BYTES, KINDS):
            await tb.access(0x6000 | offset, size, am, kind, am in MODIFIERS)
        assert await tb.rd(PCCSR) == tb.base_bits


@space_test("VME-1", "VME-6")
async def every_segment_and_size(tb):
    for segment, am, size in product(range(32), MODIFIERS, BYTES):
        await tb.access(segment << 11 | 0x408, size, am, "read", segment == 0b01100)
