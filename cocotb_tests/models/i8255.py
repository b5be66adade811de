# SPDX-License-Identifier: Apache-2.0
"""Reference model of the Intel 8255A. Report §5.3.1.

It is a function of settled pins: every call of `settle` is one state of the pins, held long enough
for handshakes to come to rest; successive calls differ by one strobe. Handshake outputs are the
level equations of the data sheet (INTR = OBF.INTE.ACK.WR + IBF.INTE.STB.RD). Bit set/reset writes
IBF, OBF# and INTR too; INTR keeps what was written until its equation changes or it is served.
"""

PINS = (
    ("reset", 1), ("cs_n", 1), ("rd_n", 1), ("wr_n", 1), ("a", 2), ("d", 8),
    ("pa", 8), ("pb", 8), ("pc", 8),
)  # fmt: skip
OUTS = (
    ("d_o", 8), ("oe", 1), ("pa", 8), ("pa_oe", 8), ("pb", 8), ("pb_oe", 8), ("pc", 8),
    ("pc_oe", 8),
)  # fmt: skip


class Group:
    """The strobed side of port A or B: latches, buffer flags and interrupt enables."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        self.out = 0  # output latch
        self.input = None  # input latch: undefined until its first strobe
        self.ibf = 0
        self.obf_n = 1
        self.inte_in = 0
        self.inte_out = 0
        self.intr_set = None  # written by bit set/reset
        self.intr = 0  # by its equation


class I8255:
    def __init__(self, control_readable: bool = False) -> None:
        self.control_readable = control_readable
        self.a, self.b = Group(), Group()
        self.pc = 0
        self._write = None
        self._read = None
        self._reset()

    def _reset(self) -> None:
        """A bus cycle under reset is none, also if both end at once."""
        self._write = self._read = None
        self._mode_set(0x9B)

    def _mode_set(self, word: int) -> None:
        self.control = word
        self.a.clear()
        self.b.clear()
        self.pc = 0

    # What the control word says.
    @property
    def mode_a(self) -> int:
        return min(self.control >> 5 & 3, 2)

    @property
    def mode_b(self) -> int:
        return self.control >> 2 & 1

    @property
    def a_in(self) -> int:
        return self.control >> 4 & 1

    @property
    def b_in(self) -> int:
        return self.control >> 1 & 1

    def _strobed(self) -> tuple[bool, bool, bool, bool]:
        """(A strobed in, A strobed out, B strobed in, B strobed out)"""
        mode_a = self.mode_a
        return (
            mode_a == 2 or (mode_a == 1 and bool(self.a_in)),
            mode_a == 2 or (mode_a == 1 and not self.a_in),
            bool(self.mode_b and self.b_in),
            bool(self.mode_b and not self.b_in),
        )

    def _plain_outputs(self) -> int:
        """Mask of port C bits that are ordinary outputs."""
        mask = (0 if self.control & 8 else 0xF0) | (0 if self.control & 1 else 0x0F)
        return mask & ~self._handshake()

    def _handshake(self) -> int:
        """Mask of port C bits that serve the strobed ports."""
        a_in, a_out, b_in, b_out = self._strobed()
        mask = 0
        if a_in:
            mask |= 0x38
        if a_out:
            mask |= 0xC8
        if b_in or b_out:
            mask |= 0x07
        return mask

    def plain_bits(self) -> int:
        """Port C bits free of any handshake (used by tests to choose legal stimulus)."""
        return 0xFF & ~self._handshake()

    def _write_end(self, addr: int, data: int) -> None:
        a_in, a_out, b_in, b_out = self._strobed()
        if addr == 3:
            if data & 0x80:
                self._mode_set(data)
            else:
                self._bit(data >> 1 & 7, data & 1)
        elif addr == 0:
            if a_out or not self.a_in:
                self.a.out = data
                if a_out:
                    self.a.obf_n = 0
        elif addr == 1:
            if not self.b_in:
                self.b.out = data
                if b_out:
                    self.b.obf_n = 0
        elif not self.mode_a and not self.mode_b:
            mask = self._plain_outputs()
            self.pc = (self.pc & ~mask) | (data & mask)

    def _bit(self, bit: int, value: int) -> None:
        a_in, a_out, b_in, b_out = self._strobed()
        if a_in and bit == 4:
            self.a.inte_in = value
        if a_out and bit == 6:
            self.a.inte_out = value
        if bit == 2 and b_in:
            self.b.inte_in = value
        if bit == 2 and b_out:
            self.b.inte_out = value
        if a_in and bit == 5:
            self.a.ibf = value
        if a_out and bit == 7:
            self.a.obf_n = value
        if bit == 1 and b_in:
            self.b.ibf = value
        if bit == 1 and b_out:
            self.b.obf_n = value
        if bit == 3 and (a_in or a_out):
            self.a.intr_set = value
        if bit == 0 and (b_in or b_out):
            self.b.intr_set = value
        if not (self._handshake() >> bit) & 1:
            self.pc = (self.pc & ~(1 << bit)) | (value << bit)

    def _read_end(self, addr: int) -> None:
        a_in, _, b_in, _ = self._strobed()
        if addr == 0 and a_in:
            self.a.ibf = 0
        if addr == 1 and b_in:
            self.b.ibf = 0

    def settle(self, word: int) -> dict:
        """Apply one settled state of the pins; returns the outputs after it."""
        pins, at = {}, 0
        for name, width in PINS:
            pins[name] = word >> at & ((1 << width) - 1)
            at += width
        selected = not pins["cs_n"]
        reading = bool(selected and not pins["rd_n"])
        writing = bool(selected and not pins["wr_n"])
        if not writing and self._write is not None:
            self._write_end(*self._write)
            self._write = None
        if not reading and self._read is not None:
            self._read_end(self._read)
            self._read = None
        if writing:
            self._write = (pins["a"], pins["d"])
        if reading:
            self._read = pins["a"]
        if pins["reset"]:
            self._reset()
        self._handshakes(pins)
        return self._outputs(pins, reading, writing)

    def _handshakes(self, pins: dict) -> None:
        a_in, a_out, b_in, b_out = self._strobed()
        pc = pins["pc"]
        if a_in and not pc & 0x10:
            self.a.input, self.a.ibf = pins["pa"], 1
        if a_out and not pc & 0x40:
            self.a.obf_n = 1
        if b_in and not pc & 0x04:
            self.b.input, self.b.ibf = pins["pb"], 1
        if b_out and not pc & 0x04:
            self.b.obf_n = 1

    @staticmethod
    def _intr(group: Group, by_equation: bool, served: bool) -> bool:
        if by_equation != group.intr or served:
            group.intr_set = None
        group.intr = by_equation
        return by_equation if group.intr_set is None else bool(group.intr_set)

    def _outputs(self, pins: dict, reading: bool, writing: bool) -> dict:
        a_in, a_out, b_in, b_out = self._strobed()
        pc_in, addr, a, b = pins["pc"], pins["a"], self.a, self.b
        read_a, read_b = reading and addr == 0, reading and addr == 1
        write_a, write_b = writing and addr == 0, writing and addr == 1
        intr_a = (a_in and a.ibf and a.inte_in and pc_in & 0x10 and not read_a) or (
            a_out and a.obf_n and a.inte_out and pc_in & 0x40 and not write_a
        )
        intr_b = (b_in and b.ibf and b.inte_in and pc_in & 4 and not read_b) or (
            b_out and b.obf_n and b.inte_out and pc_in & 4 and not write_b
        )
        served_a = (a_in and read_a) or (a_out and write_a)
        intr_a = self._intr(a, bool(intr_a), served_a)
        intr_b = self._intr(b, bool(intr_b), (b_in and read_b) or (b_out and write_b))
        # Port C pins driven, and what a read of port C shows (INTE where the strobes come in).
        out = self._plain_outputs()
        pc, status = self.pc & out, (self.pc & out) | (pc_in & ~out & 0xFF)
        hand = self._handshake()
        status &= ~hand
        driven = out
        if a_in:
            pc |= a.ibf << 5
            status |= a.ibf << 5 | a.inte_in << 4
            driven |= 0x20
        if a_out:
            pc |= a.obf_n << 7
            status |= a.obf_n << 7 | a.inte_out << 6
            driven |= 0x80
        if a_in or a_out:
            pc |= bool(intr_a) << 3
            status |= bool(intr_a) << 3
            driven |= 0x08
        if b_in or b_out:
            flag = b.ibf if b_in else b.obf_n
            inte = b.inte_in if b_in else b.inte_out
            pc |= flag << 1 | bool(intr_b)
            status |= flag << 1 | inte << 2 | bool(intr_b)
            driven |= 0x03
        drive_a = not pc_in & 0x40 if self.mode_a == 2 else not self.a_in
        seen = {
            "oe": int(reading), "pa_oe": 0xFF * drive_a, "pb_oe": 0xFF * (not self.b_in),
            "pc_oe": driven, "d_o": 0xFF, "pc": pc, "pc_mask": driven,
        }  # fmt: skip
        if drive_a:
            seen["pa"] = a.out
        if not self.b_in:
            seen["pb"] = b.out
        if reading:
            port_a = a.input if a_in else (pins["pa"] if self.a_in else a.out)
            port_b = b.input if b_in else (pins["pb"] if self.b_in else b.out)
            control = self.control if self.control_readable else 0xFF
            seen["d_o"] = (port_a, port_b, status, control)[addr]
            if seen["d_o"] is None:
                del seen["d_o"]
        return seen
