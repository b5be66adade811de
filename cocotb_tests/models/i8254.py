# SPDX-License-Identifier: Apache-2.0
"""Reference model of the Intel 8254 interval timer, one call per clock. Report §4.3.3-4.3.4.

Written from the data-sheet rules alone; it shares nothing with the RTL. What happens in one clock
is ordered: GATE as it stands, CLK rise, CLK fall, GATE low in modes 2 and 3, then the bus.
"""

PINS = (
    ("d", 8), ("a", 2), ("cs_n", 1), ("rd_n", 1), ("wr_n", 1), ("rise", 3), ("fall", 3),
    ("gate", 3),
)  # fmt: skip
OUTS = (("d_o", 8), ("oe", 1), ("out", 3), ("out_rise", 3), ("out_fall", 3))


def _bcd_minus_one(value: int) -> int:
    """One decade-wise decrement: a digit that was 0 becomes 9 and borrows."""
    for shift in (0, 4, 8, 12):
        if (value >> shift) & 0xF:
            return value - (1 << shift)
        value |= 9 << shift
    return value


class Counter:
    """One of the three counters: CR, CE, OL, the two byte flip-flops and the control logic."""

    def __init__(self, nmos: bool = True, split: bool = True) -> None:
        self.nmos = nmos
        self.split = split  # CR_L takes the first of two bytes at once
        self.cw = 0  # D5..D0 of the control word as last written
        self.mode = 0
        self.rw = 0
        self.bcd = 0
        self.cr = 0
        self.cr_low = 0  # first byte of a pair, until the second makes it a count
        self.cr_sampled = 0  # the count as it stood at the last CLK rise
        self.cr_late = False  # a count was written after that rise
        self.ce = 0
        self.out = 0
        self.null = 0
        self.read_msb = False
        self.write_msb = False
        self.count_latch = None
        self.status_latch = None
        self.armed = False  # a full count was written since the control word
        self.loaded = False  # and reached the counting element
        self.pending = False  # it waits for the next CLK rise
        self.trigger = False  # the GATE flip-flop
        self.load_sampled = False  # what the last CLK rise saw
        self.gate_sampled = False
        self.odd = False  # mode 3: parity of the count at its load
        self.stopped = False  # mode 0: the first byte of a pair stops counting until the load
        self.rolled = False  # the count has gone below 0 since its load
        self.strobe_due = False  # modes 4, 5: one strobe for each load
        self.strobing = False  # and it is being given
        self.gate = 0

    def clock(self, rise: int, fall: int, gate: int) -> None:
        """The CLK edges and the GATE level of one clock (the bus comes after)."""
        if gate != self.gate:
            self.gate = gate
            if gate and self.armed and self.mode not in (0, 4):
                self.trigger = True
        if rise:
            if self.pending or self.trigger:
                self.load_sampled = True
                self.pending = self.trigger = False
            self.gate_sampled = bool(gate)
            self.cr_sampled, self.cr_late = self.cr, False
        if fall:
            if self.load_sampled:
                self.load_sampled = False
                self._load()
            elif self.loaded:
                if self.strobing:  # the clock after a strobe ends it, whatever GATE is
                    self.out = 1
                    self.strobing = False
                if (self.gate_sampled or self.mode in (1, 5)) and not self.stopped:
                    self._count()
        if not gate and self.mode in (2, 3):
            self.out = 1

    def _load(self) -> None:
        mode, value = self.mode, self.cr_sampled
        if value == 1 and mode in (2, 3):
            value = 2 if mode == 2 else 0
        if mode == 3:
            self.odd = bool(value & 1)
            value &= 0xFFFE
        self.ce = value
        if not self.cr_late:
            self.null = 0
        self.loaded = True
        self.stopped = self.stopped and self.write_msb
        self.rolled = False
        if mode == 1:
            self.out = 0
        elif mode != 0:
            self.out = 1
        self.strobe_due = True
        self.strobing = False

    def _down(self) -> None:
        if self.ce == 0:
            self.rolled = True
        if self.bcd:
            self.ce = _bcd_minus_one(self.ce)
        else:
            self.ce = (self.ce - 1) & 0xFFFF

    def _count(self) -> None:
        mode = self.mode
        if mode == 2:
            if self.ce == 1:
                self._load()
            else:
                self._down()
                if self.ce == 1:
                    self.out = 0
        elif mode == 3:
            # The half cycle is OUT itself; with an odd count its high half lasts one CLK more.
            if self.ce == (0 if self.odd and self.out else 2):
                half = self.out ^ 1
                self._load()
                self.out = half
            else:
                self._down()
                self._down()
        else:
            self._down()
            if self.ce == 0:
                if mode == 0:
                    if not (self.pending or self.write_msb):
                        self.out = 1
                elif mode == 1:
                    self.out = 1
                elif self.strobe_due:
                    self.out = 0
                    self.strobing = True
                    self.strobe_due = False

    def control(self, word: int) -> None:
        """A control word with RW != 0: the control logic starts anew, CE keeps what it holds."""
        self.cw = word & 0x3F
        self.rw = (word >> 4) & 3
        self.mode = (word >> 1) & 7
        if self.mode > 5:
            self.mode -= 4
        self.bcd = word & 1
        self.out = 0 if self.mode == 0 else 1
        self.cr = self.cr_low = 0
        self.null = 1
        self.read_msb = self.write_msb = False
        self.count_latch = self.status_latch = None
        self.armed = self.loaded = self.pending = self.trigger = self.load_sampled = False
        self.strobe_due = self.strobing = self.stopped = False

    def write(self, data: int) -> None:
        if self.rw == 0:
            return
        if self.rw == 3 and not self.write_msb:
            self.write_msb = True
            self.cr_low = data
            if self.split:
                self.cr = self.cr & 0xFF00 | data
            if self.mode == 0:
                self.out = 0
                if self.nmos or not self.rolled:
                    self.stopped = True
            return
        self.cr = data if self.rw == 1 else data << 8 | (self.cr_low if self.rw == 3 else 0)
        self.cr_late = True
        self.write_msb = False
        self.null = 1
        self.armed = True
        first_done = self.loaded or self.load_sampled
        if self.mode in (0, 4) or (self.mode in (2, 3) and not first_done):
            self.pending = True
        if self.mode == 0:
            self.out = 0

    def latch_count(self) -> None:
        if self.count_latch is None:
            self.count_latch = self.ce

    def latch_status(self) -> None:
        if self.status_latch is None:
            self.status_latch = (self.out << 7) | (self.null << 6) | self.cw

    def peek(self) -> int:
        """The byte a read shows now."""
        if self.status_latch is not None:
            return self.status_latch
        value = self.ce if self.count_latch is None else self.count_latch
        if self.rw == 2 or (self.rw == 3 and self.read_msb):
            return value >> 8
        return value & 0xFF

    def read_end(self) -> None:
        if self.status_latch is not None:
            self.status_latch = None
            return
        if self.rw == 3:
            self.read_msb = not self.read_msb
            if self.read_msb:
                return
        self.count_latch = None


