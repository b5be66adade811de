# SPDX-License-Identifier: Apache-2.0
"""How many axes at what rate a processor servoes without overrun: found by running it.

A host sustains a rate if the compiled driver beside the RTL, with all axes in motion and a process
that writes all setpoints at every sample, misses no SCLOCK, is overtaken by none (the driver's own
counts, MGETSTATS) and answers every request. The machine is always the largest, 16 cards, of which
those that are not wanted are absent: one build of the model.
"""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mmcs import ROBOTS, RunError, Session, machine, make_setup

MAX_CARDS = 16
SHORTEST_US, LONGEST_US = 100, 10_000  # intervals that are tried; the driver takes none below
STEP_US = 10  # and how finely
MOTION_S = 0.1
RATES = (250, 500, 1000, 2000, 4000)  # Hz
SIZES = (2, 6, 32)  # axes whose highest rate is looked for
# of a scenario's [[servo]]; gains that keep the bench motors calm at any of these rates
PD = {"a0": 2304, "a1": -2194, "b0": 64, "flags": []}
LAWS = {
    "PD": PD,
    # what the third profile of cycles.py has
    "PID, friction, filter, limits": PD | {
        "a2": 13, "b1": -64, "ic_pos": 50, "ic_neg": 40, "flags": ["coulcomp", "poschk",
        "softerr"], "plo": -20000, "phi": 20000, "ilimax": 50, "ipole": 900, "adc_a": 3,
        "adc_b": -6144},
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """The 68020 with its memory, and the law that it computes."""

    cache: str = "ideal"
    waits: int = 0
    law: str = "PD"

    def __str__(self) -> str:
        if self.cache == "ideal":
            name = "68020, all fetches cached"
        else:
            waits = f"{self.waits} wait{'' if self.waits == 1 else 's'}"
            name = f"68020, 256 B cache, {waits}"
        return f"{name}; {self.law}"


MEMORIES = [("ideal", 0), *(("256 bytes", waits) for waits in (0, 1, 2))]
CASES = [Case(*memory, law=law) for law in LAWS for memory in MEMORIES]


@dataclass(frozen=True)
class Verdict:
    good: bool
    longest_us: float  # pass, SCLOCK to the end
    overruns: int
    missed: int
    refused: str  # what the firmware answered no more, or ""


def setup_of(case: Case, axes: int, interval_us: int):
    """A scenario of so many bench motors that all swing, made on the spot."""
    cards = -(-axes // 2)
    data = {
        "description": "limits", "robot": "./robot.toml", "cards": MAX_CARDS,
        "interval_us": interval_us, "duration": MOTION_S,
        "host": {"instruction_cache": case.cache, "wait_states": case.waits,
                 "cpu_us_per_axis": 0, "latency_max_us": 0},
        "servo": [{"axis": "all"} | LAWS[case.law]],
        "motion": [{"axis": "all", "kind": "sine", "at": 0.0, "duration": MOTION_S, "mean": 0,
                    "amplitude": 400, "hz": 10}],
        "event": [{"input": "card_absent", "index": card, "value": 1, "at": 0.0,
                   "at_power_on": True} for card in range(cards, MAX_CARDS)],
    }  # fmt: skip
    robot = (ROBOTS / "lab32.toml").read_text().replace("copies = 32", f"copies = {axes}")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "robot.toml").write_text(robot)
        return make_setup(Path(folder) / "limits.toml", data)


def run(case: Case, axes: int, interval_us: int) -> Verdict:
    """One real run."""
    setup, refused = setup_of(case, axes, interval_us), ""
    with machine(setup, host="m68020") as sim:
        try:
            Session(sim, setup).run()
        except RunError as error:
            refused = str(error)
        stats, phases = sim.stats(), sim.phases()
    overruns, missed = stats["overruns"], stats["missed"]
    good = not refused and overruns == missed == 0
    longest = phases["pass"][2] if phases else 0.0
    return Verdict(good, longest, overruns, missed, refused)


# --- the largest -------------------------------------------------------------------------------


def edge(good: Callable[[int], bool], low: int, high: int, guess: int) -> int:
    """The largest n of low..high that is good, low - 1 if none is, of a thing that is good up to
    some n. Looks at the guess first, then ever farther away, then between; n and n + 1 are always
    among those that were looked at, as far as they lie in low..high."""
    seen: dict[int, bool] = {low - 1: True, high + 1: False}

    def look(n: int) -> bool:
        n = max(low - 1, min(high + 1, n))
        if n not in seen:
            seen[n] = good(n)
        return seen[n]

    guess, reach = max(low, min(high, guess)), 1
    if look(guess):
        inside, outside = guess, guess + 1
        while look(outside):
            inside, reach = outside, 2 * reach
            outside = min(high + 1, outside + reach)
    else:
        inside, outside = guess - 1, guess
        while not look(inside):
            outside, reach = inside, 2 * reach
            inside = max(low - 1, inside - reach)
    while outside - inside > 1:
        middle = (inside + outside) // 2
        inside, outside = (middle, outside) if look(middle) else (inside, middle)
    return inside


def pass_law(case: Case) -> tuple[float, float]:
    """a, b: the longest pass takes a + b * axes microseconds; through two runs at a slow rate."""
    small, large = 2, 12
    first, second = (run(case, axes, LONGEST_US).longest_us for axes in (small, large))
    b = (second - first) / (large - small)
    return first - b * small, b


def most_axes(case: Case, interval_us: int, law: tuple[float, float]) -> int:
    """Two a card."""
    guess = int((interval_us - law[0]) / law[1]) // 2 if law[1] else MAX_CARDS
    return 2 * edge(lambda n: run(case, 2 * n, interval_us).good, 1, MAX_CARDS, guess)


def shortest_interval(case: Case, axes: int, law: tuple[float, float], bad_us: int = 0) -> int:
    """In microseconds; 0: none that is tried. Near the edge the phase of the requests that set the
    axes up decides, and good intervals may lie below bad ones: none below bad_us counts."""
    least, most = max(SHORTEST_US, bad_us + STEP_US) // STEP_US, LONGEST_US // STEP_US
    # from long to short, as edge() wants it: n is how many steps shorter than the longest
    guess = most - int((law[0] + law[1] * axes) / STEP_US) - 1
    n = edge(lambda n: run(case, axes, (most - n) * STEP_US).good, 0, most - least, guess)
    return (most - n) * STEP_US if n >= 0 else 0


def row(case: Case) -> str:
    law = pass_law(case)
    cells = [str(case), f"{law[0]:.0f} + {law[1]:.0f} n" if law[1] else "-"]
    carried = {1_000_000 // rate: most_axes(case, 1_000_000 // rate, law) for rate in RATES}
    cells += [str(most) if most else "none" for most in carried.values()]
    for axes in SIZES:
        bad_us = max((us for us, most in carried.items() if most < axes), default=0)
        us = shortest_interval(case, axes, law, bad_us)
        cells.append(f"{us} us = {1e6 / us:.0f} Hz" if us else "none")
    return "| " + " | ".join(cells) + " |"


def table(cases=CASES) -> str:
    heads = ["", "longest pass of n axes, us"]
    heads += [f"{rate} Hz" for rate in RATES] + [f"{axes} axes" for axes in SIZES]
    lines = ["| " + " | ".join(heads) + " |", "|---|" + "---|" * (len(heads) - 1)]
    return "\n".join([*lines, *map(row, cases)])
