# SPDX-License-Identifier: Apache-2.0
"""Timing diagrams from simulation runs: docs/waves/*.svg, and WaveJSON beside the trace.

docs/waves.toml lists them. `wavegen.py` makes them all, `wavegen.py NAME...` some; `--check` says
which are stale and writes nothing. `--trace NAME` leaves the trace below build/waves with a view
for GTKWave and Surfer and opens it where there is a display.
"""

import argparse
import math
import re
import shutil
import sys
import tomllib
from pathlib import Path

from mmcs.view.waves import start_viewer
from tools.wavedraw import Line, svg, wavejson

ROOT = Path(__file__).resolve().parent.parent
LIST = ROOT / "docs" / "waves.toml"
OUT = ROOT / "docs" / "waves"
WORK = ROOT / "build" / "waves"
TOP = ROOT / "rtl" / "mmcs.sv"
MODULE = "cocotb_tests.waves.scenes"
FRAMES = 8  # in the width of a window; GTKWave counts its zoom in frames of 200 pixels
FORMS = ("bit", "hex", "addr", "volt")


class WaveError(Exception):
    """Something a user can put right; one line."""


def load() -> dict[str, dict]:
    entries = tomllib.loads(LIST.read_text())
    for name, entry in entries.items():
        for signal in entry["signals"]:
            if not 2 <= len(signal) <= 3 or (len(signal) == 3 and signal[2] not in FORMS):
                raise WaveError(
                    f"docs/waves.toml: {name}: {signal}: want [label, path, form]; "
                    f"form is one of {', '.join(FORMS)}"
                )
    return entries


def simulate(name: str, sim: str) -> tuple[Path, int, int]:
    """Runs a scene with the trace on: the trace, and the two marks in ps."""
    from cocotb_tests.lib import runner
    from cocotb_tests.waves import scenes

    marks = WORK / "marks"
    WORK.mkdir(parents=True, exist_ok=True)
    marks.unlink(missing_ok=True)
    job = runner.Job(
        MODULE,
        scenes.TOPLEVEL,
        sim,
        tuple(sorted(scenes.PARAMETERS.items())),
        environment=(("MMCS_MARKS", str(marks)),),
        waves=True,
    )
    done = runner.run(job, [name], runner.DEFAULT_SEED)[name]
    if not done.passed:
        raise WaveError(f"{name}: the scene failed; {done.text.strip()}")
    found = [int(m) for m in marks.read_text().split()] if marks.is_file() else []
    if len(found) != 2:
        raise WaveError(f"{name}: the scene lacks its two marks; see {done.log}")
    folder = WORK / name
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(done.log.parent, folder)
    trace = folder / runner.WAVES[sim]
    if not trace.is_file():
        raise WaveError(f"{name}: the simulator wrote no trace; see {done.log}")
    return trace, found[0], found[1]


def variables(trace: Path) -> tuple[dict, int]:
    """The trace's variables by path below the machine, and its unit of time in ps."""
    import pywellen

    wave = pywellen.Waveform(str(trace))
    unit = {"s": 10**12, "ms": 10**9, "us": 10**6, "ns": 10**3, "ps": 1}
    scale = wave.timescale
    paths = {}
    for var in wave.all_vars():
        path = var.full_name
        for prefix in ("TOP.", "mmcs."):
            path = path.removeprefix(prefix)
        paths.setdefault(path.split("[")[0] if path.endswith("]") else path, var)
    return paths, scale.factor * unit[str(scale.unit).rsplit(".", 1)[-1].lower()]


def lines(name: str, entry: dict, trace: Path, start: int, end: int) -> list[Line]:
    """Every signal of a diagram as changes between the two times."""
    paths, step = variables(trace)
    out = []
    for label, path, *form in entry["signals"]:
        base, high, low = split(path)
        if base not in paths:
            raise WaveError(f"docs/waves.toml: {name}: no signal {base!r} in the trace")
        changes = []
        for time, raw in paths[base].signal:
            at = time * step
            value = number(raw)
            if high is not None:
                value = value >> low & (1 << (high - low + 1)) - 1
            if at > end:
                break
            if at <= start:
                changes = [(start, value)]
            elif not changes or changes[-1][1] != value:
                changes.append((at, value))
        width = (high - low + 1) if high is not None else paths[base].length or 1
        out.append(Line(label, form[0] if form else "bit", width, changes))
    return out


