# SPDX-License-Identifier: Apache-2.0
# Length: many short cases of one chip, read one at a time.
"""Intel 8254 (231164), 82C54 (231244) and 8253: words of a script, and the rows of the sheet."""

from .script import LeftOut, Rows, Script

LSB, MSB, BOTH = 1, 2, 3


class Pit(Script):
    SHEET = "Intel 8254 (231164), 82C54 (231244) and 8253"
    PINS = (("cs_n", 1), ("rd_n", 1), ("wr_n", 1), ("a", 2), ("d", 8), ("clk", 3), ("gate", 3))
    OUTS = (("d_o", 8), ("oe", 1), ("out", 3))
    IDLE = {"cs_n": 1, "rd_n": 1, "wr_n": 1, "a": 0, "d": 0, "clk": 0, "gate": 7}
    VARIANTS = ("nmos", "chmos", "8253")
    ROWS: list = []

    def __init__(self, variant: str = "") -> None:
        super().__init__(variant)
        self.rw = [0, 0, 0]

    def write(self, addr: int, data: int) -> None:
        if self.variant == "8253" and addr == 3 and data >= 0xC0:
            raise LeftOut  # it has no read-back command
        super().write(addr, data)

    def cw(self, n: int, mode: int, rw: int = BOTH, bcd: int = 0) -> None:
        self.rw[n] = rw
        self.write(3, n << 6 | rw << 4 | mode << 1 | bcd)

    def count(self, n: int, value: int) -> None:
        if self.rw[n] & LSB:
            self.write(n, value & 0xFF)
        if self.rw[n] & MSB:
            self.write(n, value >> 8)

    def program(self, mode: int, value: int, n: int = 0, rw: int = BOTH, bcd: int = 0) -> None:
        self.cw(n, mode, rw, bcd)
        self.count(n, value)

    def latch(self, n: int) -> None:
        self.write(3, n << 6)

    def read_back(self, n: int, count: bool = False, status: bool = False) -> None:
        self.write(3, 0xC0 | (not count) << 5 | (not status) << 4 | 2 << n)

    def value(self, n: int, want: int, note: str = "") -> None:
        """The count, read in the counter's format (latched before if `latch` was used)."""
        if self.rw[n] & LSB:
            self.read(n, want & 0xFF, f"{note} LSB")
        if self.rw[n] & MSB:
            self.read(n, want >> 8, f"{note} MSB")

    def status(self, n: int, out: int, null: int, low: int, note: str = "status") -> None:
        self.read_back(n, status=True)
        self.read(n, out << 7 | null << 6 | low, note)

    def pulse(self, times: int = 1, mask: int = 1) -> None:
        for _ in range(times):
            self.rise(mask)
            self.fall()

    def rise(self, mask: int = 1) -> None:
        self.step(clk=mask)

    def fall(self) -> None:
        self.step(clk=0)

    def gate(self, level: int, mask: int = 1) -> None:
        self.step(gate=(self.now["gate"] & ~mask) | (mask if level else 0))

    def trigger(self, mask: int = 1) -> None:
        self.gate(0, mask)
        self.gate(1, mask)

    def out(self, want: int, n: int = 0, note: str = "") -> None:
        """OUT of counter n (compared alone) after the last step."""
        self.expect(note or f"OUT{n}", **{f"out{n}": want})

    def word(self, word: str) -> None:
        """A pair of golden(), or a string of outs()."""
        (self.golden if ":" in word else self.outs)(word)

    def golden(self, text: str, n: int = 0) -> None:
        """`OUT:CE OUT:CE …`, one pair for each CLK pulse; CE read through the counter latch."""
        for at, pair in enumerate(text.split()):
            out, ce = pair.split(":")
            self.pulse(mask=1 << n)
            note = f"pulse {at + 1} ({pair})"
            self.out(int(out), n, note)
            self.latch(n)
            self.value(n, int(ce, 16), note)

    def outs(self, text: str, n: int = 0) -> None:
        """OUT after each CLK pulse, as a string of 0 and 1."""
        for at, level in enumerate(text.replace(" ", "")):
            self.pulse(mask=1 << n)
            self.out(int(level), n, f"OUT{n} after pulse {at + 1}")


