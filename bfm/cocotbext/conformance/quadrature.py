# SPDX-License-Identifier: Apache-2.0
"""A quadrature counter on an 8-bit bus: words of a script, and the rows of its description.

The report on MMCS (MS-CIS-89-17) describes the chip, a THCT2000, whose data sheet is lost: 16 bits
as two bytes, which a read samples together; after a latch the first read gives the latched count.
"""

from .script import LeftOut, Rows, Script

MSB, LSB = 0, 1
GREY = ((0, 0), (1, 0), (1, 1), (0, 1))  # (A, B) counting up


class Encoder(Script):
    SHEET = "16-bit quadrature counter on an 8-bit bus, as report MS-CIS-89-17 has it"
    PINS = (
        ("reset", 1), ("m", 3), ("a", 1), ("b", 1), ("latch", 1), ("cs_n", 1), ("rd_n", 1),
        ("wr_n", 1), ("rs", 1), ("d", 8),
    )  # fmt: skip
    OUTS = (("d_o", 8), ("oe", 1))
    IDLE = {
        "reset": 0, "m": 5, "a": 0, "b": 0, "latch": 0, "cs_n": 1, "rd_n": 1, "wr_n": 1, "rs": 0,
        "d": 0,
    }  # fmt: skip
    VARIANTS = ("x4", "thct2000")  # x4 counts every edge, and has no pins m
    ADDRESS = "rs"
    ROWS: list = []

    def __init__(self, variant: str = "") -> None:
        super().__init__(variant)
        self.phase = 0
        if self.variant == "x4":
            self.PINS = tuple(pin for pin in self.PINS if pin[0] != "m")
            self.now.pop("m")

    def mode(self, m: int) -> None:
        if self.variant == "x4":
            raise LeftOut
        self.step(5, m=m)

    def turn(self, steps: int, clocks: int = 1) -> None:
        """Quadrature steps, up or down, one every `clocks` clocks."""
        for _ in range(abs(steps)):
            self.phase = (self.phase + (1 if steps > 0 else -1)) % 4
            a, b = GREY[self.phase]
            self.step(clocks, a=a, b=b)

    def settle(self) -> None:
        """Lets the synchroniser empty."""
        self.step(4)

    def value(self, want: int, note: str = "", first: int = MSB) -> None:
        want &= 0xFFFF
        for rs in (first, 1 - first):
            self.read(rs, want & 0xFF if rs else want >> 8, f"{note} {'LSB' if rs else 'MSB'}")

    def init(self, value: int, first: int = MSB) -> None:
        for rs in (first, 1 - first):
            self.write(rs, value & 0xFF if rs else value >> 8)

    def latch(self) -> None:
        self.step(latch=1)
        self.step(latch=0)

    def count(self, want: int, note: str = "") -> None:
        """The count, after settling."""
        self.settle()
        self.value(want, note)


def discriminator(s: Encoder, mode: int, up: tuple[int, int, int, int]) -> None:
    """`up[k]`: does the k-th transition of an upward turn count in this mode."""
    s.mode(mode)
    want = 0
    for _ in range(2):
        for k in range(4):
            s.turn(1)
            want += up[k]
            s.count(want, f"up, transition {k}")
    for _ in range(3):
        for k in (3, 2, 1, 0):
            s.turn(-1)
            want -= up[k]
            s.count(want, f"down, transition {k}")


class Counting(Rows, of=Encoder, section="§5.3.1 Direction and count"):
    mode5_counts_up_when_a_leads = "turn(8) count(8)"
    mode5_counts_down_when_b_leads = "turn(-8) count(-8)"

    def mode5_every_edge_counts_once(s):
        for n in range(1, 10):
            s.turn(1)
            s.count(n)
        for n in range(8, -5, -1):
            s.turn(-1)
            s.count(n)

    wraps_upward = "init(0xFFFE) turn(1) count(0xFFFF) turn(1) count(0) turn(1) count(1)"
    wraps_downward = "init(1) turn(-1) count(0) turn(-1) count(0xFFFF) turn(-1) count(0xFFFE)"
    turning_in_reset_counts_nothing = """
        step(2, reset=1) turn(5, clocks=2) settle() step(2, reset=0) count(0)"""

    def all_illegal_transitions(s):
        want = 0
        for first in range(4):
            while s.phase != first:
                s.turn(1)
                want += 1
            a, b = GREY[first]
            s.step(4, a=1 - a, b=1 - b)
            s.step(4, a=a, b=b)
            s.count(want, f"from {GREY[first]}")


