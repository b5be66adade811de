# SPDX-License-Identifier: Apache-2.0
"""`make bench`: how fast the simulation is, in one run, as ratios of what was taken side by side.

run.py [--quick] [--sweep N] [--no-docs]: measures and writes docs/simulator/bench.md,
docs/images/bench.svg and build/bench/bench.json. Times are CPU times; every round takes each
machine once, and a figure is the median over the rounds, so that whatever else the computer does
falls on all alike.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import statistics
import subprocess
import sys
import time

from mmcs import BUILD, ROOT, ensure_library
from studies.bench import page, replay
from studies.bench.machines import CARDS, LOADS, Machine, Remote

MACHINES = [Machine(cards, skip) for cards in CARDS for skip in (True, False)]
ARM = [Machine(3, True, puma=True), Machine(3, False, puma=True)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one round, a small sweep")
    parser.add_argument("--sweep", type=int, metavar="N", help="runs of the sweep; 100")
    parser.add_argument("--no-docs", action="store_true", help="leave docs/ alone")
    parser.add_argument("--cards", type=int, nargs="*", default=CARDS, help="only these machines")
    given = parser.parse_args()
    if not set(given.cards) <= set(CARDS):
        parser.error(f"--cards: there are {', '.join(map(str, CARDS))}")
    cards = sorted({replay.CARDS, *given.cards})
    given.no_docs |= given.quick or cards != list(CARDS)  # docs/ shows whole runs only
    rounds = 1 if given.quick else 5
    began = time.monotonic()

    def say(text: str) -> None:
        print(f"[{time.monotonic() - began:5.0f} s] {text}", flush=True)

    found = {"host": host(), "rounds": rounds}
    say("machines: building")
    found["machines"] = speeds(cards, rounds, say)
    say("share of the time")
    found["shares"] = where(say, 0.5 if given.quick else 3.0)
    say("other simulators: recording")
    found["others"] = others(1 if given.quick else 3, say)
    say("sweep")
    found["sweep"] = sweep(given.sweep or (10 if given.quick else 100))
    found["minutes"] = round((time.monotonic() - began) / 60, 1)
    out = BUILD / "bench" / "bench.json"
    out.write_text(json.dumps(found, indent=1) + "\n")
    print(page.console(found))
    if not given.no_docs:
        page.write(found, ROOT / "docs")
    say("done: build/bench/bench.json" + ("" if given.no_docs else ", docs/simulator/bench.md"))
    return 0


def host() -> dict:
    """What may be said of the computer: how many cores, which compiler."""
    text = subprocess.run(
        [os.environ.get("CXX", "g++"), "--version"], text=True, capture_output=True, check=True
    ).stdout.splitlines()[0]
    version = re.findall(r"\d+\.\d+(?:\.\d+)?", text)
    name = "clang" if "clang" in text else "g++"
    return {"cores": len(os.sched_getaffinity(0)), "compiler": f"{name} {(version or ['?'])[-1]}"}


def speeds(cards: list[int], rounds: int, say) -> list[dict]:
    """Every machine under every load, the rounds interleaved."""
    remotes = [Remote(m) for m in MACHINES if m.cards in cards] + [Remote(m) for m in ARM]
    taken: dict[tuple[int, str], list[dict]] = {}
    for n in range(rounds):
        say(f"machines: round {n + 1} of {rounds}")
        for place, remote in enumerate(remotes):
            for load in LOADS:
                taken.setdefault((place, load), []).append(remote.ask(load))
    out = []
    for place, remote in enumerate(remotes):
        machine = remote.machine
        grown, total = remote.ask("memory")
        for load in LOADS:
            values = taken[place, load]
            rates = [v["s"] / v["cpu"] for v in values]
            out.append({
                "cards": machine.cards, "axes": machine.axes, "skip": machine.skip,
                "arm": machine.puma, "load": load, "rtf": statistics.median(rates), "rtfs": rates,
                "clocks_per_s": statistics.median(v["clocks"] / v["cpu"] for v in values),
                "evals_per_clock": values[0]["evals"] / values[0]["clocks"],
                "edges_per_axis_ms": values[0]["edges"] / machine.axes / values[0]["s"] / 1e3,
                "memory_mb": grown, "process_mb": total,
            })  # fmt: skip
        remote.end()
    return out


def where(say, cpu_s: float) -> list[dict]:
    """The parts' shares of the time of the six-axis arm, in processes of their own."""
    out = []
    for machine in ARM:
        for load in LOADS:
            code = (
                "import json; from studies.bench import shares;"
                "from studies.bench.machines import Machine;"
                f"m = Machine(3, {machine.skip}, True);"
                f"print(json.dumps(shares.measure(m, {load!r}, {cpu_s})))"
            )
            done = subprocess.run(
                [sys.executable, "-c", code], cwd=ROOT, text=True, capture_output=True, check=False,
            )  # fmt: skip
            if done.returncode:
                say(f"no shares: {(done.stderr.strip().splitlines() or ['?'])[-1]}")
                return []
            out.append({"skip": machine.skip, "load": load, "shares": json.loads(done.stdout)})
    return out