class Mode0(Rows, of=Pit, section="Mode 0: interrupt on terminal count"):
    mode0_golden_n3 = """
        cw(0, 0) out(0) count(0, 3) 0:3 0:2 0:1 1:0 1:FFFF
        1:FFFE"""
    mode0_golden_n1 = "program(0, 1) 0:1 1:0 1:FFFF"
    mode0_golden_bcd = """
        program(0, 0x10, bcd=1) 0:10 0:09 0:08 0:07 0:06 0:05 0:04 0:03 0:02 0:01 1:00 1:9999
        1:9998"""
    mode0_zero_is_65536 = """
        program(0, 0) pulse(65536) out(0) pulse()
        out(1)"""
    mode0_zero_is_10000_in_bcd = "program(0, 0, bcd=1) pulse(10000) out(0) pulse() out(1)"
    mode0_gate_stops_the_count_not_out = """
        program(0, 4) 0:4 0:3 gate(0) 0:3 0:3 0:3 gate(1) 0:2 0:1 1:0 gate(0) 1:0 1:0"""
    # Loaded on the next CLK all the same; OUT rises N CLKs after GATE, no extra one
    mode0_loads_while_gate_is_low = "cw(0, 0) gate(0) count(0, 3) 0:3 0:3 gate(1) 0:2 0:1 1:0"
    mode0_new_count_lowers_out = """
        program(0, 2) 001 count(0, 3) out(0) 0:3 0:2 0:1 1:0"""
    mode0_count_written_twice = "program(0, 9) count(0, 2) 0:2 0:1 1:0"


class NmosRewrite(
    Rows, of=Pit, section="Mode 0: interrupt on terminal count", only=("nmos", "8253")
):
    # The NMOS part: OUT falls and counting stops with the first byte
    mode0_first_byte_stops_counting = """
        program(0, 5) 0:5 0:4 write(0, 3) 0:4 0:4 0:4 write(0, 0) 0:3 0:2 0:1 1:0 write(0, 2)
        out(0, note='OUT falls with the first byte') 0:0 0:0"""


class ChmosRewrite(Rows, of=Pit, section="Mode 0: interrupt on terminal count", only=("chmos",)):
    # OUT falls with the first byte; counting stops, but not after a rollover
    mode0_first_byte_in_chmos = """
        program(0, 5) 0:5 0:4 write(0, 9) 0:4 0:4 write(0, 0) 0:9 0:8 count(0, 1) 0:1 1:0
        write(0, 2) 0:0 0:0 write(0, 0) 0:2 0:1 1:0 1:FFFF write(0, 7) 0:FFFE 0:FFFD write(0, 0)
        0:7 0:6"""


class Mode1(Rows, of=Pit, section="Mode 1: hardware retriggerable one-shot"):
    mode1_golden_n3 = "program(1, 3) out(1) trigger() 0:3 0:2 0:1 1:0 1:FFFF"
    mode1_shortest_pulse = "program(1, 1) trigger() 0:1 1:0 1:FFFF"
    # As on the adaptor, where GATE is tied high
    mode1_without_trigger_stays_high = "program(1, 2) 11111111"
    mode1_retrigger_extends = "program(1, 4) trigger() 0:4 0:3 0:2 trigger() 0:4 0:3 0:2 0:1 1:0"
    mode1_new_count_waits_for_a_trigger = """
        program(1, 3) trigger() 0:3 0:2 count(0, 5) 0:1 1:0 1:FFFF trigger() 0:5 0:4 0:3 0:2 0:1
        1:0"""
    mode1_gate_low_does_not_stop = "program(1, 3) trigger() 0:3 gate(0) 0:2 0:1 1:0"
    mode1_trigger_before_the_count_is_ignored = "cw(0, 1) trigger() count(0, 2) 1111"
    # GATE up and down again before the CLK rise: the flip-flop remembers it
    mode1_short_gate_pulse_is_not_lost = "gate(0) program(1, 2) gate(1) gate(0) step(3) 0:2 0:1 1:0"


