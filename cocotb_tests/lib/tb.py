# SPDX-License-Identifier: Apache-2.0
"""Test benches: clock, reset, healthy inputs; the machine with its registers by name."""

import ast
import os
import random
from collections.abc import Callable
from functools import cached_property
from itertools import zip_longest

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge, Timer
from cocotb.utils import get_sim_time
from cocotbext.analog import AnalogSink, AnalogSource
from cocotbext.mmcs import Pins
from cocotbext.pcbus import PcBus, PcBusMonitor
from cocotbext.quadrature import QuadratureSource
from cocotbext.vme import VmeBus, VmeMaster

from mmcs import regs

# Inputs that are 1 in health; all others are inert at 0.
HEALTHY = ("estop_closed_i", "cable_ok_i", "pc_power_i", "power_i")

# Short names of the registers that the tests use most. §4.3.3, §5.3.1
PIT, PCCSR, VECTOR = regs.PIT0, regs.PCCSR, regs.VECTOR
PORT_A, PORT_B, PORT_C = regs.CARD_PPI_A, regs.CARD_PPI_B, regs.CARD_PPI_C
PPI_CONTROL, PPI_SETUP = regs.CARD_PPI_CONTROL, regs.PPI_MODE_BOARD
ENC1 = regs.CARD_ENC1_MSB
DAC1, DAC2 = regs.CARD_DAC1_LO, regs.CARD_DAC2_LO
ADC_LO, ADC_HI = regs.CARD_ADC1_LO, regs.CARD_ADC_HI
LATCH, LATCH_ALL = regs.CARD_LATCH, regs.CARD_LATCH_ALL
B_REAL_ENC, B_TO_JOINT = regs.CARD_PPI_B_ENC_JOINT_BM, regs.CARD_PPI_B_DAC_JOINT_BM
B_SCLOCK, B_DOUBLE = regs.CARD_PPI_B_SCLOCK_EN_BM, regs.CARD_PPI_B_DAC_DOUBLE_BM
B_INDEX = regs.CARD_PPI_B_INDEX_EN_BM
C_BEAT1, C_BEAT2 = regs.CARD_PPI_C_HEARTBEAT1_BM, regs.CARD_PPI_C_HEARTBEAT2_BM
C_INDEX1, C_INDEX2 = regs.CARD_PPI_C_INDEX1_BM, regs.CARD_PPI_C_INDEX2_BM
C_DONE = regs.CARD_PPI_C_ADC_READY_BM
ARMED = regs.PCCSR_LATCH_EN_BM
SCLOCK_IRQ, PANIC_IRQ = regs.PCCSR_SCLOCK_EN_BM, regs.PCCSR_PANIC_EN_BM
BASE = regs.PCCSR_BASE_CARDS
QUAD = 5
RUN = B_REAL_ENC | B_TO_JOINT | B_SCLOCK
HEALTH_CLKS = 16  # from the end of the last fault to the end of PANIC, and more
LEDS = ("a1", "b1", "i1", "a2", "b2", "i2", "beat1", "beat2", "gp1", "gp2", "power")


def dip(*numbers: int) -> int:
    """The address switches of all cards, set to these numbers."""
    return sum(number << 4 * card for card, number in enumerate(numbers))


def volts_of(code: int) -> int:
    """Offset binary to 16-bit volts on the 20 V span."""
    return (code - 0x800) * 16


def parameters() -> dict:
    return ast.literal_eval(os.environ.get("MMCS_PARAMETERS", "{}"))


