# SPDX-License-Identifier: Apache-2.0
"""Intel 8255A (231256) and 82C55A: words of a script, and the rows of the sheet."""

from .script import Rows, Script

A, B, C, CONTROL = range(4)
SETTLE = 5  # clocks after which every handshake has come to rest


def mode_word(a=0, a_in=0, ch_in=0, b=0, b_in=0, cl_in=0) -> int:
    return 0x80 | a << 5 | a_in << 4 | ch_in << 3 | b << 2 | b_in << 1 | cl_in


class Ppi(Script):
    SHEET = "Intel 8255A (231256) and 82C55A"
    PINS = (
        ("reset", 1), ("cs_n", 1), ("rd_n", 1), ("wr_n", 1), ("a", 2), ("d", 8), ("pa", 8),
        ("pb", 8), ("pc", 8),
    )  # fmt: skip
    OUTS = (
        ("d_o", 8), ("oe", 1), ("pa", 8), ("pa_oe", 8), ("pb", 8), ("pb_oe", 8), ("pc", 8),
        ("pc_oe", 8),
    )  # fmt: skip
    IDLE = {
        "reset": 0, "cs_n": 1, "rd_n": 1, "wr_n": 1, "a": 0, "d": 0, "pa": 0xFF, "pb": 0xFF,
        "pc": 0xFF,
    }  # fmt: skip
    VARIANTS = ("8255a", "82c55a")
    ROWS: list = []

    def pins(self, note: str = "", **outs) -> None:
        """Port pins after settling; pc0…pc7 are single bits of port C."""
        self.step(SETTLE)
        self.seen(note, **outs)

    def mode(self, **fields) -> None:
        self.write(CONTROL, mode_word(**fields))

    def bit(self, n: int, value: int) -> None:
        self.write(CONTROL, n << 1 | value)

    def strobe(self, bit: int, **with_low) -> None:
        """A low pulse on a port C input (STB# or ACK#)."""
        self.step(SETTLE, pc=self.now["pc"] & ~(1 << bit), **with_low)
        self.step(SETTLE, pc=self.now["pc"] | 1 << bit)


class Reset(Rows, of=Ppi, section="Control logic and reset"):
    reset_makes_all_ports_inputs = """
        mode() write(A, 0x12) pins(pa_oe=0xFF, pb_oe=0xFF, pc_oe=0xFF, pa=0x12)
        step(SETTLE, reset=1) seen(pa_oe=0, pb_oe=0, pc_oe=0) step(SETTLE, reset=0)
        pins(pa_oe=0, pb_oe=0, pc_oe=0) step(pa=0x5A) read(A, 0x5A, 'mode 0 input')"""
    mode_set_clears_the_latches = """
        mode() write(A, 0xFF) write(B, 0xFF) write(C, 0xFF) mode()
        pins('the same mode again', pa=0, pb=0, pc=0) read(A, 0) read(B, 0) read(C, 0)"""
    mode_set_of_one_group_clears_the_other = """
        mode(cl_in=1) write(A, 0x11) write(B, 0x22) mode(cl_in=1, ch_in=1) pins(pa=0, pb=0)"""

    write_needs_chip_select = """
        mode() write(A, 0x12) step(SETTLE, wr_n=0, a=A, d=0x99) step(SETTLE, wr_n=1)
        pins(pa=0x12)"""
    # Selected and left alone: nothing is written, and a write is over when WR# rises
    write_needs_its_strobe = """
        mode() write(A, 0x12) step(SETTLE, cs_n=0, a=A, d=0x99) step(SETTLE, cs_n=1)
        pins(pa=0x12) step(SETTLE, cs_n=0, wr_n=0, a=A, d=0x34) step(SETTLE, wr_n=1, d=0x99)
        step(SETTLE, cs_n=1) pins(pa=0x34)"""
    write_takes_effect_when_wr_rises = """
        mode() step(SETTLE, cs_n=0, wr_n=0, a=A, d=0x55) seen('WR# low', pa=0)
        step(cs_n=1, wr_n=1) expect('WR# high', pa=0x55)"""
    bus_floats_unless_read = """
        step(3, cs_n=1, rd_n=0) floats() step(3, cs_n=0, rd_n=1) floats()
        step(cs_n=1)"""


