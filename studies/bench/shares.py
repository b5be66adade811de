# SPDX-License-Identifier: Apache-2.0
"""Where the time goes: samples of the program counter, sorted by the source file they fall in.

The engine is compiled once more with line tables (`-g1`, which changes no instruction), and a timer
of the process' CPU time interrupts it a thousand times a second. The hot loop knows nothing of it.
"""

from __future__ import annotations

import collections
import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

from mmcs import BUILD, ROOT, Sim
from studies.bench.machines import Machine, start

FOLDER = BUILD / "bench"
PARTS = ("RTL", "bus harness", "plant", "firmware", "logging", "rest")
WHERE = (  # first match counts: a piece of the path, the part
    ("/v/", "RTL"), ("verilated", "RTL"), ("sim/model/rack/", "RTL"), ("Vmmcs", "RTL"),
    ("sim/model/", "bus harness"), ("sim/plant/", "plant"), ("firmware/", "firmware"),
    ("recorder", "logging"), ("timeline", "logging"), ("hash.h", "logging"),
    ("sim/engine/", "bus harness"),
)  # fmt: skip
MOST = 100_000  # samples
LOADS_S = {"rest": 0.3, "typical": 0.1, "full": 0.2}  # begin of the stretch, s of motion


def library(machine: Machine) -> Path:
    """The speed build with line tables, in a place of its own."""
    place = FOLDER / "lines"
    env = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    env["PATH"] = f"{Path(sys.executable).parent}:{env.get('PATH', '')}"
    cxx, cc = env.get("CXX", "g++"), env.get("CC", "cc")
    command = ["make", "-s", "-f", "sim/Makefile", f"B={place.relative_to(ROOT)}",
               f"CXX={cxx} -g1", f"CC={cc} -g1", f"CARDS={machine.cards}", "KIND=speed",
               ]  # fmt: skip
    done = subprocess.run(command, cwd=ROOT, env=env, text=True, capture_output=True, check=False)
    found = sorted(place.glob("*/libmmcs_sim.so"), key=lambda p: p.stat().st_mtime)
    if done.returncode or not found:
        raise RuntimeError(f"the measuring build failed: {done.stderr.strip()[-300:]}")
    suffix = f"speed_c{machine.cards}"
    named = [p for p in found if p.parent.name == suffix]
    return (named or found)[-1]


def _sampler() -> ctypes.CDLL:
    source, target = Path(__file__).with_name("sampler.c"), FOLDER / "sampler.so"
    FOLDER.mkdir(parents=True, exist_ok=True)
    subprocess.run(
        ["cc", "-O2", "-fPIC", "-shared", "-o", target, source, "-lrt"], check=True, text=True
    )
    lib = ctypes.CDLL(str(target))
    lib.sampler_start.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_int]
    return lib


def measure(machine: Machine, load: str, cpu_s: float = 3.0) -> dict[str, float]:
    """The share of each part, 0 to 1; raises RuntimeError where it cannot be had."""
    if not shutil.which("addr2line"):
        raise RuntimeError("no addr2line (binutils)")
    lib = library(machine)
    sampler = _sampler()
    buffer = (ctypes.c_uint64 * MOST)()
    setup = machine.setup(load)
    with Sim(lib, setup.config(), setup.motors(), setup.links()) as sim:
        _, motion = start(sim, setup)
        begin = motion + LOADS_S[load]
        sim.run(begin)
        snapshot, stretch, count = sim.snapshot(), 0.3, 0
        if sampler.sampler_start(buffer, MOST, 1000):
            raise RuntimeError("no timer of CPU time on this system")
        while sampler.sampler_count() < 1000 * cpu_s and count < 400:
            sim.restore(snapshot)
            sim.run(begin + stretch)
            count += 1
        got = sampler.sampler_stop()
        return _sort([buffer[n] for n in range(got)], lib)


def _sort(addresses: list[int], lib: Path) -> dict[str, float]:
    spans = []
    for line in Path("/proc/self/maps").read_text().splitlines():
        if line.endswith(str(lib)):
            fields = line.split()
            low, high = (int(x, 16) for x in fields[0].split("-"))
            spans.append((low, high, int(fields[2], 16)))
    base = min(low - offset for low, _, offset in spans)
    inside = collections.Counter()
    rest = 0
    for address in addresses:
        if any(low <= address < high for low, high, _ in spans):
            inside[address - base] += 1
        else:
            rest += 1
    done = subprocess.run(
        ["addr2line", "-e", lib, *(hex(a) for a in inside)],
        text=True, capture_output=True, check=True,
    )  # fmt: skip
    parts = collections.Counter({"rest": rest})
    for (_, samples), line in zip(inside.items(), done.stdout.splitlines(), strict=True):
        parts[next((part for piece, part in WHERE if piece in line), "rest")] += samples
    total = sum(parts.values())
    if total < 100:
        raise RuntimeError("too few samples")
    return {part: parts[part] / total for part in PARTS}