class Modes(Rows, of=Encoder, section="§5.3.1 Modes of the discriminator"):
    def mode0_holds(s):
        discriminator(s, 0, (0, 0, 0, 0))

    def mode1_counts_a_while_b_is_low(s):
        discriminator(s, 1, (1, 0, 0, 0))

    def mode2_counts_a_while_b_is_high(s):
        discriminator(s, 2, (0, 0, 1, 0))

    def mode3_counts_both_edges_of_a(s):
        discriminator(s, 3, (1, 0, 1, 0))

    def mode4_counts_both_edges_of_b(s):
        discriminator(s, 4, (0, 1, 0, 1))

    def mode5_counts_all_edges(s):
        discriminator(s, 5, (1, 1, 1, 1))

    mode_change_keeps_the_count = """
        turn(7) settle() mode(0) count(7, 'mode 0') mode(1) count(7, 'mode 1')
        mode(2) count(7, 'mode 2') mode(3) count(7, 'mode 3')
        mode(4) count(7, 'mode 4') mode(5) count(7, 'mode 5')"""


class Bytes(Rows, of=Encoder, section="§5.3.2 Count as two bytes"):
    written_value_is_read = """
        init(0x1234) value(0x1234) init(0xFFFF) value(0xFFFF) init(0x8001) value(0x8001) init(0)
        value(0)"""
    written_lsb_first = """
        init(0x1234, first=LSB) value(0x1234, first=LSB) init(0xA55A, first=LSB)
        value(0xA55A, first=LSB)"""
    bus_floats_unless_read = """
        init(0) step(2, cs_n=1, rd_n=0) floats() step(2, cs_n=0, rd_n=1)
        floats() step(cs_n=1)"""
    # MSB read, then the count passes a byte border, then LSB: both of one sample
    read_while_running_is_coherent = """
        init(0x12FF) read(MSB, 0x12) turn(3) settle() read(LSB, 0xFF) value(0x1302, 'live')"""
    read_lsb_first_is_coherent = """
        init(0x1300) read(LSB, 0x00) turn(-1) settle() read(MSB, 0x13) value(0x12FF, first=LSB)"""
    data_stands_still_during_a_read = """
        init(0x00FE) read(MSB, 0) read(LSB, 0xFE) step(3, cs_n=0, rd_n=0, rs=MSB) turn(1)
        seen('while the count runs', d_o=0) turn(1) seen('while the count runs', d_o=0) turn(1)
        seen('while the count runs', d_o=0) turn(1) seen('while the count runs', d_o=0) turn(1)
        seen('while the count runs', d_o=0) turn(1) seen('while the count runs', d_o=0)
        step(2, cs_n=1, rd_n=1) read(LSB, 0xFE)"""


class Latch(Rows, of=Encoder, section="§5.3.2 Latch"):
    reset_clears = """
        init(0x1234) latch() step(4, reset=1) step(2, reset=0) turn(2) settle()
        value(2, 'the latch flag is gone too')"""
    write_touches_no_latch = """
        init(77) latch() init(500) value(77, 'the latch survives a write') value(500)"""
    first_read_after_a_latch_gives_the_latched_count = """
        init(100) latch() turn(7) settle() value(100, 'latched') value(107, 'live')"""
    second_latch_overwrites = """
        init(100) latch() turn(5) settle() latch() turn(5) settle() value(105) value(110)"""
    latch_between_the_bytes_waits_for_the_next_pair = """
        init(0x10FF) read(MSB, 0x10) turn(1) settle() latch() turn(5) settle() read(LSB, 0xFF)
        value(0x1100, 'the latched one') value(0x1105, 'live')"""


class Silent(Rows, of=Encoder, section="Not in the report", silent=True):
    a_byte_read_again_samples_again = """
        init(0x10FF) read(MSB, 0x10) turn(1) settle() read(MSB, 0x11) turn(-1) settle()
        read(LSB, 0x00, 'of the second sample') value(0x10FF)"""

    def a_lone_byte_followed_by_the_other_takes_the_earlier_sample(s):
        """What remains: nothing came between to tell that they are no pair."""
        s.init(0x40FF)
        s.read(LSB, 0xFF)
        s.turn(1)
        s.settle()
        s.read(MSB, 0x40, "of the lone byte's sample")
        s.read(LSB, 0x00, "a new pair")
        s.read(MSB, 0x41)

    latch_during_a_read_is_not_lost = """
        init(0x2000) read(MSB, 0x20) read(LSB, 0x00) step(2, cs_n=0, rd_n=0, rs=MSB)
        step(2, latch=1) step(2, cs_n=1, rd_n=1, latch=0) read(LSB, 0x00) turn(3) settle()
        value(0x2000, 'latched during the read') value(0x2003)"""
