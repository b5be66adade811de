# SPDX-License-Identifier: Apache-2.0
# Length: one random case and the rules that judge it at every instant.
"""The adaptor on a VMEbus whose lines change at any time against each other and the clock. §4.3

Each wire of the bus comes up to 5 ns early or late, the synchronisers take an input that changed
within 2 ns before the clock as its old or its new value, and times are random between the least
that the standard lets a slave see and three clocks. Half of them are whole clocks, so that several
lines change next to a clock edge in one case. The rules hold at every instant; each case ends with
a write and a read that must be right.
"""

from dataclasses import dataclass
from itertools import product

import cocotb
from cocotb.triggers import FallingEdge, First, RisingEdge, Timer
from cocotbext.mmcs import Watch
from cocotbext.pcbus import PcBus, PcBusSlave
from cocotbext.vme import VmeBus

from cocotb_tests.lib.req import tests_on
from cocotb_tests.lib.tb import ARMED, BASE, HEALTH_CLKS, PANIC_IRQ, PCCSR, VECTOR, Tb

TOPLEVEL = "adaptor_vme"
SOURCES = ("mmcs_sync.sv",)
MHZ = (8, 16, 48, 80)  # at the last a synchroniser's window is a sixth of a clock
WIRE_PS = 5_000
CASES = 24  # of a row of a table
VEC, LEVEL, OTHER_LEVEL = 0xC5, 5, 3
LINES = ("estop_closed_i", "cable_ok_i", "pc_power_i")


@dataclass(frozen=True)
class Cycle:
    address: int  # of an acknowledge: its level
    data: int | None = None  # what a write writes
    ds: int = 0b10
    am: int = 0x29
    ack: bool = False

    @property
    def ours(self) -> bool:
        return not self.ack and self.address >> 11 == 0xC and not self.ds & 1 and self.am == 0x29

    @property
    def lines(self) -> str:
        """Address, modifier and IACK*, as a line of stimulus."""
        at = 0x3000 | self.address if self.ack else self.address >> 1  # A15-A04 are anything
        return f"a={at} am={self.am} lword_n=1 iack_n={int(not self.ack)}"

    @property
    def data_lines(self) -> str:
        return "write_n=1 d=0xFF" if self.data is None else f"write_n=0 d={self.data}"

    @property
    def register(self) -> int:
        return 0x300 | self.address >> 1 & 0x1F


WRITE, NEXT_WRITE, READ = Cycle(0x6031, 0xA7), Cycle(0x6033, 0x3C), Cycle(0x602B)
NEIGHBOURS = {
    "another board's read": Cycle(0x2001),
    "another board's write": Cycle(0x2009, 0x99),
    "even byte": Cycle(0x6030, 0x66, ds=0b01),
    "other modifier": Cycle(0x6035, 0x77, am=0x0B),
}
OURS = {"our write": WRITE, "our read": READ}