def split(path: str) -> tuple[str, int | None, int]:
    if not path.endswith("]"):
        return path, None, 0
    base, _, bits = path[:-1].rpartition("[")
    high, _, low = bits.partition(":")
    return base, int(high), int(low or high)


def number(raw) -> int:
    if isinstance(raw, int):
        return raw
    text = str(raw)
    return int("".join("1" if c == "1" else "0" for c in text), 2)


def view(trace: Path, entry: dict, start: int, end: int) -> None:
    """GTKWave and Surfer views beside the trace, from one time to another, ps."""
    paths, step = variables(trace)
    zoom = -math.log2((end - start) / step / FRAMES)
    begin = start // step
    gtkw = [f'[dumpfile] "{trace.name}"', f"[timestart] {begin}", f"*{zoom:.6f} {begin}"]
    surfer = []
    found = re.findall(r"\[\s*\d+:\s*(\d+)\]\s*(\w+)", TOP.read_text())
    lowest = {net: low for low, net in found}  # index of the first bit, where it is a number
    for label, path, *_ in entry["signals"]:
        base, high, low = split(path)
        surfer.append(f"variable_add mmcs.{base}")
        alias = f"+{{{label.replace('.', ' ')}}}"
        size, least = paths[base].length or 1, int(lowest.get(base, 0))
        full = f"mmcs.{base}" + (f"[{least + size - 1}:{least}]" if size > 1 else "")
        if size == 1 or high is None or high - low + 1 == size:
            gtkw.append(f"{alias} {full}")
        else:  # bits of a row, counted from its highest
            bits = [f"({size - 1 - bit}){full}" for bit in range(high, low - 1, -1)]
            gtkw.append(f"{alias} {bits[0]}" if high == low else f"#{alias[1:]} {' '.join(bits)}")
    trace.with_suffix(".gtkw").write_text("\n".join(gtkw) + "\n")
    trace.with_suffix(".sucl").write_text("\n".join([*surfer, "zoom_fit"]) + "\n")


def make(name: str, entry: dict, sim: str) -> dict[Path, str]:
    trace, start, end = simulate(name, sim)
    drawn = lines(name, entry, trace, start, end)
    view(trace, entry, start, end)
    trace.with_suffix(".json").write_text(wavejson(entry["title"], drawn, start, end))
    return {OUT / f"{name}.svg": svg(entry["title"], drawn, start, end)}


def main() -> int:
    parser = argparse.ArgumentParser(prog="wavegen", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--trace", metavar="NAME", help="one scene, its trace and views")
    parser.add_argument("--check", action="store_true", help="which diagrams are stale")
    parser.add_argument(
        "--sim",
        choices=("icarus", "verilator"),
        default="icarus" if shutil.which("iverilog") else "verilator",
    )
    args = parser.parse_args()
    try:
        entries = load()
        wanted = [args.trace] if args.trace else args.names or list(entries)
        for name in wanted:
            if name not in entries:
                raise WaveError(f"no diagram {name!r}; docs/waves.toml has {', '.join(entries)}")
        stale = []
        for name in wanted:
            files = make(name, entries[name], args.sim)
            if args.trace:
                trace = next((WORK / name).glob("wave.[fv]*"))
                print(f"trace {trace.relative_to(ROOT)}, views (.gtkw, .sucl), WaveJSON beside it")
                start_viewer(trace)
                continue
            for path, text in files.items():
                if not path.is_file() or path.read_text() != text:
                    stale.append(path.name)
                    if not args.check:
                        OUT.mkdir(exist_ok=True)
                        path.write_text(text)
    except WaveError as error:
        print(f"wavegen: {error}", file=sys.stderr)
        return 2
    for name in stale:
        print(f"wavegen: {name} {'is stale: run tools/wavegen.py' if args.check else 'written'}")
    return 1 if args.check and stale else 0


if __name__ == "__main__":
    raise SystemExit(main())
