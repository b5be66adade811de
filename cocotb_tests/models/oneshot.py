# SPDX-License-Identifier: Apache-2.0
"""Reference model of the retriggerable one-shot (heartbeat). Report §5.3.6."""

PINS = (("trig", 1), ("clr_n", 1))
OUTS = (("q", 1),)


class OneShot:
    """Q is high for exactly `pulse` clocks after the clock that saw the last trigger."""

    def __init__(self, pulse: int) -> None:
        self.pulse = pulse
        self.left = 0
        self.trig = 0

    def clock(self, word: int) -> int:
        trig, clr_n = word & 1, (word >> 1) & 1
        q = 1 if self.left else 0
        if not clr_n:
            self.left = 0
        elif trig and not self.trig:
            self.left = self.pulse
        elif self.left:
            self.left -= 1
        self.trig = trig
        return q
