# SPDX-License-Identifier: Apache-2.0
"""The nets of the prepared view as a page draws them, clock by clock and without a trace file.

They come from a machine that skips nothing (mmcs_sim_watch); web/waves.js draws them.
"""

import re

import numpy as np

from mmcs.view.names import TABLES, states
from mmcs.view.waves import GROUPS, HEX, SIGNED, Signal

ABSENT = ("firmware",)  # of a trace only
FORMS = {HEX: "hex", SIGNED: "signed"}


def groups(own: list[str] | None = None) -> list[dict]:
    """By group: each signal, the net that holds it, and how it is shown. own: registers of cards of
    one's own."""
    cards = {"own card": [Signal(name, 32, HEX) for name in own]} if own else {}
    return [
        {"name": name, "signals": [_signal(signal) for signal in signals]}
        for name, signals in (GROUPS | cards).items()
        if name not in ABSENT
    ]


def nets() -> list[str]:
    """What is watched, in the order in which changes are numbered."""
    return [signal["net"] for group in groups() for signal in group["signals"]]


def changes(found: np.ndarray, begin: int, end: int, own: int = 0) -> list[dict]:
    """Of each net between two clocks: clocks and values, the first as it was at the begin. own: so
    many of own cards behind nets()."""
    made = []
    for number in range(len(nets()) + own):
        of = found[(found["net"] == number) & (found["clock"] <= end)]
        of = of[max(0, int(np.searchsorted(of["clock"], begin, side="right")) - 1) :]
        made.append({"clocks": of["clock"].tolist(), "values": of["value"].tolist()})
    return made


def _signal(signal: Signal) -> dict:
    names = {}
    if signal.names:
        names = TABLES[signal.names]()
    elif signal.state_of:
        names = states(signal.state_of)
    return {
        "name": re.sub(r"^.*(u_axis|u_card)\.|^u_adaptor\.", "", signal.path),
        "net": signal.port or signal.path,
        "width": signal.width,
        "form": FORMS.get(signal.form, "bits"),
        "curve": signal.curve,
        "names": {str(value): text for value, text in sorted(names.items())},
    }