class Mode2(Rows, of=Pit, section="Mode 2: rate generator"):
    mode2_golden_n3 = "cw(0, 2) out(1) count(0, 3) 1:3 1:2 0:1 1:3 1:2 0:1 1:3"
    mode2_golden_n2 = "program(2, 2) 1:2 0:1 1:2 0:1"
    mode2_bcd = """
        program(2, 0x11, bcd=1) 1:11 1:10 1:09 1:08 1:07 1:06 1:05 1:04 1:03 1:02 0:01 1:11"""
    mode2_zero_is_65536 = "program(2, 0) pulse(65535) out(1) pulse() out(0) pulse() out(1)"
    mode2_gate_low_raises_out_at_once = """
        program(2, 3) 110 gate(0) out(1) 1:1 1:1 gate(1) 1:3 1:2 0:1 1:3"""
    mode2_trigger_reloads = "program(2, 4) 1:4 1:3 trigger() 1:4 1:3 1:2 0:1 1:4"
    mode2_new_count_waits_for_the_period = """
        program(2, 4) 1:4 1:3 count(0, 3) 1:2 0:1 1:3 1:2 0:1 1:3"""
    mode2_new_count_at_a_trigger = "program(2, 9) 1:9 1:8 count(0, 3) trigger() 1:3 1:2 0:1 1:3"
    mode2_is_also_mode6 = """
        program(6, 3) 1:3 1:2 0:1 1:3 status(0, 1, 0, 0x3C, 'M2 is returned as written')"""


class Mode3(Rows, of=Pit, section="Mode 3: square wave mode"):
    mode3_golden_n4 = "cw(0, 3) out(1) count(0, 4) 1:4 1:2 0:4 0:2 1:4 1:2 0:4 0:2"
    mode3_golden_n2 = "program(3, 2) 1:2 0:2 1:2 0:2"
    mode3_golden_n5 = "program(3, 5) 1:4 1:2 1:0 0:4 0:2 1:4 1:2 1:0 0:4"
    mode3_golden_n3 = "program(3, 3) 1:2 1:0 0:2 1:2 1:0 0:2"
    mode3_golden_bcd = """
        program(3, 0x10, bcd=1) 1:10 1:08 1:06 1:04 1:02 0:10 0:08 0:06 0:04 0:02 1:10"""
    mode3_zero_is_65536 = """
        program(3, 0) pulse(32768) out(1) pulse() out(0) pulse(32767) out(0) pulse() out(1)"""
    mode3_gate_low_raises_out_at_once = """
        program(3, 6) 1110 gate(0) out(1) 1:6 1:6 gate(1) 1:6 1:4 1:2 0:6"""
    mode3_new_count_at_the_half_cycle = "program(3, 6) 1:6 1:4 count(0, 4) 1:2 0:4 0:2 1:4 1:2 0:4"
    # An odd count written into an even half cycle must not disturb it, nor the other way
    mode3_parity_is_latched_at_the_load = """
        program(3, 6) 1:6 count(0, 5) 1:4 1:2 0:4 count(0, 4) 0:2 1:4 1:2 0:4 count(0, 5) 0:2 1:4
        count(0, 4) 1:2 1:0 0:4 0:2 1:4 1:2 0:4"""
    mode3_is_also_mode7 = "program(7, 4) 1:4 1:2 0:4 0:2 1:4 status(0, 1, 0, 0x3E)"


class Mode4(Rows, of=Pit, section="Mode 4: software triggered strobe"):
    mode4_golden_n3 = "cw(0, 4) out(1) count(0, 3) 1:3 1:2 1:1 0:0 1:FFFF"
    mode4_golden_n1 = "program(4, 1) 1:1 0:0 1:FFFF"
    mode4_new_count_retriggers = "program(4, 3) 1:3 1:2 count(0, 4) 1:4 1:3 1:2 1:1 0:0 1:FFFF"
    mode4_first_byte_has_no_effect = "program(4, 4) 1:4 1:3 write(0, 6) 1:2 1:1 write(0, 0) 1:6 1:5"
    mode4_gate_stops_the_count = "program(4, 2) 1:2 gate(0) 1:2 1:2 gate(1) 1:1 0:0"
    mode4_strobe_ends_whatever_gate_is = """
        program(4, 2) 1:2 1:1 0:0 gate(0) out(0) 1:0 1:0"""


class Mode5(Rows, of=Pit, section="Mode 5: hardware triggered strobe"):
    mode5_golden_n3 = "program(5, 3) trigger() 1:3 1:2 1:1 0:0 1:FFFF"
    mode5_retrigger = "program(5, 3) trigger() 1:3 1:2 trigger() 1:3 1:2 1:1 0:0 1:FFFF"
    mode5_trigger_on_the_strobe_reloads = "program(5, 1) trigger() 1:1 0:0 trigger() 1:1 0:0 1:FFFF"
    mode5_without_trigger_never_strobes = "program(5, 2) 1111111"
    mode5_gate_level_does_not_matter = "program(5, 3) trigger() gate(0) 1:3 1:2 1:1 0:0 1:FFFF"