class Mode0(Rows, of=Ppi, section="Mode 0: basic input and output"):
    def all_sixteen_mode0_directions(s):
        for k in range(16):
            a, ch, b, cl = k >> 3, k >> 2 & 1, k >> 1 & 1, k & 1
            s.mode(a_in=a, ch_in=ch, b_in=b, cl_in=cl)
            s.pins(
                f"control {k}", pa_oe=0 if a else 0xFF, pb_oe=0 if b else 0xFF,
                pc_oe=(0 if ch else 0xF0) | (0 if cl else 0x0F),
            )  # fmt: skip

    def outputs_hold_and_read_back(s):
        s.mode()
        for port, name in ((A, "pa"), (B, "pb"), (C, "pc")):
            for value in (0x00, 0xFF, 0xA5, 0x5A):
                s.write(port, value)
                s.pins(**{name: value})
                s.read(port, value, "the output latch")
        s.pins(pa=0x5A, pb=0x5A, pc=0x5A)

    inputs_are_not_latched_in_mode0 = """
        mode(a_in=1, ch_in=1, b_in=1, cl_in=1) step(pa=0, pb=0xFF, pc=0x0F) read(A, 0)
        read(B, 0xFF) read(C, 0x0F) step(pa=0xFF, pb=0, pc=0xF0) read(A, 0xFF) read(B, 0)
        read(C, 0xF0) step(pa=0x3C, pb=0xC3, pc=0x33) read(A, 0x3C) read(B, 0xC3) read(C, 0x33)
        step(SETTLE, cs_n=0, rd_n=0, a=A) step(2, pa=0x77)
        seen('follows the pins while RD# is low', d_o=0x77) step(cs_n=1, rd_n=1)"""
    port_c_halves = """
        mode(ch_in=1, cl_in=0) write(C, 0xA6) step(pc=0x3F)
        pins(pc_oe=0x0F, pc3=0, pc2=1, pc1=1, pc0=0) read(C, 0x36, 'upper pins, lower latch')
        mode(ch_in=0, cl_in=1) write(C, 0xA6) step(pc=0xC9)
        read(C, 0xA9, 'upper latch, lower pins')"""
    # 0x89, A and B out, C in: everything low at once
    board_setting_is_safe = """
        write(CONTROL, 0x89) pins(pa=0, pb=0, pa_oe=0xFF, pb_oe=0xFF, pc_oe=0) step(pc=0xE5)
        read(C, 0xE5)"""


class Bits(Rows, of=Ppi, section="Single bit set and reset"):
    def bit_set_and_reset(s):
        s.mode()
        value = 0
        for n in (3, 0, 7, 5, 1, 2, 4, 6):
            s.bit(n, 1)
            value |= 1 << n
            s.pins(f"set {n}", pc=value)
        for n in (6, 0, 3, 7, 1, 4, 2, 5):
            s.bit(n, 0)
            value &= ~(1 << n)
            s.pins(f"reset {n}", pc=value)

    bit_set_leaves_ports_a_and_b = """
        mode() write(A, 0x3C) write(B, 0xC3) bit(5, 1) pins(pa=0x3C, pb=0xC3, pc=0x20)"""

    def set_reset_writes_ibf_obf_and_intr(s):
        """Every port C line that is an output may be written so, the handshake's own included."""
        s.mode(a=1, a_in=1, b=1, b_in=1, ch_in=1, cl_in=1)
        for n in (5, 3, 1, 0):
            s.bit(n, 1)
            s.pins(f"set {n}", **{f"pc{n}": 1})
            s.bit(n, 0)
            s.pins(f"reset {n}", **{f"pc{n}": 0})
        s.mode(a=1, b=1, ch_in=1, cl_in=1)
        for n in (7, 3, 1, 0):
            s.bit(n, 0)
            s.pins(f"reset {n}", **{f"pc{n}": 0})
            s.bit(n, 1)
            s.pins(f"set {n}", **{f"pc{n}": 1})

    # IBF set so interrupts and is reset by a read; OBF# reset so waits for ACK#
    written_flags_are_the_flags = """
        mode(a=1, a_in=1, b=1, ch_in=1, cl_in=1) bit(4, 1) bit(5, 1)
        pins('a full buffer interrupts', pc5=1, pc3=1) step(SETTLE, cs_n=0, rd_n=0, a=A)
        seen('RD# low takes INTR away', pc5=1, pc3=0) step(SETTLE, cs_n=1, rd_n=1)
        seen('and its end IBF', pc5=0, pc3=0) bit(2, 1) pins('B is empty', pc1=1, pc0=1)
        bit(1, 0) pins('as if written', pc1=0, pc0=0) strobe(2) pins('and taken', pc1=1, pc0=1)"""
    written_intr_lasts_until_the_next_event = """
        mode(a=1, a_in=1, b=1, ch_in=1, cl_in=1) bit(4, 1) bit(3, 1)
        pins('set with an empty buffer', pc3=1) step(SETTLE, cs_n=0, rd_n=0, a=A)
        seen('RD# low takes it away', pc3=0) step(SETTLE, cs_n=1, rd_n=1) seen('for good', pc3=0)
        strobe(4, pa=0x21) pins('an event of the port', pc5=1, pc3=1) bit(3, 0)
        pins('reset with a full one', pc5=1, pc3=0) read(A, 0x21) strobe(4, pa=0x22)
        pins('the next event sets it again', pc5=1, pc3=1)"""


