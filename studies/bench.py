# SPDX-License-Identifier: Apache-2.0
"""`make bench`: how fast it is, as docs/evidence/bench.md shows it.

Everything is taken in one run, in processor time, round by round: the machine, and other simulators
of its RTL on the bus traffic of the same motion. A figure is the median of the rounds.
"""

import argparse
import json
import math
import os
import resource
import shutil
import statistics
import sys
import time
from pathlib import Path

import mmcs
from mmcs import BUILD, ROBOTS, ROOT, Files, Session, machine, mcdef, read_toml
from studies import carried_out, replay
from tools.pages import committed, rewrite

FOLDER = BUILD / "bench"
PAGE = ROOT / "docs" / "evidence" / "bench.md"
MEASURED = "rtl sim firmware mmcs"  # what the figures depend on
ROUNDS, LEAST_CPU_S = 7, 0.25  # of a measurement
TYPICAL = "6 axes, coupled PUMA, typical"
LOADS = {  # cards, with an arm, what it does
    TYPICAL: (3, True, "typical"),
    "6 axes, full joint speed": (3, True, "full"),
    "32 axes, typical": (16, False, "typical"),
}
STARTS = ("lab500", "puma560")
FAULTS = (10, 40)  # of two campaigns, whose difference is that of so many faults
SAMPLES = (300, 9300)  # of two runs of a program, and of the scenario
BOUNDS = {  # floor, aim
    "times as fast as Verilator": (80, 150),
    "hits of the model's cache": (99.5, None),
    "memory of a machine of 3 cards": (32, None),
    "page (WebAssembly), lab500": (0.7, None),
    "page (WebAssembly), puma560": (0.7, None),
    "campaign, CPU of a fault": (0.65, 0.35),
    "six axes in lock-step, from C": (0.7, None),
    "six axes in lock-step, from Python": (0.45, None),
}

# --- a machine under a load ----------------------------------------------------------------------

# Each joint at the speed limit of its motor (Armstrong, Khatib, Burdick 1986), for 0.55 s.
START_DEG = [-30.0, 45.0, -180.0, -95.0, -88.0, 0.0]
FULL_RAD_S = [1.92, 1.51, 2.40, 5.34, 5.09, 5.74]
MOVE = [4000, 4000, 3000, 4000, 4000, 4000]
WINDOWS = {  # begin and length of what is measured, s of motion
    (True, "typical"): (0.05, 0.5), (True, "full"): (0.15, 0.4), (False, "typical"): (0.1, 1.0),
}  # fmt: skip


def make_setup(cards: int, arm: bool, load: str):
    if arm:
        data: dict = {"robot": "puma560", "dynamics": "coupled", "duration": 1.0}
        motion = {"axis": "all", "kind": "quintic", "at": 0.05, "duration": 0.5, "to": MOVE}
        data["motion"] = [motion]
        if load == "full":
            data |= {"pose_deg": START_DEG, "motion": []}
            robot = read_toml(ROBOTS / "puma560.toml")
            motors = [robot.get("every_axis", {}) | motor for motor in robot["axis"]]
            for axis, (motor, speed) in enumerate(zip(motors, FULL_RAD_S, strict=True)):
                counts = motor["counts_per_rev"] * motor["gear"] / (2 * math.pi) * speed * 0.55
                ramp = {"axis": axis, "kind": "ramp", "at": 0.0, "duration": 0.55, "to": counts}
                data["motion"].append(ramp)
    else:  # bench motors at a constant speed, 8 counts a millisecond
        ramp = {"axis": "all", "kind": "ramp", "at": 0.0, "duration": 4.9, "to": 8 * 4900.0}
        data = {"robot": "lab32", "duration": 5.0, "motion": [ramp]}
    data |= {"description": "a load of make bench", "cards": cards, "skip": True}
    data["host"] = {"cpu_us_per_axis": 10.0}  # a host that serves 32 axes within the millisecond
    return mmcs.make_setup(ROOT / "sim" / "scenarios" / "bench.toml", data, Files({}))


class Load:
    """A machine at the beginning of what is measured, kept there as a snapshot."""

    def __init__(self, cards: int, arm: bool, load: str):
        setup = make_setup(cards, arm, load)
        self.sim = sim = machine(setup)
        session = Session(sim, setup)
        session.begin()
        begin = session.start + WINDOWS[arm, load][0]
        self.end = begin + WINDOWS[arm, load][1]
        sim.run(begin)
        self.snapshot, self.begin = sim.snapshot(), begin
        before = sim.caches()
        sim.run(self.end)
        # Hits and misses while it does this for the first time.
        hits, misses = (
            sum(now[what] - before[part][what] for part, now in sim.caches().items())
            for what in ("hits", "misses")
        )
        self.hits = 100 * hits / (hits + misses)

    def speed(self) -> float:
        """Simulated seconds in one of the processor, of as many runs as fill the least time."""
        simulated = spent = 0.0
        while spent < LEAST_CPU_S:
            self.sim.restore(self.snapshot)
            began = time.process_time()
            self.sim.run(self.end)
            spent += time.process_time() - began
            simulated += self.end - self.begin
        return simulated / spent