class Counters(Rows, of=Pit, section="Operation common to all modes"):
    # A count written after the CLK rise waits for the next rise and fall
    load_needs_a_full_pulse = """
        cw(0, 4) rise() count(0, 2) fall() status(0, 1, 1, 0x38, 'half a pulse is none') 1:2 1:1
        0:0"""
    count_moves_on_the_fall = """
        program(2, 9) pulse() rise() latch(0) value(0, 9, 'after the rise') fall() latch(0)
        value(0, 8, 'after the fall')"""
    bcd_borrows_through_all_digits = """
        program(4, 0x1000, bcd=1) 1:1000 1:0999 1:0998 program(4, 0x2, bcd=1) 1:2 1:1 0:0 1:9999
        1:9998 program(4, 0x5010, bcd=1) pulse(12) latch(0) value(0, 0x4999)"""

    def three_counters_run_apart(s):
        s.program(2, 3, n=0)
        s.program(3, 4, n=1)
        s.program(0, 2, n=2)
        for levels in ("110", "110", "001", "101", "111"):
            s.pulse(mask=7)
            for n in range(3):
                s.out(int(levels[n]), n)

    control_word_disarms_counting = "program(2, 0x0050) pulse(3) cw(0, 2) 1:4E 1:4E 1:4E"

    def initial_out_of_each_mode(s):
        for mode in (0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7):
            s.cw(0, mode)
            s.out(int(mode != 0), note=f"mode {mode}, no CLK")

    def control_word_in_the_low_phase(s):
        """Mode set while OUT is low, in modes 2, 3, 4, 5: OUT rises at once, no CLK."""
        for mode, pulses in ((2, 3), (3, 3), (4, 4), (5, 4)):
            s.program(mode, 3)
            s.trigger()
            s.pulse(pulses)
            s.out(0, note=f"mode {mode}")
            s.cw(0, mode)
            s.out(1, note=f"mode {mode} again")

    gate_is_sampled_on_the_rise = """
        program(0, 9) pulse() rise() gate(0) fall() latch(0)
        value(0, 8, 'GATE fell after the rise') rise() gate(1) fall() latch(0)
        value(0, 8, 'GATE rose after the rise')"""


class Writes(Rows, of=Pit, section="Write operations"):
    bus_floats_unless_read = """
        program(2, 5) step(rd_n=0, a=0) floats('CS# high') step(rd_n=1)
        step(cs_n=0) floats('RD# high') step(cs_n=1)"""
    write_needs_chip_select = """
        program(2, 3) step(2, wr_n=0, a=3, d=0x30) step(2, wr_n=1)
        out(1, note='the mode 0 word went elsewhere') 1:3 1:2 0:1"""
    write_takes_effect_when_the_strobe_ends = """
        program(2, 3) step(3, cs_n=0, wr_n=0, a=3, d=0x30) out(1, note='WR# still low')
        step(cs_n=1, wr_n=1) out(0, note='mode 0')"""
    last_data_of_the_strobe_counts = """
        cw(0, 4, rw=LSB) step(2, cs_n=0, wr_n=0, a=0, d=9) step(d=2) step(wr_n=1) step(cs_n=1)
        1:2 1:1 0:0"""

    lsb_only_format = """
        program(2, 0x12, rw=LSB) pulse() read(0, 0x12) read(0, 0x12, 'again the LSB')"""
    msb_only_format = """
        program(2, 0x3400, rw=MSB) pulse() read(0, 0x34) pulse() read(0, 0x33, '3400h - 1')"""
    two_byte_format_alternates = """
        program(2, 0x1234) pulse() read(0, 0x34) read(0, 0x12) read(0, 0x34) read(0, 0x12)"""
    # After 1234h in both bytes, an LSB-only count has MSB 0 and an MSB-only one LSB 0
    control_word_clears_the_other_byte = """
        program(2, 0x1234) pulse(2) program(4, 0x02, rw=LSB) 110 program(2, 0x1234)
        program(2, 0x0100, rw=MSB) pulse() latch(0) read(0, 0x01) pulse()
        read(0, 0x00, '0100h - 1')"""
    control_word_resets_the_byte_flip_flops = """
        program(2, 0x1234) pulse() read(0, 0x34) write(0, 0x77) cw(0, 2) count(0, 0x0506) pulse()
        read(0, 0x06) read(0, 0x05)"""
    msb_only_count_has_a_zero_low_byte = """
        program(2, 0x0200, rw=MSB) pulse(512) out(0) pulse() out(1)"""
    counters_program_in_any_order = """
        cw(0, 2) cw(1, 4) cw(2, 3) write(0, 3) write(2, 4) write(1, 2) write(2, 0) write(1, 0)
        write(0, 0) 1:3 1:2 0:1 1:3 golden('1:2 1:1 0:0', n=1) golden('1:4 1:2 0:4', n=2)"""


