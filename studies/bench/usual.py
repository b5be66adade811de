# SPDX-License-Identifier: Apache-2.0
"""`python -m studies.bench.usual`: records in which states boards often are, sim/model/usual.toml.

The engine is built once more, so that it counts in which state each clock begins and inputs are
followed (sim/model/record.h), and runs the loads that `make bench BASE=...` measures. Variables
that make many states of one, such as addresses, are left open; the most frequent states are kept.
"""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np

from mmcs import BUILD, ROOT
from studies.bench.machines import Loaded, Machine

sys.path.insert(0, str(ROOT / "sim" / "model"))
from usual import KINDS, WIDEST, readable  # noqa: E402

FOLDER = BUILD / "bench" / "usual"
TARGET = ROOT / "sim" / "model" / "usual.toml"
LOADS = (3, True, "typical"), (3, True, "full"), (16, False, "typical")
# How many states are kept of each part, for clocks and for inputs.
KEPT = {"adaptor_vme": (48, 24), "mark1": (32, 32), "i8254": (12, 8), "thct2000": (24, 24)}
HEAD = """\
# SPDX-License-Identifier: Apache-2.0
# Made by `python -m studies.bench.usual`: do not edit. sim/model/usual.py tells what it is; a digit
# is the value of the variable of its place, - any.
"""
COMMON = 0.97  # share of the times
OPEN = 14  # so many variables are left open, to have fewer states


def build(cards: int) -> None:
    env = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    env["PATH"] = f"{Path(sys.executable).parent}:{env.get('PATH', '')}"
    place = FOLDER.relative_to(ROOT)
    subprocess.run(["make", "-s", "-f", "sim/Makefile", f"B={place}", f"CARDS={cards}",
                    f"CXX={env.get('CXX', 'g++')} -DMMCS_RECORD"],
                   cwd=ROOT, env=env, check=True)  # fmt: skip


def record(cards: int, puma: bool, load: str) -> Path:
    run = FOLDER / f"{cards}-{load}"
    run.mkdir(parents=True, exist_ok=True)
    code = f"from studies.bench.usual import *; measure({cards}, {puma}, {load!r})"
    env = dict(os.environ, MMCS_RECORD=str(run))
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=env, check=True)
    return run


def measure(cards: int, puma: bool, load: str) -> None:
    Loaded(Machine(cards, True, puma), load, FOLDER / f"speed_c{cards}" / "libmmcs_sim.so")


def read(part: str, kind: int, runs: list[Path]) -> tuple[np.ndarray, np.ndarray]:
    """States, a row each, and how often they were; each load has the same weight."""
    states, times = [], []
    for run in runs:
        found = np.array([[int(value, 16) for value in line.split()]
                          for line in (run / f"V{part}").read_text().splitlines()])  # fmt: skip
        found = found[found[:, 0] == kind]
        states.append(found[:, 1:-1])
        times.append(found[:, -1] / found[:, -1].sum())
    return np.concatenate(states), np.concatenate(times) / len(runs)


def choose(states: np.ndarray, times: np.ndarray, kept: int) -> tuple[list[dict[int, int]], float]:
    """States as {variable: value}, and which share of the times they are."""
    weights = np.random.default_rng(1).integers(1, 1 << 62, states.shape[1], dtype=np.uint64)
    parts = states.astype(np.uint64) * weights  # their sum tells states apart
    varying = [n for n in range(states.shape[1]) if len(np.unique(states[:, n])) > 1]

    def covered(sums: np.ndarray) -> float:
        _, group = np.unique(sums, return_inverse=True)
        return np.sort(np.bincount(group, times))[-kept:].sum()

    sums = parts[:, varying].sum(axis=1)
    for _ in range(OPEN):
        worst = max(varying, key=lambda n: covered(sums - parts[:, n]))
        varying.remove(worst)
        sums -= parts[:, worst]
    _, group = np.unique(sums, return_inverse=True)
    chosen = []
    for number in np.argsort(-np.bincount(group, times), kind="stable")[:kept]:
        like = states[group == number]
        same = np.flatnonzero((like == like[0]).all(axis=0))
        chosen.append({int(n): int(like[0][n]) for n in same})
    return [*chosen, common(states, times)], covered(sums)


def common(states: np.ndarray, times: np.ndarray) -> dict[int, int]:
    """What is so nearly always, for the rest."""
    values = [np.bincount(column, times, 1 << WIDEST) for column in states.T]
    out, so = {}, np.full(len(times), True)
    for n in sorted(range(len(values)), key=lambda n: -values[n].max()):
        also = so & (states[:, n] == values[n].argmax())
        if times[also].sum() >= COMMON:
            out[n], so = int(values[n].argmax()), also
    return out


def text(part: str, names: list[str], chosen: list[list[dict[int, int]]]) -> str:
    """A part in the table. Names are in columns of no meaning."""
    told = sorted({n for states in chosen for state in states for n in state})
    out = [f"[{part}]", 'names = """']
    out += textwrap.wrap(" ".join(names[n] for n in told), 98, break_long_words=False)
    out.append('"""')
    for kind, states in zip(KINDS, chosen, strict=True):
        out.append(f"{kind} = [")
        for state in states:
            out.append('  "' + "".join(f"{state[n]:x}" if n in state else "-" for n in told) + '",')
        out.append("]")
    return "\n".join(out) + "\n"


def main() -> int:
    for cards in {load[0] for load in LOADS}:
        build(cards)
    runs = [record(*load) for load in LOADS]
    out = [HEAD]
    for part, kept in KEPT.items():
        lines = (FOLDER / "boards" / f"V{part}.members").read_text().split()
        names = [readable(line[len("MMCS_MEMBER(") : -1], part) for line in lines]
        chosen = []
        for kind, most in enumerate(kept):
            states, share = choose(*read(part, kind, runs), most)
            print(f"{part}, {KINDS[kind]}: {most} states, {100 * share:.0f} % of the times")
            chosen.append(states)
        out.append(text(part, names, chosen))
    TARGET.write_text("\n".join(out))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