class Backplane(Tb):
    """The bus as the adaptor sees it, a card that answers reads, and the rules."""

    limit_ms = 400

    async def start(self):
        await super().start()
        self.bus, self.due, self.level = VmeBus.from_prefix(self.dut, "vme"), [], {}
        self.bus.idle()
        self.pc = PcBusSlave(
            PcBus.from_prefix(self.dut, "pc"), base=0x300, size=32, access_ns=0,
            on_read=lambda offset: offset ^ 0x5A,
            on_write=lambda offset, value: self.written.append((0x300 | offset, value)),
        )  # fmt: skip
        self.written, self.cycle, self.answers, self.passes = [], None, 0, 0
        cocotb.start_soon(self._rules())
        return self

    async def at(self, mhz: int) -> None:
        """From reset with a clock of so many MHz, each wire with a delay of its own."""
        self.clock.stop()
        self.clk_hz, self.period = mhz * 1_000_000, round(1e6 / mhz / 2) * 2
        self.ns = self.period / 1000
        self.clock = cocotb.clock.Clock(self.dut.clk_i, self.period, "ps", impl="gpi")
        self.clock.start()
        self.wires = {}
        for name in ("a", "am", "as_n", "ds_n", "write_n", "lword_n", "d", "iack_n", "iackin_n"):
            handle = getattr(self.bus, name)
            full = (1 << len(handle)) - 1
            self.level[name] = int(handle.value)
            early = self.random.randrange(1, full + 1)
            delays = [(m, self.random.randrange(2 * WIRE_PS)) for m in (early, full & ~early)]
            self.wires[name] = [(mask, ps) for mask, ps in delays if mask]
        self.dut.rst_ni.value = 0
        await self.clocks(4)
        self.dut.rst_ni.value = 1
        await self.clocks(4)
        await self.run(Cycle(0x6000 | VECTOR, VEC))
        await self.run(Cycle(0x6000 | PCCSR, ARMED | BASE))

    # -- time ----------------------------------------------------------------------------------

    def span(self, least: float, most: float) -> float:
        """ns between the two; every other time in whole clocks, if one is between them."""
        whole = range(-int(-least // self.ns), int(most // self.ns) + 1)
        if whole and self.random.random() < 0.5:
            return self.random.choice(whole) * self.ns
        return self.random.uniform(least, most)

    def around(self, clocks: int = 3) -> float:
        return self.span(-clocks * self.ns, clocks * self.ns)

    async def align(self) -> None:
        """To any time in a clock, every other time to just before or after its edge."""
        await RisingEdge(self.dut.clk_i)
        near = self.random.uniform(-3000, 500) - self.random.choice((0, WIRE_PS, 2 * WIRE_PS))
        far = self.random.uniform(0, self.period)
        ps = round(near if self.random.random() < 0.5 else far) % self.period
        await Timer(ps + self.period, "ps")

    async def play(self, text: str) -> None:
        """A line of stimulus, `pin=value` and ns to wait, each wire with its own delay."""
        at = self.now()
        for word in text.split():
            name, is_pin, value = word.partition("=")
            if is_pin:
                at_pin = [(at + ps, name, mask, int(value, 0)) for mask, ps in self.wires[name]]
                self.due += at_pin
            else:
                at += round(1000 * float(name))
        self.due.sort(key=lambda event: event[0])
        await self._until(at)

    async def _until(self, end: float) -> None:
        while self.due and self.due[0][0] <= end:
            at, name, mask, value = self.due.pop(0)
            await self._sleep(at)
            self.level[name] = self.level[name] & ~mask | value & mask
            getattr(self.bus, name).value = self.level[name]
        await self._sleep(end)

    async def _sleep(self, until: float) -> None:
        if until > self.now():
            await Timer(round(until - self.now()), "ps")

    async def arrived(self) -> None:
        """Until every wire has changed."""
        if self.due:
            await self._until(self.due[-1][0])

    def later(self, ns: float, **pins) -> None:
        """Inputs of the adaptor that are no wires of the bus."""

        async def change():
            if ns > 0:
                await Timer(round(1000 * ns), "ps")
            for name, level in pins.items():
                getattr(self.dut, name).value = level

        cocotb.start_soon(change())

    # -- cycles --------------------------------------------------------------------------------

    async def strobe(self, cycle: Cycle) -> None:
        self.cycle, self.answers, self.passes = cycle, 0, 0
        await self.play(f"ds_n={cycle.ds}")

    async def begin(self, cycle: Cycle) -> None:
        """Address, AS* and strobe as early as the standard lets a slave see them."""
        await self.play(f"{cycle.lines} {cycle.data_lines} 11 as_n=0")
        await self.strobe(cycle)

    async def answered(self, cycle: Cycle) -> int | None:
        """DTACK*, and the data of a read."""
        await self.arrived()
        if not self.answers:
            await First(FallingEdge(self.dut.vme_dtack_no), Timer(8, "us"))
        await Timer(1, "ns")
        assert not int(self.dut.vme_dtack_no.value), f"{cycle} is not answered"
        if cycle.data is not None:
            return None
        assert int(self.dut.vme_d_oe_o.value), f"{cycle}: DTACK* without data"
        return int(self.dut.vme_d_o.value)

    async def release(self, text: str = "ds_n=3 as_n=1") -> None:
        await self.play(text)
        await self.arrived()
        await self.free()

    async def free(self) -> None:
        """DTACK* is high."""
        if "ds_n" in self.wires and self.level["ds_n"] == 3:
            self.cycle = None
        if not int(self.dut.vme_dtack_no.value):
            end = Timer(1, "us")
            assert await First(RisingEdge(self.dut.vme_dtack_no), end) is not end, "DTACK* is low"

    async def finish(self, cycle: Cycle) -> int | None:
        """From the fall of the strobe on, address and AS* standing."""
        await self.strobe(cycle)
        data = await self.answered(cycle)
        if data is not None and not cycle.ack and cycle.address < 0x6400:
            assert data == (cycle.register & 0x1F) ^ 0x5A, f"{cycle} reads {data:02X}"
        await self.release()
        return data

    async def run(self, cycle: Cycle) -> int | None:
        await self.play(f"30 {cycle.lines} {cycle.data_lines} 11 as_n=0 11")
        return await self.finish(cycle)

    def expect(self, may: Cycle, *must: Cycle) -> None:
        """Writes on the PC bus: one that was begun at most once, then those that were answered."""
        want = [(c.register, c.data) for c in must if c.data is not None]
        begun = [(may.register, may.data)] if may.ours and may.data is not None else []
        assert self.written in (want, begun + want), f"{self.written}, not {want} after {begun}"
        self.written.clear()

    async def health(self) -> None:
        value = self.random.randrange(256)
        await self.run(Cycle(0x603F, value))
        assert self.written == [(0x31F, value)]
        await self.run(Cycle(0x6015))
        self.written.clear()

    async def request(self, on: bool) -> None:
        """Our interrupt request: PANIC latched, or nothing."""
        self.dut.estop_closed_i.value = 1
        await self.clocks(HEALTH_CLKS)
        await self.run(Cycle(0x6000 | PCCSR, BASE))
        await self.run(Cycle(0x6000 | PCCSR, ARMED | PANIC_IRQ | BASE))
        if on:
            self.dut.estop_closed_i.value = 0
            await self.clocks(HEALTH_CLKS)

    async def acknowledge(self, level: int, chain: float) -> bool:
        """An acknowledge cycle, IACKIN* so many ns after the strobe; whether we answer it."""
        cycle = Cycle(level, ack=True)
        await self.begin(cycle)
        await self.play(f"{chain} iackin_n=0")
        await self.arrived()
        for _ in range(400):
            if self.answers or self.passes:
                break
            await Timer(20, "ns")
        await Timer(self.random.randrange(1, 300), "ns")
        assert self.answers + self.passes == 1, f"{cycle}: {self.answers} answers"
        if self.answers:
            assert await self.answered(cycle) == VEC
        return bool(self.answers)

    async def acknowledged(self, rise: float) -> None:
        await self.release(f"ds_n=3 as_n=1 {rise} iackin_n=1")

    # -- rules ---------------------------------------------------------------------------------

    async def _rules(self) -> None:
        dut = self.dut
        pins = [dut.vme_dtack_no, dut.vme_d_oe_o, dut.vme_iackout_no, dut.vme_ds_ni, dut.vme_as_ni,
                dut.vme_iackin_ni]  # fmt: skip
        watch, dtack_was, out_was = Watch(*pins), 1, 1
        while True:
            await watch.settled()
            dtack, driven, out, ds, as_n, iackin = (int(pin.value) for pin in pins)
            cycle = self.cycle
            if dtack < dtack_was:
                ours = cycle is not None and (cycle.address == LEVEL if cycle.ack else cycle.ours)
                assert ds != 3 and ours, f"DTACK* falls in {cycle}"
                self.answers += 1
            assert dtack <= dtack_was or ds == 3 or not int(dut.vme_sysreset_ni.value), (
                "DTACK* rises before the strobes"
            )
            self.passes += out < out_was
            assert not (self.passes and self.answers), "passed on and answered"
            assert out or not (as_n or iackin), "IACKOUT* without AS* and IACKIN*"
            assert not driven or ds != 3, "data is driven without a strobe"
            if driven and cycle is not None and not cycle.ack:
                assert cycle.ours and cycle.data is None, f"data is driven in {cycle}"
            dtack_was, out_was = dtack, out


def edge_test(*ids: str):
    """A test of the adaptor's edges at every clock."""

    def mark(func):
        async def run(tb, mhz, **named):
            await tb.at(mhz)
            await func(tb, **named)

        run.__name__, run.__qualname__, run.__doc__ = func.__name__, func.__name__, func.__doc__
        return tests_on(Backplane)(*ids)(cocotb.parametrize(mhz=MHZ)(run))

    return mark


def any_next(tb: Backplane) -> Cycle:
    return tb.random.choice((NEXT_WRITE, READ))


@edge_test("VME-3")
async def strobes_apart(tb):
    """A cycle of another board, or one of ours withdrawn or answered; 30 ns later and more ours."""
    for name, first in (NEIGHBOURS | OURS | {"answered": WRITE}).items():
        for _ in range(CASES):
            await tb.align()
            await tb.begin(first)
            if name == "answered":
                await tb.answered(first)
            else:
                await tb.play(f"{tb.span(40, 1150)}")
            await tb.release()
            then = any_next(tb)
            await tb.play(f"{then.lines} {then.data_lines} {tb.span(30, 375)} as_n=0")
            await tb.finish(then)
            tb.expect(first, *([first] if name == "answered" else []), then)
            await tb.health()


@edge_test("VME-3")
async def address_pipelined(tb):
    """Our address and AS* come while the strobe of the cycle before, another's or ours, stands."""
    for name, first in (NEIGHBOURS | OURS).items():
        for _ in range(CASES):
            await tb.align()
            await tb.begin(first)
            if name in OURS:
                await tb.answered(first)
            else:
                await tb.play(f"{tb.span(40, 300)}")
            then = any_next(tb)
            await tb.play(f"as_n=1 {then.lines} 41 as_n=0 {tb.span(0, 375)}")
            assert len(tb.written) <= (first.ours and first.data is not None), f"after {name}"
            await tb.release("ds_n=3")
            await tb.play(f"{then.data_lines} {tb.span(30, 375)}")
            await tb.finish(then)
            tb.expect(first, *([first] if name in OURS else []), then)
            await tb.health()


@edge_test("VME-3")
async def block_of_a_neighbour(tb):
    """Strobes of 40 ns in a neighbour's block transfer, our address under the last of them."""
    other = NEIGHBOURS["another board's write"]
    for _ in range(CASES):
        await tb.align()
        await tb.begin(other)
        for _ in range(tb.random.randrange(6)):
            await tb.play(f"{tb.span(40, 70)} ds_n=3 30 {other.data_lines} 11 ds_n={other.ds}")
        then = any_next(tb)
        await tb.play(f"{tb.span(40, 70)} as_n=1 {then.lines} 41 as_n=0 {tb.span(0, 200)}")
        await tb.release("ds_n=3")
        await tb.play(f"{then.data_lines} 30")
        await tb.finish(then)
        tb.expect(other, then)
        await tb.health()


@edge_test("VME-3")
async def read_modify_write(tb):
    for _ in range(CASES):
        read, write = Cycle(0x602B), Cycle(0x602B, tb.random.randrange(256))
        await tb.align()
        await tb.begin(read)
        assert await tb.answered(read) == (0x15 ^ 0x5A)
        await tb.play(f"{tb.span(1, 60)}")
        await tb.release("ds_n=3")
        await tb.play(f"{write.data_lines} {tb.span(30, 375)}")
        await tb.finish(write)
        tb.expect(read, write)


@edge_test("VME-3")
async def strobes_of_a_word(tb):
    """AS* 10 ns after DS0* to 375 ns before it, DS1* within 20 ns of it at both ends."""
    word = Cycle(0x6030, 0x5B, ds=0)
    for _ in range(3 * CASES):
        await tb.align()
        early, apart = tb.span(-10, 375), tb.random.uniform(0, 20)
        first = tb.random.choice((1, 2))
        strobes = [(0, "as_n=0"), (early, f"ds_n={first}"), (early + apart, "ds_n=0")]
        text, at = f"{word.lines} {word.data_lines}", -22
        for ns, pin in sorted(strobes):
            text, at = f"{text} {ns - at} {pin}", ns
        tb.cycle, tb.answers = word, 0
        await tb.play(text)
        await tb.answered(word)
        await tb.release(f"ds_n={first} {apart} ds_n=3 as_n=1")
        tb.expect(word, word)
        await tb.health()


@edge_test("VME-3")
async def sysreset_around_a_strobe(tb):
    """Nothing is taken long after its fall, and nothing driven; afterwards all is well."""
    register = Cycle(0x6000 | PCCSR)  # is answered before SYSRESET* falls, or not
    for cycle in (WRITE, READ, register, NEIGHBOURS["another board's write"]):
        for _ in range(CASES):
            await tb.align()
            at = tb.span(-5 * tb.ns, 10 * tb.ns)
            tb.later(5 * tb.ns + 11 + at, vme_sysreset_ni=0)
            await tb.play(f"{5 * tb.ns}")
            await tb.begin(cycle)
            await tb.play(f"{16 * tb.ns + 10}")
            assert int(tb.dut.vme_dtack_no.value) and not int(tb.dut.vme_d_oe_o.value)
            await tb.play("ds_n=3 as_n=1")
            await tb.arrived()
            await tb.clocks(20)
            tb.cycle = None
            assert at > -4 * tb.ns or not tb.written, "taken in SYSRESET*"
            tb.dut.vme_sysreset_ni.value = 1
            await tb.clocks(6)
            tb.written.clear()
            await tb.run(Cycle(0x6000 | PCCSR, ARMED | BASE))
            await tb.health()


@edge_test("INT-2")
async def acknowledges_apart(tb):
    """Two acknowledges, AS* high for 30 ns and more between them: each has one answer, ours if we
    ask and the level is ours; IACKIN* by a fast driver, or late behind a board before us."""
    for asks in (True, False):
        await tb.request(asks)
        for levels in ((5, 5), (5, 3), (3, 5), (3, 3)):
            for _ in range(CASES // 2):
                await tb.align()
                for level in levels:
                    answered = await tb.acknowledge(level, tb.random.choice((11, tb.span(20, 200))))
                    assert answered == (asks and level == LEVEL), f"level {level}, we ask: {asks}"
                    await tb.acknowledged(tb.random.uniform(0, 20))
                    await tb.play(f"{tb.span(30, 375)}")


@edge_test("INT-2")
async def request_around_iackin(tb):
    """A request that comes up next to the fall of IACKIN*: answered or passed on, one of them."""
    for _ in range(2 * CASES):
        await tb.request(False)
        await tb.align()
        at, settles = tb.span(-6 * tb.ns, 3 * tb.ns), 5 * tb.ns + 10
        tb.later(6 * tb.ns + 11 + at, estop_closed_i=0)
        await tb.play(f"{6 * tb.ns}")
        answered = await tb.acknowledge(LEVEL, 11)
        assert answered or at > -settles, "a request that stood is passed on"
        assert not answered or at < 15, "a later request is answered"
        await tb.acknowledged(tb.random.uniform(0, 20))
        await tb.play("30")
        await tb.health()


@edge_test("INT-2", "VME-3")
async def data_and_acknowledge(tb):
    """A data cycle, ours or a neighbour's, an acknowledge, pipelined or not, and a data cycle."""
    await tb.request(True)
    ack, reads = Cycle(LEVEL, ack=True), tb.pc.reads
    for first, pipelined in product((WRITE, NEIGHBOURS["another board's write"]), (False, True)):
        for _ in range(CASES):
            await tb.align()
            await tb.begin(first)
            await (tb.answered(first) if first.ours else tb.play(f"{tb.span(40, 200)}"))
            if pipelined:
                await tb.play(f"as_n=1 {ack.lines} 41 as_n=0 {tb.span(0, 300)}")
            await tb.release("ds_n=3" if pipelined else "ds_n=3 as_n=1")
            await tb.play(f"{ack.lines} {ack.data_lines} {tb.span(30, 375)} as_n=0")
            await tb.strobe(ack)
            await tb.play("11 iackin_n=0")
            assert await tb.answered(ack) == VEC
            await tb.acknowledged(tb.random.uniform(0, 20))
            await tb.play(f"{NEXT_WRITE.lines} {NEXT_WRITE.data_lines} {tb.span(30, 375)} as_n=0")
            await tb.finish(NEXT_WRITE)
            tb.expect(first, *([first] if first.ours else []), NEXT_WRITE)
            assert tb.pc.reads == reads, "an acknowledge is taken for an access"


@edge_test("INT-1", "PAN-2")
async def button_around_the_arming_of_pccsr(tb):
    """The button opens next to the write that sets bit 7: latch and request agree."""
    arm = Cycle(0x6000 | PCCSR, ARMED | PANIC_IRQ | BASE)
    for _ in range(2 * CASES):
        await tb.run(Cycle(0x6000 | PCCSR, BASE))
        await tb.align()
        at = tb.span(-3 * tb.ns, 12 * tb.ns)
        tb.later(3 * tb.ns + 11 + at, estop_closed_i=0)
        await tb.play(f"{3 * tb.ns}")
        await tb.begin(arm)
        began = tb.now()
        await tb.answered(arm)
        took = (tb.now() - began) / 1000
        await tb.release()
        await tb.clocks(12)
        first, again = [await tb.run(Cycle(0x6000 | PCCSR)) for _ in range(2)]
        assert first == again
        latched = bool(first & PANIC_IRQ)
        assert latched == int(tb.dut.led_irq_o.value), "latch and request differ"
        assert latched or at < took + 10, "an edge under bit 7 is lost"
        assert not latched or at > 0 or took < 5 * tb.ns, "an edge before bit 7 is latched"
        assert int(tb.dut.panic_o.value) and not int(tb.dut.brake_release_o.value)
        tb.dut.estop_closed_i.value = 1
        await tb.clocks(12)
        assert not int(tb.dut.panic_o.value) and int(tb.dut.brake_release_o.value)
        await tb.health()


@edge_test("PAN-2", "VME-3")
async def link_lost_around_a_strobe(tb):
    """Cable or power goes in any part of an access: answered all the same, no command stays."""
    for line, cycle in product(LINES[1:], (WRITE, READ)):
        for _ in range(CASES):
            await tb.align()
            at = tb.span(-3 * tb.ns, 15 * tb.ns)
            tb.later(3 * tb.ns + 11 + at, **{line: 0})
            await tb.play(f"{3 * tb.ns}")
            await tb.begin(cycle)
            data = await tb.answered(cycle)
            assert data in (None, 0xFF, (READ.register & 0x1F) ^ 0x5A), f"{data:02X}"
            await tb.release()
            await tb.clocks(18)
            dut = tb.dut
            assert int(dut.panic_o.value) and not int(dut.brake_release_o.value)
            assert int(dut.pc_ior_no.value) and int(dut.pc_iow_no.value), "a command stays"
            getattr(dut, line).value = 1
            await tb.clocks(8)
            tb.written.clear()
            await tb.health()


@edge_test("PAN-1", "INT-1")
async def two_lines_of_panic(tb):
    """Two of button, cable and power change within three clocks: one rise of PANIC, latched."""
    dut = tb.dut
    rises = tb.times(RisingEdge, dut.panic_o)
    releases = tb.times(RisingEdge, dut.brake_release_o)
    for one, other in zip(LINES, LINES[1:] + LINES[:1], strict=True):
        for _ in range(CASES):
            await tb.request(False)
            for level in (0, 1):
                await tb.align()
                rises.clear(), releases.clear()
                tb.later(3 * tb.ns, **{one: level})
                tb.later(3 * tb.ns + tb.around(), **{other: level})
                await tb.clocks(24)
                assert int(dut.panic_o.value) == 1 - level
                assert len(rises) == 1 - level and len(releases) == level
            assert int(dut.led_irq_o.value), "not latched"
        await tb.health()
