# SPDX-License-Identifier: Apache-2.0
"""Sweeps asynchronous inputs every 5 ns against each other and the clock: `make edges`.

    edges.py [--sample N]     every N-th case only; exit 1 if one fails
    edges.py --doc            all of them, then the table of docs/evidence/edges.md

Each sweep is a program in C++ around one Verilated bench of cocotb_tests/edges.
"""

import argparse
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from cocotb_tests.lib.runner import digest_of
from tools.compiled import locked
from tools.pages import rewrite
from tools.sources import reached, sources

ROOT = Path(__file__).resolve().parent.parent
HERE = ROOT / "cocotb_tests" / "edges"
DOC = ROOT / "docs" / "evidence" / "edges.md"
BENCHES = {"vme": ("vme.cpp", "vme_chain.cpp", "vme_power.cpp", "vme_scenes.cpp"),
           "card": ("card_scenes.cpp",), "front": ("front.cpp",)}  # fmt: skip
# files in the place of those of rtl/ of the same name
MODELS = dict.fromkeys(("card", "front"), HERE / "metastable")
NOTE = "EDGES "


class BuildError(Exception):
    """A sweep does not compile; the text holds the compiler's words."""


@dataclass
class Scene:
    bench: str
    name: str
    cases: int
    failures: int
    sentence: str


def build(name: str) -> Path:
    """The program of one sweep: a build for each RTL, broken ones too, made again if old."""
    top = f"bench_edges_{name}"
    rtl = sources("rtl")
    models = sorted(MODELS[name].glob("*.sv")) if name in MODELS else []
    kept = [f for f in rtl if f.name not in {m.name for m in models}]
    files = reached([top], [*models, *kept, HERE / f"{top}.sv"])
    include = next(p for p in rtl[0].parents if p.name == "rtl")
    hardware = digest_of([*files, *sorted(include.rglob("*.svh"))]).hexdigest()[:12]
    out = ROOT / "build" / "edges" / f"{name}-{hardware}"
    with locked(out.with_suffix(".lock")):
        return _built(name, top, files, include, out)


def _built(name: str, top: str, files: list[Path], include: Path, out: Path) -> Path:
    program, note = out / "sweep", out / "built"
    now = digest_of([*sorted(HERE.glob("*.cpp")), *sorted(HERE.glob("*.h")), Path(__file__)])
    if program.is_file() and note.is_file() and note.read_text() == now.hexdigest():
        return program
    out.mkdir(parents=True, exist_ok=True)
    command = ["verilator", "--cc", "--exe", "--build", "-j", "2", "--no-timing", "--assert", "-O3",
               "--timescale", "1ps/1ps", "-CFLAGS", "-O2 -std=c++17", f"-I{include}",
               "--top-module", top, "--Mdir", str(out),
               "-o", "sweep", *map(str, files)]  # fmt: skip
    command += [str(HERE / file) for file in BENCHES[name]]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    if done.returncode:
        raise BuildError(f"edges: {top} does not build\n{(done.stdout + done.stderr)[-3000:]}")
    note.write_text(now.hexdigest())
    return program


def run(name: str, sample: int = 1, only: str = "") -> list[Scene]:
    """What each scene came to; failures are printed as the program tells them."""
    command = [str(build(name)), "--sample", str(sample)] + (["--only", only] if only else [])
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    scenes = []
    for line in done.stdout.splitlines():
        if line.startswith(NOTE):
            scene, cases, failures, sentence = line.removeprefix(NOTE).split("|")
            scenes.append(Scene(name, scene, int(cases), int(failures), sentence))
        else:
            print(line)
    if done.returncode not in (0, 1) or not scenes:
        raise BuildError(f"edges: the sweep of {name} ended with {done.returncode}\n{done.stderr}")
    return scenes


def table(scenes: list[Scene]) -> str:
    lines = ["| bench | sweep | what moves | cases | failures |", "|---|---|---|---|---|"]
    lines += [
        f"| {s.bench} | {s.name} | {s.sentence} | {s.cases:,} | {s.failures} |" for s in scenes
    ]
    cases, failures = sum(s.cases for s in scenes), sum(s.failures for s in scenes)
    return "\n".join([*lines, f"| | **all** | | **{cases:,}** | **{failures}** |"])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sample", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--doc", action="store_true")
    args = parser.parse_args()
    try:
        scenes = [s for name in BENCHES for s in run(name, args.sample, args.only)]
    except BuildError as error:
        print(error, file=sys.stderr)
        return 2
    print(table(scenes))
    if args.doc:
        rewrite(DOC, "sweeps", table(scenes), "make edges")
    return 1 if any(s.failures for s in scenes) else 0


if __name__ == "__main__":
    raise SystemExit(main())