class Mode1(Rows, of=Ppi, section="Mode 1: strobed input and output"):
    # STB# = PC4, IBF = PC5, INTR = PC3
    mode1_input_a = """
        mode(a=1, a_in=1, ch_in=1, cl_in=1) pins('at rest', pc_oe=0x28, pc5=0, pc3=0, pa_oe=0)
        bit(4, 1) step(SETTLE, pc=0xEF, pa=0x5A) seen('STB# low', pc5=1, pc3=0)
        step(SETTLE, pc=0xFF) seen('STB# high', pc5=1, pc3=1) step(pa=0x00)
        step(SETTLE, cs_n=0, rd_n=0, a=A)
        seen('the latched byte; RD# low takes INTR away', d_o=0x5A, pc3=0, pc5=1)
        step(SETTLE, cs_n=1, rd_n=1) seen('RD# high frees the buffer', pc5=0, pc3=0)"""
    # STB# = PC2, IBF = PC1, INTR = PC0
    mode1_input_b = """
        mode(b=1, b_in=1, ch_in=1, cl_in=1) pins(pc_oe=0x03, pc1=0, pc0=0) bit(2, 1)
        strobe(2, pb=0xC3) pins(pc1=1, pc0=1) step(pb=0) read(B, 0xC3) pins(pc1=0, pc0=0)"""
    # OBF# = PC7, ACK# = PC6, INTR = PC3
    mode1_output_a = """
        mode(a=1, ch_in=1, cl_in=1) pins('empty', pc_oe=0x88, pc7=1, pc3=0, pa_oe=0xFF) bit(6, 1)
        pins('INTE', pc3=1) step(SETTLE, cs_n=0, wr_n=0, a=A, d=0x77)
        seen('WR# low takes INTR away', pc3=0, pc7=1) step(SETTLE, cs_n=1, wr_n=1)
        seen('full', pc7=0, pc3=0, pa=0x77) step(SETTLE, pc=0xBF) seen('ACK# low', pc7=1, pc3=0)
        step(SETTLE, pc=0xFF) seen('ACK# high', pc7=1, pc3=1, pa=0x77)"""
    # OBF# = PC1, ACK# = PC2, INTR = PC0
    mode1_output_b = """
        mode(b=1, ch_in=1, cl_in=1) pins(pc_oe=0x03, pc1=1, pc0=0, pb_oe=0xFF) bit(2, 1)
        write(B, 0x66) pins(pc1=0, pc0=0, pb=0x66) strobe(2) pins(pc1=1, pc0=1)"""
    mode1_without_inte_never_interrupts = """
        mode(a=1, a_in=1, b=1, ch_in=1, cl_in=1) strobe(4, pa=1) write(B, 2) strobe(2)
        pins(pc5=1, pc3=0, pc1=1, pc0=0)"""
    # PC6, PC7 beside an input port A, PC4, PC5 beside an output one
    mode1_spare_bits_of_port_c = """
        mode(a=1, a_in=1, ch_in=0, cl_in=1) bit(7, 1) pins(pc_oe=0xE8, pc7=1, pc6=0) bit(6, 1)
        pins(pc7=1, pc6=1) mode(a=1, a_in=0, ch_in=0, cl_in=1) bit(5, 1)
        pins(pc_oe=0xB8, pc5=1, pc4=0)"""
    mode1_reset_by_mode_set = """
        mode(a=1, a_in=1, ch_in=1, cl_in=1) bit(4, 1) strobe(4, pa=0x12) pins(pc5=1, pc3=1)
        mode(a=1, a_in=1, ch_in=1, cl_in=1) pins('flags and INTE cleared', pc5=0, pc3=0)
        strobe(4, pa=0x12) pins(pc5=1, pc3=0)"""

    def request_falls_with_the_strobe(s):
        """With its first clock, stays low to its last and after it: a byte is read, or written."""
        for port, given in ((A, 0), (A, 1), (B, 0), (B, 1)):
            request, inte = ("pc3", 6 if given else 4) if port == A else ("pc0", 2)
            s.mode(**({"a": 1, "a_in": 1 - given} if port == A else {"b": 1, "b_in": 1 - given}))
            s.bit(inte, 1)
            if not given:
                s.strobe(inte, pa=0x17, pb=0x17)
            s.pins(f"before {request}", **{request: 1})
            for place in ("first clock", "last clock"):
                s.step(cs_n=0, **{"wr_n" if given else "rd_n": 0}, a=port, d=0x5A)
                s.seen(f"{place} {request}", **{request: 0})
            for place in ("after it", "later"):
                s.step(cs_n=1, wr_n=1, rd_n=1, a=port)
                s.seen(f"{place} {request}", **{request: 0})

    # Port C read in mode 1: INTE stands where the strobes come in
    mode1_status_word = """
        mode(a=1, a_in=1, b=1, ch_in=1, cl_in=1) step(pc=0x7F) read(C, 0x42, 'PC6 pin; OBFB# 1')
        bit(4, 1) bit(2, 1) read(C, 0x42 | 0x10 | 0x04 | 0x01, 'INTE A, INTE B and INTR B')
        strobe(4, pa=9) read(C, 0x42 | 0x10 | 0x05 | 0x20 | 0x08, 'IBF A, INTR A')"""