def memory_mb() -> float:
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 1e6


def environment() -> dict[str, str]:
    """That of the programs that are measured."""
    path = f"{Path(sys.executable).parent}:{os.environ.get('PATH', '')}"
    return os.environ | {"PYTHONPATH": str(ROOT), "PATH": path}


def cpu(command: list, good: tuple = (0,)) -> float:
    """Processor seconds of a program and of all that it started."""
    return carried_out(command, good, env=environment())[1]


def mmcs_cpu(*words, good: tuple = (0,)) -> float:
    return cpu([sys.executable, "-m", "mmcs", *map(str, words)], good)


def fault() -> float:
    """CPU of a fault of a campaign."""
    costs = []
    for count in FAULTS:
        out = FOLDER / "campaign"
        shutil.rmtree(out, ignore_errors=True)
        costs.append(mmcs_cpu("campaign", "--faults", count, "--workers", 1, "--out", out))
    return (costs[1] - costs[0]) / (FAULTS[1] - FAULTS[0])


# --- programs in lock-step, and the page ----------------------------------------------------------

PROGRAM_C = """
#include <fcntl.h>
#include <math.h>
#include <mcdef.h>
#include <stdlib.h>
#include <sys/mmcs.h>
#include <unistd.h>
int ioctl(int, unsigned long, ...);
static struct mc_param params[] = {PARAMS};
int main(int argc, char **argv) {
  int joints = 6, interval = 1000, begin, now, to[6] = {0}, fd = open("/dev/mc0", O_RDWR);
  struct mc_state state[6];
  ioctl(fd, MSETNUMJOINTS, &joints), ioctl(fd, MSETINTERVAL, &interval);
  for (int axis = 0; axis < 6; ++axis) ioctl(fd, MSETPARAM, &params[axis]);
  if (write(fd, to, sizeof to) < 0 || ioctl(fd, MENABLE) < 0) return 1;
  ioctl(fd, MWAIT, &begin);
  for (now = begin; now - begin < atoi(argv[argc - 1]); ioctl(fd, MWAIT, &now)) {
    for (int axis = 0; axis < 6; ++axis)
      to[axis] = (int)lround(400 * sin(6.283185307179586 * 1e-3 * (now - begin)));
    if (write(fd, to, sizeof to) < 0 || read(fd, state, sizeof state) < 0) return 1;
  }
  return ioctl(fd, MSTOP) < 0;
}
"""
PROGRAM_PY = """
import math, sys, mmcs
params = PARAMS
with mmcs.Device("/dev/mc0") as dev:
    dev.set_num_joints(6)
    dev.set_interval(1000)
    for axis, param in enumerate(params):
        dev.set_param(axis, {**dev.get_param(axis), **param})
    dev.write([0] * 6)
    dev.enable()
    begin = now = dev.wait()
    while now - begin < int(sys.argv[1]):
        dev.write([round(400 * math.sin(2e-3 * math.pi * (now - begin)))] * 6)
        dev.read(6)
        now = dev.wait()
    dev.stop()
"""
SINE = """description = "six sines"
robot = "puma560"
dynamics = "coupled"
cards = 3
duration = 1.0
motion = [{axis = "all", kind = "sine", at = 0.0, duration = 60.0, amplitude = 400, hz = 1.0}]
"""


class LockStep:
    """The same sines of six axes: as a scenario, and by programs in lock-step."""

    def __init__(self):
        FOLDER.mkdir(parents=True, exist_ok=True)
        (FOLDER / "sines.toml").write_text(SINE)
        params = [
            {k: v for k, v in p.items() if k not in ("mode", "flags")}
            | {"mode": mcdef.mode_word(p["mode"], p["flags"])}
            for p in mmcs.load(FOLDER / "sines.toml").params
        ]
        fields = [", ".join(f".{k} = {v}" for k, v in p.items()) for p in params]
        text = ", ".join(f"{{.which = {n}, {each}}}" for n, each in enumerate(fields))
        text = text.replace("-2147483648", "-2147483647 - 1")
        (FOLDER / "sines.c").write_text(PROGRAM_C.replace("PARAMS", text))
        (FOLDER / "sines.py").write_text(PROGRAM_PY.replace("PARAMS", repr(params)))
        include = f"-I{ROOT / 'firmware' / 'include'}"
        cpu(["gcc", "-O2", "-w", include, "-o", FOLDER / "sines", FOLDER / "sines.c", "-lm"])

    def speeds(self) -> tuple[float, float]:
        """Those from C and from Python, as shares of the scenario's."""
        scenario, python = FOLDER / "sines.toml", sys.executable
        run = [python, "-m", "mmcs", "exec", "--lockstep", "--scenario", scenario, "--"]
        code = f"import mmcs, sys; mmcs.run({str(scenario)!r}, duration=int(sys.argv[1]) / 1e3)"
        costs = []
        for words in ([python, "-c", code], [*run, FOLDER / "sines"],
                      [*run, python, FOLDER / "sines.py"]):  # fmt: skip
            few, many = (cpu([*words, str(samples)]) for samples in SAMPLES)
            costs.append(many - few)
        return costs[0] / costs[1], costs[0] / costs[2]


