# SPDX-License-Identifier: Apache-2.0
"""AD574A, AD667 and the heartbeat one-shot: directed cases and random comparison. §5.3.2-5.3.6."""

import os
import random

from cocotb_tests.chips.analog import CONV, IDLE, IN, OUTS, PULSE, Analog, Models, Shot
from cocotb_tests.chips.replay import (
    ANALOG,
    QUICK_OPS,
    Bench,
    Layout,
    Scripts,
    mismatch,
    rows,
    script,
)
from cocotb_tests.lib.req import test
from cocotb_tests.models import ad574

TOPLEVEL = "bench_chips"
SOURCES = ("bench_chips.sv",)


class Converter(Scripts, of=Analog, req="ADC-1"):
    ad574_power_up_is_not_busy = "step(3) expect(sts=0, oe=0)"
    ad574_busy_for_exactly_the_conversion = """
        start(0) seen('the clock that starts', sts=0) expect('one clock later', sts=1)
        step(CONV - 1) expect('last clock', sts=1) step() expect('over', sts=0)"""
    ad574_zero_volt_is_mid_scale = "convert(0, 0) result(0x800) convert(0, 1) result(0x800)"

    def ad574_end_points_20_v(s):
        for vin, code in ((-32768, 0), (32767, 0xFFF), (32736, 0xFFE), (-32752, 1), (16384, 0xC00)):
            s.convert(vin)
            s.result(code, f"{vin}")

    def ad574_half_lsb_transitions_20_v(s):
        for vin, code in (
            (-32761, 0), (-32760, 1), (-9, 0x7FF), (-8, 0x800), (7, 0x800), (8, 0x801),
            (32743, 0xFFE), (32744, 0xFFF),
        ):  # fmt: skip
            s.convert(vin)
            s.result(code, f"{vin}")

    def ad574_half_lsb_transitions_10_v(s):
        for vin, code in (
            (-16384, 0), (-16381, 0), (-16380, 1), (-5, 0x7FF), (-4, 0x800), (3, 0x800), (4, 0x801),
            (16371, 0xFFE), (16372, 0xFFF),
        ):  # fmt: skip
            s.convert(vin, 1)
            s.result(code, f"{vin}")

    def ad574_clamps_beyond_10_v_span(s):
        for vin, code in ((-32768, 0), (-20000, 0), (20000, 0xFFF), (32767, 0xFFF)):
            s.convert(vin, 1)
            s.result(code, f"{vin}")

    ad574_samples_at_the_start = "start(16384) step(CONV + 2, ad_vin=0x8000) result(0xC00)"
    ad574_start_while_busy_is_ignored = """
        start(16384) step(50) start(-16384) step(CONV - 52)
        expect('still the first conversion', sts=1) step(1) expect('not prolonged', sts=0)
        result(0xC00)"""
    ad574_start_held_gives_one_conversion = """
        step(3 * CONV, ad_ce=1, ad_cs_n=0, ad_rc_n=0) expect(sts=0) step(ad_rc_n=1) start(16384)
        expect('a new edge starts again', sts=1) step(CONV + 1) result(0xC00)"""

    def ad574_any_of_the_three_pins_may_start(s):
        on = {"ad_ce": 1, "ad_cs_n": 0, "ad_rc_n": 0}
        off = {"ad_ce": 0, "ad_cs_n": 1, "ad_rc_n": 1}
        for last, level in on.items():
            s.step(3, **off)
            s.step(2, **{k: v for k, v in on.items() if k != last})
            s.expect(f"waits for {last}", sts=0)
            s.step(**{last: level})
            s.expect(last, sts=1)
            s.step(CONV + 1, **off)

    ad574_needs_ce_and_cs = """
        step(3, ad_ce=0, ad_cs_n=0, ad_rc_n=0) expect(sts=0) step(3, ad_rc_n=1)
        step(3, ad_ce=1, ad_cs_n=1, ad_rc_n=0) expect(sts=0) step(3, ad_rc_n=1)
        seen('not selected', oe=0)"""
    ad574_8_bit_bus_is_left_justified = """
        convert(5 * 16) step(2, ad_ce=1, ad_cs_n=0, ad_rc_n=1, ad_mode12=0, ad_a0=0)
        seen('high byte', byte=0x80, oe=1) step(2, ad_a0=1)
        seen('low nibble and zeros', byte=0x50, oe=1) step(ad_cs_n=1, ad_a0=0)"""
    ad574_short_conversion_is_no_longer = """
        start(16384, ad_a0=1) expect(sts=1) step(CONV, ad_a0=0) expect(sts=0)
        step(2, ad_ce=1, ad_cs_n=0, ad_rc_n=1, ad_mode12=0) seen('eight good bits', byte=0xC0)
        step(ad_cs_n=1)"""


@script(Analog, "DAC-1", "ANA-1")
def ad667_power_up_is_zero_volt(s):
    s.expect(code=0x800)