def others(rounds: int, say) -> dict:
    """Clocks a CPU second on the same traffic: Icarus, plain Verilator, and the whole of ours."""
    traffic = replay.record()
    say("other simulators: building")
    commands = replay.build(traffic)
    ours = {skip: Whole(skip) for skip in (False, True)}
    rates: dict[str, list[float]] = {"icarus": [], "plain": [], "ours": [], "ours_skip": []}
    for n in range(rounds):
        say(f"other simulators: round {n + 1} of {rounds}")
        for name, command in commands.items():
            rates[name].append(traffic.clocks / replay.replay(name, command, traffic))
        for name, skip in (("ours", False), ("ours_skip", True)):
            rates[name].append(ours[skip].clocks_per_s())
    ratio = {
        f"{a}/{b}": statistics.median(x / y for x, y in zip(rates[a], rates[b], strict=True))
        for a in ("ours", "ours_skip") for b in ("icarus", "plain")
    }  # fmt: skip
    middle = {name: statistics.median(values) for name, values in rates.items()}
    return {"clocks": traffic.clocks, "bus_cycles": traffic.bus_cycles, "events": traffic.events,
            "rates": middle, "ratio": ratio}  # fmt: skip


class Whole:
    """The recorded run once more on the speed build: RTL, driver, plant, log and all."""

    def __init__(self, skip: bool):
        self.machine = Machine(replay.CARDS, skip)
        self.library = ensure_library(self.machine.cards, "speed")

    def clocks_per_s(self) -> float:
        from mmcs import Sim
        from studies.bench.machines import LEAST_CPU_S, start

        setup = self.machine.setup(replay.LOAD)
        cpu, clocks = 0.0, 0
        while cpu < LEAST_CPU_S:
            with Sim(self.library, setup.config(), setup.motors(), setup.links()) as sim:
                before = sim.clock
                begin = time.process_time()
                start(sim, setup)
                sim.run(replay.RECORD_S)
                cpu += time.process_time() - begin
                clocks += sim.clock - before
        return clocks / cpu


def sweep(runs: int) -> dict:
    """mmcs sweep as a user types it: random gains and seeds of the six-axis arm, 2 s each."""
    command = [sys.executable, "-m", "mmcs", "sweep", "puma560_coupled", "--duration", "2",
               "--random", "axis.all.b0=85..95",
               "--random", "seed=1..1000000", "--samples", str(runs),
               "--out", str(BUILD / "bench" / "sweep")]  # fmt: skip
    wall, used = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=ROOT, text=True, capture_output=True, check=False)
    wall, after = time.monotonic() - wall, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime - used.ru_utime + after.ru_stime - used.ru_stime
    if done.returncode not in (0, 1):
        raise RuntimeError(f"the sweep failed: {done.stderr.strip()[-300:]}")
    table = (BUILD / "bench" / "sweep" / "table.csv").read_text().splitlines()
    found = re.search(r"(\d+) runs in ([\d.]+) s", done.stdout)
    per_run = float(found[2]) / runs
    return {"runs": runs, "rows": len(table) - 1, "wall_s": wall, "s_per_run": per_run,
            "cpu_s_per_run": cpu / runs,
            "thousand_s": wall - float(found[2]) + 1000 * per_run}  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
