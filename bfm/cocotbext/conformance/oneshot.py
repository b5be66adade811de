# SPDX-License-Identifier: Apache-2.0
"""A retriggerable one-shot as the 4538: words of a script, and the rows of the sheet."""

from .script import Rows, Script


class OneShot(Script):
    SHEET = "Retriggerable one-shot as the 4538"
    PINS = (("trig", 1), ("clr_n", 1))
    OUTS = (("q", 1),)
    IDLE = {"trig": 0, "clr_n": 1}
    PULSE = 1000  # clocks
    ROWS: list = []

    def trigger(self) -> None:
        self.step(trig=1)
        self.step(trig=0)

    def wait(self, part: float) -> None:
        """So many pulses."""
        self.step(round(part * self.PULSE))

    def q(self, want: int, note: str = "") -> None:
        self.expect(note, q=want)


class Pulse(Rows, of=OneShot, section="Output pulse, retriggering, clear"):
    oneshot_lasts_its_time = """
        q(0, 'at rest') trigger() q(1) wait(0.9) q(1, 'nearly over') wait(0.2)
        q(0, 'over') trigger() q(1, 'again') wait(0.9) q(1) wait(0.2) q(0)"""
    oneshot_triggers_on_the_edge_only = """
        step(trig=1) q(1) wait(1.1) q(0, 'the level does not prolong') step(trig=0)
        q(0, 'nor does its fall trigger')"""

    oneshot_retrigger_extends = """
        trigger() wait(0.6) trigger() wait(0.9) q(1, 'full length from the last trigger')
        wait(0.2) q(0)"""

    oneshot_clear_ends = """
        trigger() q(1) step(clr_n=0) q(0, 'ended') step(clr_n=1) q(0, 'for good')"""
    oneshot_clear_inhibits = """
        step(clr_n=0) trigger() q(0, 'inhibited') step(clr_n=1) q(0, 'not late')
        trigger() q(1, 'works again')"""
