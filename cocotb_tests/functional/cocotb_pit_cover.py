# SPDX-License-Identifier: Apache-2.0
"""Every mode, format and event of the 8254, each compared with the reference model. §4.3.4"""

from cocotb_tests.chips.pit import Pit
from cocotb_tests.chips.replay import Bench, mismatch
from cocotb_tests.functional import cover
from cocotb_tests.lib.req import test

TOPLEVEL = "bench_i8254"
SOURCES = ("../chips/bench_i8254.sv", "../chips/bench_replay.sv")


class Tour(Pit):
    """Takes one counter through all events in one mode and format."""

    def look(self, n: int) -> None:
        self.step(cs_n=0, rd_n=0, a=n)
        self.step(cs_n=1, rd_n=1)

    def look_all(self, n: int) -> None:
        for _ in range(2 if self.rw[n] == 3 else 1):
            self.look(n)

    def begin(self, n: int, code: int, rw: int, bcd: int, value: int) -> None:
        self.cw(n, code, rw, bcd)
        self.count(n, value)
        self.trigger(1 << n)
        self.pulse(2, 1 << n)

    def tour(self, n: int, code: int, rw: int, bcd: int) -> None:
        clk = 1 << n
        value, more = {1: (7, 9), 2: (0x0100, 0x0200), 3: (7, 9)}[rw]
        how = (n, code, rw, bcd, value)
        self.cw(n, code, rw, bcd)
        self.read_back(n, status=True)
        self.look(n)
        self.count(n, value)
        self.count(n, more)
        self.pulse(1, clk)
        self.trigger(clk)
        self.pulse(2, clk)
        self.read_back(n, status=True)
        self.look(n)
        self.look_all(n)
        self.latch(n)
        self.pulse(1, clk)
        self.latch(n)
        self.look_all(n)
        self.read_back(n, count=True)
        self.look_all(n)
        self.read_back(n, count=True, status=True)
        self.look(n)
        self.look_all(n)
        self.gate(0, clk)
        self.pulse(2, clk)
        self.gate(1, clk)
        self.pulse(2, clk)
        self.count(n, value)
        self.pulse(1, clk)
        if rw == 3:
            self.write(n, 5)
            self.look_all(n)
            self.pulse(1, clk)
            self.write(n, 0)
            self.look(n)
            self.count(n, value)
            self.look(n)
        self.pulse(1, clk)
        self.trigger(clk)
        self.pulse(value + 6 if rw != 2 else 3 * 256 + 6, clk)
        self.begin(*how)
        if rw == 3:
            self.write(n, 5)
            self.begin(*how)
            self.look(n)
            self.begin(*how)
        self.latch(n)
        self.begin(*how)
        self.cw(n, 0)


def form(cw: int) -> str:
    return ("low", "high", "both")[(cw >> 4) - 1] + (" bcd" if cw & 1 else "")


class Sampler:
    """Watches pins and the model's state and names the events of each clock."""

    def __init__(self, model) -> None:
        self.model = model
        self.found: list[tuple[int, int, str, str]] = []  # counter, mode, format, event

    def _add(self, n: int, event: str, cw: int | None = None) -> None:
        cw = self.model.counters[n].cw if cw is None else cw
        if cw & 0x30:
            self.found.append((n, cw >> 1 & 7, form(cw), event))

    def clock(self, word: int) -> int:
        model = self.model
        writing = not word & 0x1400
        reading = not word & 0x0C00
        if model._write is not None and not writing:
            self._written(*model._write)
        if model._read is not None and model._read < 3 and not reading:
            self._read(model._read)
        before = [(c.out, c.ce, c.loaded, c.gate) for c in model.counters]
        acts = model._write is not None and not writing
        seen = model.clock(word)
        for n, (c, (out, ce, loaded, gate)) in enumerate(zip(model.counters, before, strict=True)):
            if loaded and c.loaded:
                if gate != c.gate:
                    self._add(n, "gate rises" if c.gate else "gate falls")
                if ce == 0 and c.ce == (0x9999 if c.bcd else 0xFFFF):
                    self._add(n, "counts through zero")
            if c.loaded and not loaded:
                self._add(n, "load")
            if out != c.out and not acts:
                self._add(n, "out rises" if c.out else "out falls")
        return seen

    def _written(self, address: int, data: int) -> None:
        counters = self.model.counters
        if address < 3:
            self._count(address, counters[address])
        elif data >> 6 == 3:
            names = {0: "both", 1: "status", 2: "count"}
            for n in range(3):
                if data >> n + 1 & 1 and (what := names.get(data >> 4 & 3)):
                    self._add(n, f"read-back {what}")
        elif data & 0x30:
            n = data >> 6
            c = counters[n]
            self._add(n, "control", data & 0x3F)
            if c.loaded:
                self._add(n, "control while counting")
            if c.write_msb:
                self._add(n, "control between the bytes of a count")
            if c.read_msb:
                self._add(n, "control between the bytes of a read")
            if c.count_latch is not None:
                self._add(n, "control with the count latched")
        else:
            n = data >> 6
            again = counters[n].count_latch is not None
            self._add(n, "latch again" if again else "latch")

    def _count(self, n: int, c) -> None:
        if c.rw == 3 and not c.write_msb:
            if c.loaded:
                self._add(n, "first byte while counting")
            return
        if not c.armed:
            self._add(n, "count")
        elif not c.loaded:
            self._add(n, "count again before it is loaded")
        else:
            self._add(n, "count again while counting")
        if c.read_msb:
            self._add(n, "count between the bytes of a read")

    def _read(self, n: int) -> None:
        c = self.model.counters[n]
        if c.status_latch is not None:
            self._add(n, f"read status, null count {c.status_latch >> 6 & 1}")
        else:
            self._add(n, "read latched" if c.count_latch is not None else "read live")
        if c.write_msb:
            self._add(n, "read between the bytes of a count")


@test("PIT-1")
async def every_mode_format_and_event(dut):
    script = Tour()
    for counter in range(3):
        for code in range(8):
            for number, (rw, bcd) in enumerate((r, b) for r in (1, 2, 3) for b in (0, 1)):
                if counter == (code + number) % 3:
                    script.tour(counter, code, rw, bcd)
    script.step(2)
    sampler = Sampler(script.model())
    want = [sampler.clock(word) for word in script.words]
    got = await Bench(dut).replay(script.words)
    for at, (w, g) in enumerate(zip(want, got, strict=True)):
        if w != g:
            raise AssertionError(f"clock {at}: {mismatch(script.layout_out, w, g)}")
    for counter, code, which, event in sampler.found:
        if not cover.PIT.reason((str(code), which, event)):
            cover.PIT.hit(code, which, event)
        cover.PIT_COUNTER.hit(counter, event)
    cover.save()
    missed = [b for b in cover.PIT.bins() if b not in cover.PIT.hits]
    assert not missed, f"{len(missed)} bins never hit, among them {missed[:6]}"
    assert set(cover.PIT_COUNTER.bins()) == cover.PIT_COUNTER.hits