class Output(Scripts, of=Analog, req="DAC-1"):
    ad667_first_rank_waits = """
        load(0b1110, 0xFFF) load(0b1101, 0xFFF) load(0b1011, 0xFFF)
        expect('rank 2 untouched', code=0x800) load(0b0111, 0x000)
        expect('rank 2 from rank 1', code=0xFFF)"""

    def ad667_nibbles_are_apart(s):
        for a_n, want in ((0b1110, 0x805), (0b1101, 0x855), (0b1011, 0x555)):
            s.load(a_n, 0x555)
            s.load(0b0111, 0xAAA)
            s.expect(code=want)

    ad667_all_transparent = """
        step(2, da_cs_n=0, da_a_n=0, da_d=0x123) expect(code=0x123)
        step(2, da_cs_n=0, da_a_n=0, da_d=0xFED) expect(code=0xFED)
        step(2, da_cs_n=0, da_a_n=0, da_d=0) expect(code=0)"""
    ad667_rank_2_sees_a_coincident_first_rank = """
        load(0b1100, 0x034) expect(code=0x800) load(0b0011, 0xA00)
        expect('high nibble and transfer in one write', code=0xA34)"""
    ad667_nothing_without_chip_select = """
        step(3, da_cs_n=1, da_a_n=0, da_d=0x123) step(da_a_n=15) expect(code=0x800)
        step(3, da_cs_n=0, da_a_n=15, da_d=0x123) expect('no rank enabled', code=0x800)"""
    ad667_value_holds_after_the_strobe = "load(0, 0x3C3) step(20, da_d=0xFFF) expect(code=0x3C3)"


class Heartbeat(Scripts, of=Analog, req="HB-1"):
    oneshot_lasts_exactly = """
        expect('low at power-up', q=0) step(os_trig=1) seen(q=0) expect(q=1)
        step(PULSE - 1, os_trig=0) expect('last clock', q=1) step() expect('over', q=0)"""

    def oneshot_trigger_in_the_last_clock_has_no_glitch(s):
        s.step(os_trig=1)
        s.step(PULSE - 1, os_trig=0)
        s.step(os_trig=1)
        for _ in range(PULSE):
            s.expect("no glitch", q=1)
            s.step(os_trig=0)
        s.expect(q=0)

    oneshot_trigger_one_clock_late_drops_once = """
        step(os_trig=1) step(PULSE, os_trig=0) expect(q=0) step(os_trig=1) expect(q=1)"""


rows(__name__, Shot, lambda row: "HB-1")


def random_words(seed: str, clocks: int) -> list[int]:
    """Pins of all three chips; conversions, writes and triggers of any spacing."""
    rng = random.Random(seed)
    pins, words = dict(IDLE), []
    while len(words) < clocks:
        kind = rng.random()
        if kind < 0.35:
            level = rng.random() < 0.5
            pins.update(ad_ce=int(level or rng.random() < 0.5), ad_cs_n=int(not level))
            pins.update(ad_rc_n=int(rng.random() < 0.7), ad_span10=rng.getrandbits(1))
            pins.update(ad_vin=rng.choice((rng.getrandbits(16), rng.getrandbits(14))))
            pins["ad_mode12"] = rng.getrandbits(1)
            pins["ad_a0"] = rng.getrandbits(1) if pins["ad_rc_n"] else 0
        elif kind < 0.65:
            pins.update(da_cs_n=rng.getrandbits(1), da_a_n=rng.getrandbits(4))
            pins["da_d"] = rng.getrandbits(12)
        else:
            # CLR# does not rise under a high trigger: the parts differ there
            pins["os_trig"] = rng.getrandbits(1)
            if rng.random() < 0.1 and not pins["os_trig"]:
                pins["os_clr_n"] ^= 1
        hold = rng.choice((1, 1, 1, 2, 3, PULSE - 2, PULSE - 1, PULSE, CONV // 2))
        words += [IN.pack(pins)] * hold
    return words


@test("ADC-1", "DAC-1", "HB-1")
async def random_ad574_ad667_oneshot(dut):
    seed = f"{os.environ.get('COCOTB_RANDOM_SEED', '1989')}-analog"
    words = random_words(seed, min(250_000, max(QUICK_OPS, 5000) * 20))
    models, layout, codes = Models(), Layout(OUTS), set()
    bench = Bench(dut, ANALOG)
    got = await bench.replay(words)
    for at, (word, response) in enumerate(zip(words, got, strict=True)):
        want = models.clock(word)
        low = want.pop("byte", None)
        if low is not None and low != response >> 4 & 0xFF:
            raise AssertionError(
                f"seed {seed} {bench.clock_at(at)}: byte {low:#x}, {response >> 4 & 0xFF:#x}"
            )
        wrong = mismatch(layout, want, response)
        assert not wrong, f"seed {seed} {bench.clock_at(at)}: {wrong}; pins {IN.unpack(word)}"
        codes.add(want.get("db"))
    assert len(codes) > 20, f"only {len(codes)} different conversions were read"


@script(Analog, "ADC-1")
def ad574_transfer_function_sweep(s):
    """A thousand voltages in both spans against the formula."""
    rng = random.Random(os.environ.get("COCOTB_RANDOM_SEED", "1989"))
    for _ in range(500):
        for span10 in (0, 1):
            vin = rng.randrange(-32768, 32768)
            s.convert(vin, span10)
            s.result(ad574.code(vin, span10), f"{vin} span10={span10}")