class I8254:
    """The chip: three counters and the bus. `clock` takes packed pins, one word per clock."""

    def __init__(self, nmos: bool = True, cascade: bool = False, split: bool = True) -> None:
        self.counters = [Counter(nmos, split) for _ in range(3)]
        self.cascade = cascade  # CLK1 = OUT0, CLK2 = OUT1, all in the same clock
        self._write = None  # (address, data) captured while WR# is low
        self._read = None  # address captured while RD# is low

    def _bus_write(self, addr: int, data: int) -> None:
        if addr < 3:
            self.counters[addr].write(data)
        elif (data >> 6) < 3:
            counter = self.counters[data >> 6]
            if data & 0x30:
                counter.control(data)
            else:
                counter.latch_count()
        else:
            for n, counter in enumerate(self.counters):
                if (data >> (n + 1)) & 1:
                    if not data & 0x20:
                        counter.latch_count()
                    if not data & 0x10:
                        counter.latch_status()

    def clock(self, word: int) -> int:
        """One clock: pins in, the outputs as they stand just before its edge."""
        counters = self.counters
        cs_low = not word & 0x400
        reading = cs_low and not word & 0x800
        writing = cs_low and not word & 0x1000
        addr = (word >> 8) & 3
        shown = 0x1FF if reading else 0xFF
        if reading and addr < 3:
            shown = 0x100 | counters[addr].peek()
        before = counters[0].out | (counters[1].out << 1) | (counters[2].out << 2)

        if self.cascade:
            counters[0].clock((word >> 13) & 1, (word >> 16) & 1, (word >> 19) & 1)
        else:
            for n in (0, 1, 2):
                rise, fall, gate = (word >> 13 + n) & 1, (word >> 16 + n) & 1, (word >> 19 + n) & 1
                if rise or fall or gate != counters[n].gate or not gate:
                    counters[n].clock(rise, fall, gate)
        done = None
        if writing:
            self._write = (addr, word & 0xFF)
        elif self._write is not None:
            done, self._write = self._write, None
        if self.cascade:
            # A bus write moves a counter's OUT in this clock too: it comes in chain order.
            for n in (1, 2):
                self._bus_to(done, n - 1)
                was, now = (before >> (n - 1)) & 1, counters[n - 1].out
                counters[n].clock(now & ~was & 1, was & ~now & 1, (word >> 19 + n) & 1)
            self._bus_to(done, 2)
            if done is not None and done[0] == 3 and done[1] >> 6 == 3:
                self._bus_write(*done)
        elif done is not None:
            self._bus_write(*done)
        if reading:
            self._read = addr
        elif self._read is not None:
            if self._read < 3:
                counters[self._read].read_end()
            self._read = None
        after = counters[0].out | (counters[1].out << 1) | (counters[2].out << 2)
        return shown | (before << 9) | ((after & ~before) << 12) | ((before & ~after) << 15)

    def _bus_to(self, done, n: int) -> None:
        """Cascade only: carry out `done` if it addresses counter n alone."""
        if done is not None and (done[0] == n or (done[0] == 3 and done[1] >> 6 == n)):
            self._bus_write(*done)