NATIVE = """import mmcs, sys, time; setup = mmcs.load(sys.argv[1]); mmcs.run(setup)
began = time.process_time(); mmcs.run(setup); print(time.process_time() - began)"""


def wasm(scenario: str) -> float:
    """The page's machine in node, as a share of the native one's speed."""
    ratio = ROOT / "web" / "tests" / "site" / "ratio.mjs"
    page, _ = carried_out(["node", ratio, BUILD / "web", scenario])
    native, _ = carried_out([sys.executable, "-c", NATIVE, scenario], env=environment())
    return float(native) / json.loads(page)["cpu_s"]


# --- the page ------------------------------------------------------------------------------------


def simulators(count: int) -> dict[str, list[float]]:
    """name: a value of each round, or one."""
    load = Load(*LOADS[TYPICAL])
    versions = replay.build(make_setup(*LOADS[TYPICAL]))
    found: dict[str, list[float]] = {}
    for _ in range(count):
        new = {TYPICAL: load.speed()}
        for kind, version in versions.items():
            speed = new[f"{kind} {version}, RTL alone"] = replay.speed(kind)
            new[f"times as fast as {kind}"] = new[TYPICAL] / speed
        for name, value in new.items():
            found.setdefault(name, []).append(value)
    return found


def loads(count: int) -> dict[str, list[float]]:
    """The same of the machine alone, under its loads."""
    found: dict[str, list[float]] = {}
    lockstep = LockStep()
    pages = shutil.which("node") and (BUILD / "web").is_dir()
    before = memory_mb()
    made = {TYPICAL: Load(*LOADS[TYPICAL])}
    found["memory of a machine of 3 cards"] = [memory_mb() - before]
    found["hits of the model's cache"] = [made[TYPICAL].hits]
    made |= {name: Load(*load) for name, load in LOADS.items() if name != TYPICAL}
    for n in range(count):
        print(f"round {n + 1} of {count}", flush=True)
        new = {name: load.speed() for name, load in made.items()}
        new |= {f"CPU of `mmcs run {name}`":
                mmcs_cpu("run", name, "--out", FOLDER / "run", good=(0, 1))
                for name in STARTS}  # fmt: skip
        new["campaign, CPU of a fault"] = fault()
        names = ("six axes in lock-step, from C", "six axes in lock-step, from Python")
        new |= zip(names, lockstep.speeds(), strict=True)
        new |= {f"page (WebAssembly), {name}": wasm(name) for name in STARTS if pages}
        for name, value in new.items():
            found.setdefault(name, []).append(value)
    return found


def unit(name: str, value: float) -> str:
    forms = {"CPU": "{:.3g} s", "campaign,": "{:.3g} s", "times": "{:,.0f}",
             "memory": "{:.0f} MB", "hits": "{:.2f} %", "page": "{:.2f}",
             "six": "{:.2f}"}  # fmt: skip
    return forms.get(name.split(maxsplit=1)[0], "{:.3g}x").format(value)


def wanted(name: str) -> str:
    """The floor and the aim of a row, as the page shows them."""
    floor, aim = BOUNDS.get(name, (None, None))
    costs = name.startswith(("campaign", "memory"))
    words = [] if floor is None else [f"{'≤' if costs else '≥'} {floor:g}"]
    words += [] if aim is None else [f"aim {aim:g}"]
    return ", ".join(words)


def row(name: str, values: list[float]) -> str:
    """Median, least and greatest."""
    told = unit(name, statistics.median(values))
    ends = f"{unit(name, min(values))} to {unit(name, max(values))}" if len(values) > 1 else ""
    return f"| {' | '.join([name, told, ends, wanted(name)])} |"


def main() -> int:
    argparse.ArgumentParser(description=__doc__).parse_args()
    committed(MEASURED)
    for measure in (loads, simulators):  # memory in a process that has had no machine
        found = measure(ROUNDS)
        lines = [
            f"{ROUNDS} rounds, {len(os.sched_getaffinity(0))} cores.",
            "",
            "| load | this | least to greatest | wanted |",
            "|---|---|---|---|",
            *(row(name, values) for name, values in found.items()),
        ]
        rewrite(PAGE, measure.__name__, "\n".join(lines), "make bench", MEASURED)
    print(PAGE.read_text())
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
