# SPDX-License-Identifier: Apache-2.0
"""`make falsify`: does an expectation notice when the physics is wrong?

Every scenario runs with its true physics and with each falsification. Of the pairs in which some
joint is more than 20 counts elsewhere than in the true run, those must fail an expectation. A score
as the mutation score of the RTL is; --write gives scenarios the path of their true run. What has
been found of a scenario stays in build/falsify, and is not looked for again with the same sources.
"""

import argparse
import hashlib
import json
import multiprocessing
import re
from pathlib import Path

import numpy as np

from mmcs import logcols
from studies import run as finish

FAR = 20  # counts
POINTS = 16  # of a path
MARK = '[[expect]]\nkind = "path"  # of the true run, by `make falsify WRITE=1`\n'
LONGEST_S = 5.0  # of a scenario that takes part


def scaled(**shares):
    """Every axis' values times these shares."""

    def change(robot):
        for motor in robot.axis:
            for name, share in shares.items():
                setattr(motor, name, getattr(motor, name) * share)

    return change


def inertia(share):
    def change(robot):
        scaled(rotor_inertia=share, inertia=share)(robot)
        for link in robot.link:
            link.inertia = [share * i for i in link.inertia]

    return change


def friction(share):
    return scaled(coulomb_pos=share, coulomb_neg=share, stiction_pos=share, stiction_neg=share,
                  viscous=share)  # fmt: skip


def gravity(robot):
    robot.gravity = [0.7 * g for g in robot.gravity]
    scaled(gravity=0.7)(robot)


def mass(robot):
    for link in robot.link:
        link.mass *= 1.5


def lag(robot):
    for motor in robot.axis:
        motor.amp_tau = 1e-3


def closing(robot):
    for motor in robot.axis:
        motor.brake_delay = motor.brake_release_delay


def stops(robot):
    for motor in robot.axis:
        if motor.stop_lo < motor.stop_hi:
            motor.stop_lo, motor.stop_hi = motor.stop_lo - 0.2, motor.stop_hi + 0.2


FALSIFIED = {
    "gravity x 0.7": gravity, "inertia x 0.6": inertia(0.6), "inertia x 1.4": inertia(1.4),
    "friction x 0.6": friction(0.6), "friction x 1.4": friction(1.4),
    "motor constant x 0.8": scaled(km=0.8), "motor constant x 1.2": scaled(km=1.2),
    "mass x 1.5": mass, "amplifier lag 1 ms": lag, "brake x 0.3": scaled(brake_torque=0.3),
    "brake delay x 3": scaled(brake_delay=3.0), "brake closes as slowly as it releases": closing,
    "stops 0.2 rad away": stops,
}  # fmt: skip


def run(name: str, what: str | None):
    """(positions per axis, expectations missed, times) of one run; None: it cannot be made."""
    from mmcs import RunError, judge, load, measure, simulate

    setup = load(name, "skip=true")
    if what is not None:
        FALSIFIED[what](setup.robot)
    try:
        result = simulate(setup)
    except RunError:
        return None
    missed = [v["what"] for v in judge(result, measure(result)) if not v["ok"]]
    axes = [logcols.column(result.log, n, "encoder").copy() for n in range(setup.axes)]
    return np.array(axes), missed, result.log[:, 0].copy()


def elsewhere(true: np.ndarray, other: np.ndarray) -> float:
    """The farthest that any joint is from where it is in the true run, counts."""
    shared = min(true.shape[1], other.shape[1])
    if not shared:
        return 0.0 if true.shape == other.shape else np.inf
    return float(np.abs(true[:, :shared] - other[:, :shared]).max())


def study(name: str) -> dict[str, tuple[float, bool]]:
    """{falsification: (counts elsewhere, noticed)} of a scenario."""
    true, missed, _ = run(name, None)
    if missed:
        raise RuntimeError(
            f"falsify: {name} misses an expectation with its true physics: {missed[0]}"
        )
    found = {}
    for what in FALSIFIED:
        other = run(name, what)
        found[what] = (np.inf, True) if other is None else (elsewhere(true, other[0]),
                                                            bool(other[1]))  # fmt: skip
    return found


def studied(name: str) -> dict[str, tuple[float, bool]]:
    """The same, if need be; whoever is killed loses the scenario under way."""
    from mmcs import BUILD, library_path, load

    setup = load(name)
    library = library_path(setup.scenario.cards, "speed").with_suffix(".so.sum")
    state = (library.read_text() if library.exists() else "", setup.data, setup.files,
             Path(__file__).read_text())  # fmt: skip
    key = hashlib.sha256(repr(state).encode()).hexdigest()
    path = BUILD / "falsify" / f"{name}.json"
    if path.exists() and (old := json.loads(path.read_text()))["of"] == key:
        return old["found"]
    found = study(name)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_text(json.dumps({"of": key, "found": found}))
    part.replace(path)
    return found


def path_of(name: str) -> str:
    """The expectation that the true run meets exactly."""
    from mmcs import load

    setup = load(name)
    axes, _, t = run(name, None)
    told = min(setup.scenario.duration, float(t[-1]))  # a driver that has stopped records no more
    every = round(told / (POINTS + 1), 3)
    step = round(every * 1e6 / setup.scenario.interval_us)
    every = step * setup.scenario.interval_us / 1e6
    places = np.searchsorted(t, every * np.arange(1, POINTS + 1) - 1e-9)
    rows = [[int(axis[n]) for n in places if n < len(t)] for axis in axes]
    rows = rows[:1] if all(row == rows[0] for row in rows) else rows
    lines = ",\n".join(f"  {row}" for row in rows)
    return f"\n{MARK}every = {every:g}\ncounts = [\n{lines},\n]\n"


def write(name: str) -> None:
    from mmcs import find

    path = Path(find(name))
    text = path.read_text()
    own = re.sub(rf"\n{re.escape(MARK)}.*", "", text, flags=re.S)
    if "[[expect]]" not in own and "extends" in own:
        return  # an expectation of its own would take the place of those that it extends
    path.write_text(own)  # what the file holds in the end is judged by none of its own path
    path.write_text(own + path_of(name))


def names(only: str) -> list[str]:
    from mmcs import load, scenario_names

    words = only.split() or [""]
    found = [n for n in scenario_names() if any(word in n for word in words)]
    return [n for n in found if load(n).scenario.duration <= LONGEST_S]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="scenarios whose name holds one of these words")
    parser.add_argument("--write", action="store_true", help="write the paths of the true runs")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    chosen = names(options.only)
    with multiprocessing.get_context("spawn").Pool(options.workers) as pool:
        if options.write:
            pool.map(write, chosen, chunksize=1)
        results = dict(zip(chosen, pool.imap(studied, chosen), strict=True))
    far = noticed = 0
    for name, found in results.items():
        there = {w: seen for w, (counts, seen) in found.items() if counts > FAR}
        missed = [w for w, seen in there.items() if not seen]
        far, noticed = far + len(there), noticed + sum(there.values())
        told = f"; not: {', '.join(missed)}" if missed else ""
        print(f"{name:28} {sum(there.values()):2} of {len(there):2} noticed{told}", flush=True)
    share = 100 * noticed / far if far else 100.0
    print(f"falsify: {noticed} of {far} pairs noticed, {share:.1f} %")
    return 0 if share >= 90 else 1


if __name__ == "__main__":
    finish(main)