class Reads(Rows, of=Pit, section="Counter latch command"):
    # rd LSB, wr LSB, rd MSB, wr MSB of one counter is legal
    reads_and_writes_interleave = """
        program(4, 0x1234) pulse() read(0, 0x34) write(0, 0x78) read(0, 0x12) write(0, 0x56)
        1:5678 1:5677"""
    count_latch_holds_until_read = """
        program(2, 0x1234) pulse(5) latch(0) pulse(0x40) value(0, 0x1230)
        value(0, 0x11F0, 'live again')"""
    second_count_latch_is_ignored = """
        program(2, 0x1234) pulse(5) latch(0) pulse(3) latch(0) value(0, 0x1230) value(0, 0x122D)"""
    latch_waits_for_both_bytes = """
        program(2, 0x1234) pulse(5) latch(0) read(0, 0x30) pulse(0x40) latch(0) read(0, 0x12)
        value(0, 0x11F0)"""
    latch_in_single_byte_format = """
        program(2, 0x50, rw=LSB) pulse(2) latch(0) pulse() read(0, 0x4F) read(0, 0x4E)"""
    # The low bits of a latch command are don't-care
    latch_does_not_change_the_mode = """
        program(2, 3) pulse() write(3, 0x0B) value(0, 3) 1:2 0:1 1:3 status(0, 1, 0, 0x34)"""

    def latches_of_three_counters_are_apart(s):
        for n, value in enumerate((0x1111, 0x2222, 0x3333)):
            s.program(2, value, n=n)
        s.pulse(mask=7)
        s.latch(0)
        s.pulse(mask=7)
        s.latch(2)
        s.pulse(mask=7)
        s.value(1, 0x2220)
        s.value(2, 0x3332)
        s.value(0, 0x1111)

    control_word_releases_the_latches = """
        program(2, 0x1234) pulse() read_back(0, count=True, status=True) program(4, 0x0042)
        pulse() value(0, 0x0042)"""


class ReadBack(Rows, of=Pit, section="Read-back command and status"):
    def read_back_latches_several_counts(s):
        for n, value in enumerate((0x1111, 0x2222, 0x3333)):
            s.program(2, value, n=n)
        s.pulse(mask=7)
        s.write(3, 0xC0 | 0x10 | 0b1010)
        s.pulse(mask=7)
        s.value(0, 0x1111)
        s.value(1, 0x2221, "counter 1 was not selected")
        s.value(2, 0x3333)

    read_back_status_then_count = """
        program(3, 0x0104) pulse() read_back(0, count=True, status=True) pulse()
        read(0, 0xB6, 'status first') read(0, 0x04) read(0, 0x01) read(0, 0x02, 'live')"""
    status_comes_first_whatever_was_latched_first = """
        program(2, 0x0105) pulse() latch(0) read_back(0, status=True) read(0, 0xB4, 'status')
        value(0, 0x0105)"""
    # Reading status neither moves the byte flip-flop nor frees the latched count
    status_between_two_bytes = """
        program(2, 0x1234) pulse() latch(0) read(0, 0x34) status(0, 1, 0, 0x34) pulse(0x80)
        read(0, 0x12, 'still the latched MSB') value(0, 0x11B4)"""
    second_status_latch_is_ignored = """
        program(2, 3) read_back(0, status=True) 110 read_back(0, status=True)
        read(0, 0xF4, 'OUT and null count as of the first') status(0, 0, 0, 0x34)"""
    # COUNT# and STATUS# both high: no latch
    read_back_of_nothing = "program(2, 0x0205) pulse() write(3, 0xFE) pulse() value(0, 0x0204)"

    def read_back_table_of_the_data_sheet(s):
        """Six read-back commands in order; what a latch already holds is not replaced."""
        for n, value in enumerate((0x1010, 0x2020, 0x3030)):
            s.program(2, value, n=n)
        s.pulse(mask=7)
        for command in (0xC2, 0xE4, 0xEC, 0xD8, 0xC4, 0xE2):
            s.write(3, command)
            s.pulse(mask=7)
        s.read(1, 0xB4, "status 1 as of E4h")
        s.value(1, 0x201C, "count 1 as of C4h")
        s.read(2, 0xB4, "status 2 as of ECh")
        s.value(2, 0x302D, "count 2 as of D8h")
        s.read(0, 0xB4, "status 0 as of C2h")
        s.value(0, 0x1010, "count 0 as of C2h")

    def status_returns_the_control_word(s):
        for rw in (LSB, MSB, BOTH):
            for mode in range(8):
                for bcd_bit in (0, 1):
                    s.cw(1, mode, rw, bcd_bit)
                    low = rw << 4 | mode << 1 | bcd_bit
                    s.status(1, int(mode != 0), 1, low, f"status of {low:#x}")

    null_count_rises_and_falls = """
        cw(0, 2) status(0, 1, 1, 0x34, 'after the control word') count(0, 3)
        status(0, 1, 1, 0x34, 'after the count') pulse() status(0, 1, 0, 0x34, 'after the load')"""
    null_count_needs_the_second_byte = """
        program(4, 0x0105) pulse() write(0, 7) status(0, 1, 0, 0x38, 'one byte') write(0, 0)
        status(0, 1, 1, 0x38, 'both') pulse() status(0, 1, 0, 0x38, 'loaded')"""
    null_count_waits_for_the_reload = """
        program(2, 3) pulse(2) count(0, 4) status(0, 1, 1, 0x34) pulse()
        status(0, 0, 1, 0x34, 'the period is not over') pulse() status(0, 1, 0, 0x34, 'reloaded')"""
    null_count_waits_for_a_trigger = """
        program(1, 3) pulse(4) status(0, 1, 1, 0x32) trigger() pulse() status(0, 0, 0, 0x32)"""


