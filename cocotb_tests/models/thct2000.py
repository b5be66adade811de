# SPDX-License-Identifier: Apache-2.0
"""Reference model of the THCT2000 incremental encoder chip. Report §5.3.1-5.3.2."""

PINS = (
    ("reset", 1), ("clk_en", 1), ("m", 3), ("a", 1), ("b", 1), ("latch", 1), ("cs_n", 1),
    ("rd_n", 1), ("wr_n", 1), ("rs", 1), ("d", 8), ("other", 1),
)  # fmt: skip
OUTS = (("d_o", 8), ("oe", 1), ("count", 16), ("illegal", 1))

UP = {0: 2, 2: 3, 3: 1, 1: 0}  # successor of (A, B) written as 2A+B when A leads B


class Thct2000:
    """`clock` returns a dict of what is defined in that clock."""

    def __init__(self) -> None:
        self.count = self.latch = self.buffer = 0
        self.latched = False
        self.illegal = 0
        self.pair = None  # the first access of a pair: (kind, byte address)
        self.write_byte = 0
        self.mode = 0
        self.sync = [0, 0, 0]
        self.captured = False  # modes 6, 7 handed a count over in this clock
        self._read = None
        self._write = None

    def _tick(self, mode: int, pins: int) -> None:
        """One CLK: count on what the synchroniser already holds, then shift it."""
        now, prev = self.sync[1], self.sync[2]
        a, b, a_was, b_was = now >> 1, now & 1, prev >> 1, prev & 1
        if now ^ prev == 3 and 1 <= mode <= 5:
            self.illegal = 1
        elif now != prev and 1 <= mode <= 5:
            a_moved = a != a_was
            counts = {1: a_moved and not b, 2: a_moved and b, 3: a_moved, 4: not a_moved, 5: True}
            if counts[mode]:
                self.count = (self.count + (1 if UP[prev] == now else -1)) & 0xFFFF
        if mode == 6:
            self._gate(a, a_was, a)
        elif mode == 7:
            self._gate(b, b_was, a and not a_was and b)
        self.sync = [pins, self.sync[0], self.sync[1]]

    def _gate(self, level: int, was: int, event: int) -> None:
        """Modes 6 and 7: count `event` while the gate is high, hand over when it falls."""
        if was and not level:
            self.latch, self.latched, self.count = self.count, True, 0
            self.captured = True
        elif event:
            self.count = (self.count + 1) & 0xFFFF

    def clock(self, word: int) -> dict:
        reset, clk_en, mode = word & 1, (word >> 1) & 1, (word >> 2) & 7
        pins = ((word >> 5) & 1) << 1 | (word >> 6) & 1
        latch, cs_n = (word >> 7) & 1, (word >> 8) & 1
        rd_n, wr_n, rs, data = (
            (word >> 9) & 1,
            (word >> 10) & 1,
            (word >> 11) & 1,
            word >> 12 & 0xFF,
        )
        other = word >> 20
        reading, writing = not (cs_n or rd_n), not (cs_n or wr_n)
        seen = {"oe": int(reading), "count": self.count, "illegal": self.illegal}
        if not reading:
            seen["d_o"] = 0xFF
        elif self._read == rs and not reset:
            seen["d_o"] = self.buffer & 0xFF if rs else self.buffer >> 8

        before = self.count, self.latch, self.latched
        self.captured = False
        if clk_en:
            self._tick(mode, pins)
        if reading and self._read is None:
            self._read = rs
            if self.pair == ("read", 1 - rs):
                self.pair = None
            else:
                self.pair = ("read", rs)
                self.buffer = before[1] if before[2] else before[0]
                if not self.captured:
                    self.latched = False
        elif not reading:
            self._read = None
        if latch:
            self.latch, self.latched = before[0], True
        if writing:
            self._write = (rs, data)
        elif self._write is not None:
            self._finish_write(*self._write)
            self._write = None
        if reset:
            self.count = self.latch = self.buffer = 0
            self.latched, self.illegal = False, 0
        if reset or other or mode != self.mode:
            self.pair = None
        self.mode = mode
        return seen

    def _finish_write(self, rs: int, data: int) -> None:
        both = self.pair == ("write", 1 - rs)
        rest = self.write_byte if both else self.count & 0xFF if rs == 0 else self.count >> 8
        self.count = rest << 8 | data if rs else data << 8 | rest
        self.write_byte = data
        self.pair = None if both else ("write", rs)