class Mode2(Rows, of=Ppi, section="Mode 2: strobed bidirectional bus"):
    # The pins of port A are driven only while ACK# is low
    mode2_output_side = """
        mode(a=2, cl_in=1) pins(pc7=1, pc3=0, pa_oe=0) bit(6, 1) pins('INTE1', pc3=1)
        write(A, 0x9C) pins(pc7=0, pc3=0, pa_oe=0) step(SETTLE, pc=0xBF)
        seen('ACK# low', pa_oe=0xFF, pa=0x9C, pc7=1) step(SETTLE, pc=0xFF)
        seen('ACK# high', pa_oe=0, pc7=1, pc3=1)"""
    mode2_input_side = """
        mode(a=2, cl_in=1) bit(4, 1) strobe(4, pa=0x41) pins(pc5=1, pc3=1) write(A, 0x99)
        step(pa=0) read(A, 0x41, 'the input latch, not the output one') pins(pc5=0, pc7=0, pc3=0)"""
    mode2_interrupts_apart = """
        mode(a=2, cl_in=1) strobe(4, pa=1) pins('no INTE', pc3=0) bit(4, 1) pins('INTE2', pc3=1)
        bit(4, 0) pins(pc3=0) bit(6, 1) pins('INTE1', pc3=1)
        read(C, 0x80 | 0x40 | 0x20 | 0x08 | 0x07, 'status word')"""
    mode2_is_any_1x = "mode(a=3, cl_in=1) write(A, 0x18) pins(pc7=0, pa_oe=0)"

    mode2_with_mode1_on_port_b = """
        mode(a=2, b=1, b_in=1) pins(pc_oe=0xAB) bit(2, 1) strobe(2, pb=0x3D)
        pins(pc1=1, pc0=1, pc5=0) read(B, 0x3D)"""
    group_b_plain_beside_mode2 = """
        mode(a=2, b=0, b_in=0, cl_in=0) write(B, 0x81) bit(1, 1)
        pins(pb=0x81, pc_oe=0xAF, pc2=0, pc1=1, pc0=0)"""


class Silent(Rows, of=Ppi, section="Not in the sheet", silent=True):
    writes_to_inputs_are_ignored = """
        mode(a_in=1, b_in=1) write(A, 0x12) write(B, 0x34) step(pa=0xAB, pb=0xCD) read(A, 0xAB)
        read(B, 0xCD) pins(pa_oe=0, pb_oe=0)"""
    bit_set_on_inputs_stays_hidden = """
        mode(ch_in=1, cl_in=1) bit(4, 1) step(pc=0x00) pins(pc_oe=0) read(C, 0) mode()
        pins('cleared by the mode set', pc=0)"""


class Readable(Rows, of=Ppi, section="82C55A: control word read back", only=("82c55a",)):
    control_word_readable_variant = """
        step(SETTLE, reset=1) step(SETTLE, reset=0) read(CONTROL, 0x9B, 'after reset')
        write(CONTROL, 0x89) read(CONTROL, 0x89) bit(3, 1)
        read(CONTROL, 0x89, 'bit set does not change it')"""

    def each_bit_of_the_mode_word(s):
        for field, value in (("a", 0xA0), ("a_in", 0x90), ("ch_in", 0x88), ("b", 0x84)):
            assert mode_word(**{field: 1}) == value
            s.mode(**{field: 1})
            s.read(CONTROL, value)
