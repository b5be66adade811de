# SPDX-License-Identifier: Apache-2.0
"""Script words for the A/D, the D/A and the one-shot, which share one bench."""

from cocotbext import conformance

from cocotb_tests.chips.replay import ANALOG, Layout, Script
from cocotb_tests.models import ad574, ad667, oneshot

CONV, PULSE = (
    201,
    20,
)  # of bench_chips.sv; odd, and odd for 8 bits: what turns over in every clock shows
PINS = (
    *((f"ad_{n}", w) for n, w in ad574.PINS),
    *((f"da_{n}", w) for n, w in ad667.PINS),
    *((f"os_{n}", w) for n, w in oneshot.PINS),
)
OUTS = (("db", 12), ("oe", 1), ("sts", 1), ("code", 12), ("q", 1))
IDLE = {
    "ad_ce": 0, "ad_cs_n": 1, "ad_rc_n": 1, "ad_a0": 0, "ad_mode12": 1, "ad_span10": 0,
    "ad_vin": 0, "da_cs_n": 1, "da_a_n": 15, "da_d": 0, "os_trig": 0, "os_clr_n": 1,
}  # fmt: skip
IN = Layout(PINS)


class Models:
    """The three reference models on one word; outputs left open by a data sheet are missing."""

    def __init__(self) -> None:
        self.ad = ad574.Ad574(CONV)
        self.da = ad667.Ad667()
        self.shot = oneshot.OneShot(PULSE)

    def clock(self, word: int) -> dict:
        seen = self.ad.clock(word & 0x3FFFFF)
        seen["code"] = self.da.clock(word >> 22 & 0x1FFFF)
        seen["q"] = self.shot.clock(word >> 39)
        return seen


class Analog(Script):
    CHIP = ANALOG
    PINS, OUTS, IDLE = PINS, OUTS, IDLE

    def model(self):
        return Models()

    def outputs(self, response) -> dict:
        seen = super().outputs(response)
        return {"byte": seen["db"] >> 4} | seen if "db" in seen else seen

    # A/D
    def start(self, vin: int = 0, span10: int = 0, **pins) -> None:
        """One clock of R/C# low; STS is high after it."""
        self.step(ad_ce=1, ad_cs_n=0, ad_rc_n=0, ad_vin=vin & 0xFFFF, ad_span10=span10, **pins)
        self.step(0, ad_rc_n=1, ad_cs_n=1)

    def convert(self, vin: int = 0, span10: int = 0, **pins) -> None:
        self.start(vin, span10, **pins)
        self.step(CONV + 2)

    def result(self, want: int, note: str = "") -> None:
        self.step(2, ad_ce=1, ad_cs_n=0, ad_rc_n=1, ad_mode12=1)
        self.seen(note, db=want, oe=1)
        self.step(ad_cs_n=1)

    # D/A
    def load(self, a_n: int, data: int) -> None:
        self.step(da_cs_n=0, da_a_n=a_n, da_d=data)
        self.step(da_cs_n=1, da_a_n=15, da_d=~data & 0xFFF)


class Shot(Analog, conformance.OneShot):
    """The one-shot alone, by the names of its pins."""

    PULSE = PULSE

    def step(self, clocks: int = 1, **pins) -> None:
        super().step(clocks, **{f"os_{name}": level for name, level in pins.items()})