class Tb:
    """Clock, reset and inputs of any module that follows the project's port names."""

    clk_hz = 8_000_000  # where no parameter of the module says it

    def __init__(self, dut):
        self.dut = dut
        self.log = dut._log
        self.parameters = parameters()
        self.clk_hz = self.parameters.get("ClkHz", self.clk_hz)
        self.period = round(1e12 / self.clk_hz / 2) * 2  # ps
        self.random = random.Random(cocotb.RANDOM_SEED)

    def inputs_idle(self) -> None:
        for name in self._inputs():
            handle = getattr(self.dut, name)
            high = name in HEALTHY or name.endswith("_ni")
            handle.value = (1 << len(handle)) - 1 if high else 0
            if name == "dip_i":  # each card its own number
                handle.value = dip(*range(len(handle) // 4))

    def _inputs(self):
        return [
            n
            for n in (handle._name for handle in self.dut)
            if n.endswith(("_i", "_ni")) and n not in ("clk_i", "rst_ni")
        ]

    limit_ms = 40  # of simulated time: a test that waits for what never comes fails, not hangs

    async def _watchdog(self) -> None:
        await Timer(self.limit_ms, "ms")
        raise AssertionError(f"still waiting after {self.limit_ms} ms of simulated time")

    async def start(self):
        cocotb.start_soon(self._watchdog())
        self.inputs_idle()
        self.dut.rst_ni.value = 0
        self.clock = Clock(self.dut.clk_i, self.period, "ps", impl="gpi")
        self.clock.start()
        await self.clocks(4)
        self.dut.rst_ni.value = 1
        await self.clocks(4)
        return self

    async def clocks(self, n: int) -> None:
        """To the n-th rising edge from now; costs two wake-ups whatever n."""
        if n > 1:
            await Timer((n - 1) * self.period + self.period // 4, "ps")
        if n:
            await RisingEdge(self.dut.clk_i)

    async def us(self, us: float) -> None:
        if us > 0:
            await Timer(round(us * 1000), "ns")

    def now(self) -> float:
        return get_sim_time("ps")

    def times(self, edge: Callable, handle) -> list[float]:
        """When it comes, in ps: a list that grows from now on."""
        seen = []

        async def watch():
            while True:
                await edge(handle)
                seen.append(self.now())

        cocotb.start_soon(watch())
        return seen

    def clks(self, ps: float) -> int:
        """A time as a count of clocks, which it must be."""
        n = round(ps / self.period)
        assert abs(ps - n * self.period) < self.period / 8, f"{ps} ps is no count of clocks"
        return n

    def stuck(self, register, value: int):
        """A register that keeps a value whatever is clocked into it; the task ends it."""

        async def hold():
            while True:
                register.value = value
                await FallingEdge(self.dut.clk_i)

        return cocotb.start_soon(hold())

    def encoders(self, count: int) -> list[QuadratureSource]:
        dut = self.dut
        pins = [Pins(h) for h in (dut.enc_a_i, dut.enc_b_i, dut.enc_i_i)]
        return [QuadratureSource(*pins, axis) for axis in range(count)]

    # -- analog pins ---------------------------------------------------------------------------

    @cached_property
    def _analog(self) -> list[AnalogSource]:
        pins = Pins(self.dut.adc_v_i, width=16)
        return [AnalogSource(pins, axis) for axis in range(pins.lanes)]

    def inputs(self, volts: list[int]) -> None:
        """adc_v_i of all axes, 32768 = 10 V; those beyond the list at 0."""
        for source, value in zip_longest(self._analog, volts, fillvalue=0):
            source.raw(value)

    def volts(self, axis: int) -> int:
        """drive_v_o of an axis, signed, 32768 = 10 V."""
        return AnalogSink(self.dut.drive_v_o, axis).raw()


class Host(Tb):
    """Registers by name: over VME, or however the rd() and wr() of a bench reach them."""

    base = regs.WINDOW_BASE

    async def rd(self, offset: int) -> int:
        return await self.vme.read(self.base | offset)

    async def wr(self, offset: int, value: int) -> None:
        await self.vme.write(self.base | offset, value)

    @staticmethod
    def creg(card: int, register: int) -> int:
        return card << 6 | register << 1 | 1

    async def crd(self, card: int, register: int) -> int:
        return await self.rd(self.creg(card, register))

    async def cwr(self, card: int, register: int, value: int) -> None:
        await self.wr(self.creg(card, register), value)

    async def setup(self, card: int, b: int = RUN) -> None:
        await self.cwr(card, PPI_CONTROL, PPI_SETUP)
        await self.cwr(card, PORT_A, QUAD)
        await self.cwr(card, PORT_B, b)

    async def timer(self, n: int, count: int, mode: int = 2) -> None:
        await self.wr(PIT + 6, n << 6 | 0x30 | mode << 1)
        await self.wr(PIT + 2 * n, count & 0xFF)
        await self.wr(PIT + 2 * n, count >> 8)

    async def timer_value(self, n: int) -> int:
        await self.wr(PIT + 6, n << 6)
        low = await self.rd(PIT + 2 * n)
        return low | await self.rd(PIT + 2 * n) << 8

    async def sclock(self, n0: int, n1: int, mode: int = 2) -> None:
        await self.timer(0, n0, mode)
        await self.timer(1, n1, mode)

    async def dac(self, axis: int, code: int) -> None:
        card, register = axis // 2, DAC1 + 2 * (axis % 2)
        await self.cwr(card, register, code & 0xFF)
        await self.cwr(card, register + 1, code >> 8)

    async def adc(self, axis: int) -> int:
        card, joint = axis // 2, axis % 2
        high = await self.crd(card, ADC_HI)
        return (high >> 4 * joint & 0xF) << 8 | await self.crd(card, ADC_LO + joint)

    async def encoder(self, axis: int) -> int:
        card, register = axis // 2, ENC1 + 2 * (axis % 2)
        high = await self.crd(card, register)
        return high << 8 | await self.crd(card, register + 1)

    async def preset(self, axis: int, value: int) -> None:
        card, register = axis // 2, ENC1 + 2 * (axis % 2)
        await self.cwr(card, register, value >> 8)
        await self.cwr(card, register + 1, value & 0xFF)


class Machine(Host):
    """The module mmcs behind its VME connector."""

    def __init__(self, dut, **master):
        super().__init__(dut)
        self.cards = len(dut.axis_enable_i) // 2
        self.bus = VmeBus.from_prefix(dut, "vme")
        self.master_options = master
        self.vme: VmeMaster | None = None
        self.enc: list[QuadratureSource] = []

    async def start(self, *, base: int = BASE, setup: bool = False, beat: bool = False):
        """Out of reset, the cards reachable; `setup` programs all PPIs, `beat` writes all D/As."""
        await super().start()
        self.dut.axis_enable_i.value = (1 << 2 * self.cards) - 1
        self.vme = VmeMaster(self.bus, **self.master_options)
        self.enc = self.encoders(2 * self.cards)
        await self.wr(PCCSR, base)
        for card in range(self.cards if setup else 0):
            await self.setup(card)
        if beat:
            await self.beat()
        return self

    async def beat(self) -> None:
        """Zero volts to every D/A, which starts every heartbeat."""
        for axis in range(2 * self.cards):
            await self.dac(axis, 0x800)

    def pc_monitor(self, **limits) -> PcBusMonitor:
        """What comes out on the expansion connector."""
        return PcBusMonitor(PcBus.from_prefix(self.dut, "pcx"), **limits)

    def led(self, card: int, name: str) -> int:
        return int(self.dut.card_leds_o.value) >> (11 * card + LEDS.index(name)) & 1