class Silent(Rows, of=Pit, section="Not in the sheet", silent=True):
    mode2_one_acts_as_two = "program(2, 1) 1:2 0:1 1:2 0:1"
    mode3_one_acts_as_zero = """
        program(3, 1, bcd=1) pulse(5000) out(1) pulse() out(0) pulse(5000) out(1)"""

    def mode4_gives_one_strobe_only(s):
        s.program(4, 2, rw=LSB)
        s.golden("1:2 1:1 0:0 1:FF")
        for _ in range(65540):
            s.pulse()
            s.out(1, note="no second strobe")

    # The flip-flop stays: the next byte is the MSB of the new latch, which frees it
    latch_between_the_bytes_of_a_read = """
        program(2, 0x1234) pulse() read(0, 0x34) latch(0) pulse(0x40) read(0, 0x12)
        value(0, 0x11F4)"""
    count_while_null_is_the_old_one = """
        program(2, 0x0050) pulse(3) cw(0, 2) value(0, 0x004E, 'CE keeps its value')
        count(0, 0x0099) value(0, 0x004E) pulse() value(0, 0x0099)"""
    # Written while the last CLK is high: its fall ends the old count, and OUT stays low
    mode0_count_written_as_the_old_one_ends = """
        program(0, 2, rw=LSB) pulse(2) rise() count(0, 3) fall()
        out(0, note='the old count is over') 00011"""


class SplitCount(Rows, of=Pit, section="Not in the sheet", only=("nmos",), silent=True):
    def mode0_first_byte_stops_after_a_late_load(s):
        """A count that waits for its CLK is loaded; the first byte of the next one stops it."""
        s.program(0, 5)
        s.write(0, 3)
        s.golden("0:3 0:3 0:3")  # CR_L has it already
        s.write(0, 0)
        s.golden("0:3 0:2 0:1 1:0")

    # Modes 2 and 3 reload at the end of a period whatever CR holds; NULL does not tell it
    reload_between_the_bytes_takes_the_mix = """
        program(2, 0x0103) cw(0, 2) count(0, 3) 1:3 1:2 0:1 write(0, 5) 1:5 1:4
        status(0, 1, 0, 0x34) write(0, 0) status(0, 1, 1, 0x34) 1:3 1:2 0:1 1:5
        status(0, 1, 0, 0x34)"""
    # CR_L and CR_M are loaded one at a time: a trigger between the bytes loads the mix
    first_of_two_bytes_is_in_the_count_register_at_once = """
        cw(0, 1) count(0, 4) trigger() 0:4 0:3 write(0, 2) trigger() 0:2 0:1 write(0, 0) trigger()
        0:2 0:1"""
