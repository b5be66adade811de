# SPDX-License-Identifier: Apache-2.0
"""`make bench`, `make bench BASE=commit`: how fast it is, as docs/evidence/bench.md shows it.

Everything is taken in one run, in processor time, round by round: this tree, and the other commit
in a folder of its own with an engine of its own. A figure is the median of the rounds, a ratio that
of its two figures; behind it stand the least and the greatest of the ratios within a round, which
tell how much of it the computer's other work may be.
"""

import argparse
import json
import math
import os
import resource
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

import mmcs
from mmcs import BUILD, ROBOTS, ROOT, Files, Session, machine, mcdef, read_toml
from tools.pages import committed, rewrite

FOLDER = BUILD / "bench"
PAGE = ROOT / "docs" / "evidence" / "bench.md"
MEASURED = "rtl sim firmware mmcs"  # what the figures depend on
LEAST_CPU_S = 0.25  # of a measurement
LOADS = {  # cards, with an arm, what it does
    "6 axes, coupled PUMA, typical": (3, True, "typical"),
    "6 axes, full joint speed": (3, True, "full"),
    "32 axes, typical": (16, False, "typical"),
}
STARTS = ("lab500", "puma560")
FAULTS = (10, 40)  # of two campaigns, whose difference is that of so many faults
SAMPLES = (300, 9300)  # of two runs of a program, and of the scenario
BOUNDS = {  # floor, aim: of the ratio, or of the figure where there is no other
    "6 axes, coupled PUMA, typical": (1.0, 2.0),
    "6 axes, full joint speed": (1.0, 1.8),
    "32 axes, typical": (1.0, 2.5),
    "hits of the model's cache, all": (99.5, None),
    "memory of a machine of 3 cards": (32, None),
    "page (WebAssembly), lab500": (0.7, None),
    "page (WebAssembly), puma560": (0.7, None),
    "campaign, CPU of a fault": (0.65, 0.35),
    "build of the engine from nothing": (1.0, None),
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


def _setup(cards: int, arm: bool, load: str):
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
        setup = _setup(cards, arm, load)
        self.sim = sim = machine(setup)
        session = Session(sim, setup)
        session.begin()
        begin = session.start + WINDOWS[arm, load][0]
        self.end = begin + WINDOWS[arm, load][1]
        sim.run(begin)
        self.snapshot, self.begin = sim.snapshot(), begin
        before = sim.caches()
        sim.run(self.end)
        # Hits and misses of each part while it does this for the first time.
        steps = {part: [now[what] - before[part][what] for what in ("hits", "misses")]
                 for part, now in sim.caches().items()}  # fmt: skip
        self.steps = {"all": [*map(sum, zip(*steps.values(), strict=True))]} | steps

    def measure(self) -> dict:
        """Simulated seconds and those of the processor, of as many runs as fill the least time."""
        found = {"s": 0.0, "cpu": 0.0}
        while found["cpu"] < LEAST_CPU_S:
            self.sim.restore(self.snapshot)
            began = time.process_time()
            self.sim.run(self.end)
            found["cpu"] += time.process_time() - began
            found["s"] += self.end - self.begin
        return found | {"cache": self.steps}


# Runs in either tree. A commit before this script has a bench of its own, in one of two places.
SERVER = """
import inspect, json, resource, sys
try:
    from studies.bench import Load
except ImportError:
    try:
        from studies.bench.machines import Loaded, Machine, ensure_library
    except ImportError:
        sys.path.insert(0, "sim")
        from bench.machines import Loaded, Machine, ensure_library
    more = {"skip": True} if "skip" in inspect.signature(ensure_library).parameters else {}
    def Load(cards, arm, load):
        return Loaded(Machine(cards, True, arm), load, ensure_library(cards, "speed", **more))
def pages():  # in memory
    return int(open("/proc/self/statm").read().split()[1])
kept = {}
for line in sys.stdin:
    key = tuple(json.loads(line))
    before = pages()
    if key not in kept:
        kept[key] = Load(*key)
    found = kept[key].measure()
    print(json.dumps(found | {"mb": (pages() - before) * resource.getpagesize() / 1e6}), flush=True)
"""


def cpu(command: list, cwd: Path = ROOT, env: dict | None = None, good: tuple = (0,)) -> float:
    """Processor seconds of a program and of all that it started."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=cwd, env=env, text=True, capture_output=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in good:
        said = (done.stderr or done.stdout).strip()[-300:]
        raise SystemExit(f"mmcs: bench: {' '.join(map(str, command))} failed: {said}")
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


class Tree:
    """A checkout with its own engine, measured from outside."""

    def __init__(self, folder: Path):
        self.folder = folder
        path = f"{Path(sys.executable).parent}:{os.environ.get('PATH', '')}"
        gone = ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")
        self.env = {k: v for k, v in os.environ.items() if k not in gone}
        self.env |= {"PYTHONPATH": str(folder), "PATH": path, "PYTHON": sys.executable}
        self._server = subprocess.Popen(
            [sys.executable, "-c", SERVER], cwd=folder, env=self.env, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip

    def measure(self, load: tuple) -> dict:
        self._server.stdin.write(json.dumps(load) + "\n")
        self._server.stdin.flush()
        if not (line := self._server.stdout.readline()):
            raise SystemExit(f"mmcs: bench: the machine of {self.folder} does not run; see above")
        return json.loads(line)

    def mmcs(self, *words, good: tuple = (0,)) -> float:
        return cpu([sys.executable, "-m", "mmcs", *map(str, words)], self.folder, self.env, good)

    def start(self, scenario: str) -> float:
        return self.mmcs("run", scenario, "--out", FOLDER / "run", good=(0, 1))

    def fault(self) -> float | None:
        """CPU of a fault of a campaign; None: a commit without campaigns."""
        if not list((self.folder / "mmcs").glob("*/campaign.py")):
            return None
        costs = []
        for count in FAULTS:
            out = FOLDER / "campaign"
            shutil.rmtree(out, ignore_errors=True)
            costs.append(self.mmcs("campaign", "--faults", count, "--workers", 1, "--out", out))
        return (costs[1] - costs[0]) / (FAULTS[1] - FAULTS[0])

    def build(self) -> float:
        place = self.folder / "build" / "bench-engine"
        shutil.rmtree(place, ignore_errors=True)
        command = "make -s -f sim/Makefile B=build/bench-engine CARDS=3 KIND=speed SKIP=1"
        made = cpu(command.split(), self.folder, self.env | {"CCACHE_DISABLE": "1"})
        shutil.rmtree(place)
        return made


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

    def speeds(self, tree: Tree) -> tuple[float, float]:
        """Those from C and from Python, as shares of the scenario's."""
        scenario, python = FOLDER / "sines.toml", sys.executable
        run = [python, "-m", "mmcs", "exec", "--lockstep", "--scenario", scenario, "--"]
        code = f"import mmcs, sys; mmcs.run({str(scenario)!r}, duration=int(sys.argv[1]) / 1e3)"
        costs = []
        for words in ([python, "-c", code], [*run, FOLDER / "sines"],
                      [*run, python, FOLDER / "sines.py"]):  # fmt: skip
            few, many = (cpu([*words, str(samples)], env=tree.env) for samples in SAMPLES)
            costs.append(many - few)
        return costs[0] / costs[1], costs[0] / costs[2]


NATIVE = """import mmcs, sys, time; setup = mmcs.load(sys.argv[1]); mmcs.run(setup)
began = time.process_time(); mmcs.run(setup); print(time.process_time() - began)"""


def wasm(tree: Tree, scenario: str) -> float:
    """The page's machine in node, as a share of the native one's speed."""
    ratio = ROOT / "web" / "tests" / "site" / "ratio.mjs"
    told = [
        subprocess.run(command, cwd=ROOT, env=tree.env, text=True, capture_output=True, check=True)
        for command in (["node", ratio, BUILD / "web", scenario],
                        [sys.executable, "-c", NATIVE, scenario])
    ]  # fmt: skip
    return float(told[1].stdout) / json.loads(told[0].stdout)["cpu_s"]


def rounds(trees: list[Tree], count: int) -> dict[str, list]:
    """name: of each round, one value for each tree; a share that needs no other tree is alone."""
    found: dict[str, list] = {}
    lockstep = LockStep()
    pages = shutil.which("node") and (BUILD / "web").is_dir()
    for n in range(count):
        print(f"round {n + 1} of {count}", flush=True)

        def add(name: str, values: list) -> None:
            found.setdefault(name, []).append(values)

        for name, load in LOADS.items():
            told = [tree.measure(load) for tree in trees]
            add(name, [one["s"] / one["cpu"] for one in told])
            if n == 0 and name == next(iter(LOADS)):
                add("memory of a machine of 3 cards", [one["mb"] for one in told])
                for part, (hits, misses) in told[0]["cache"].items():
                    add(f"hits of the model's cache, {part}", [100 * hits / (hits + misses)])
        for name in STARTS:
            add(f"CPU of `mmcs run {name}`", [tree.start(name) for tree in trees])
        add("campaign, CPU of a fault", [tree.fault() for tree in trees])
        c, python = lockstep.speeds(trees[0])
        add("six axes in lock-step, from C", [c])
        add("six axes in lock-step, from Python", [python])
        for name in STARTS if pages else ():
            add(f"page (WebAssembly), {name}", [wasm(trees[0], name)])
    print("build", flush=True)
    found["build of the engine from nothing"] = [[tree.build() for tree in trees]]
    return found


def unit(name: str, value: float) -> str:
    forms = {"6 axes": "{:.2f}x", "32 axes": "{:.2f}x", "memory": "{:.0f} MB", "hits": "{:.2f} %",
             "page": "{:.2f}", "six axes": "{:.2f}"}  # fmt: skip
    form = next((form for start, form in forms.items() if name.startswith(start)), "{:.3g} s")
    return form.format(value)


def wanted(name: str) -> str:
    """The floor and the aim of a row, as the page shows them."""
    floor, aim = BOUNDS.get(name, (None, None))
    costs = name.startswith(("campaign", "build", "memory"))
    words = [] if floor is None else [f"{'≤' if costs else '≥'} {floor:g}"]
    words += [] if aim is None else [f"aim {aim:g}"]
    return ", ".join(words)


def row(name: str, values: list[list]) -> str:
    """Other, this, ratio: above 1 is faster, or dearer for what costs."""
    now = statistics.median(v[0] for v in values)
    cells = ["–", unit(name, now), "–"]
    if len(values[0]) > 1 and all(v[1] for v in values):
        other = statistics.median(v[1] for v in values)
        ratios = [v[0] / v[1] for v in values]
        cells[0] = unit(name, other)
        cells[2] = f"{now / other:.2f} ({min(ratios):.2f} to {max(ratios):.2f})"
    return f"| {' | '.join([name, *cells, wanted(name)])} |"


def write_page(found: dict[str, list], base: str | None) -> None:
    count = max(len(values) for values in found.values())
    lines = [
        f"{count} rounds, {len(os.sched_getaffinity(0))} cores.",
        "",
        f"| load | {base or 'other'} | this | ratio | wanted |",
        "|---|---|---|---|---|",
        *(row(name, values) for name, values in found.items()),
    ]
    made = f"make bench BASE={base}" if base else "make bench"
    rewrite(PAGE, "bench", "\n".join(lines), made, MEASURED)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("base", nargs="?", help="a commit to compare with")
    parser.add_argument("--rounds", type=int, default=7)
    given = parser.parse_args()
    committed(MEASURED)
    git = ["git", "-C", str(ROOT)]
    trees = [Tree(ROOT)]
    if given.base:
        folder = FOLDER / given.base
        if not folder.exists():
            folder.mkdir(parents=True)
            packed = subprocess.run([*git, "archive", given.base], check=True, capture_output=True)
            subprocess.run(["tar", "-x", "-C", folder], input=packed.stdout, check=True)
        trees.append(Tree(folder))
    found = rounds(trees, given.rounds)
    (FOLDER / "bench.json").write_text(json.dumps(found, indent=1))
    write_page(found, given.base)
    print(PAGE.read_text())
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
