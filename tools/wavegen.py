# SPDX-License-Identifier: Apache-2.0
"""Timing diagrams from simulation runs, drawn by WaveDrom: docs/waves/*.svg.

docs/waves.toml lists them. `wavegen.py` makes them all, `wavegen.py NAME...` some; `--check` says
which are stale and writes nothing. A diagram has one step for each time at which a signal changes.
"""

import argparse
import json
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LIST = ROOT / "docs" / "waves.toml"
OUT = ROOT / "docs" / "waves"
MARKS = ROOT / "build" / "waves_marks"
PS = {"s": 10**12, "ms": 10**9, "us": 10**6, "ns": 10**3, "ps": 1}


def simulate(name: str) -> tuple[Path, int, int]:
    """Runs a scene on Icarus with the trace on: the trace, and the two marks in ps."""
    from cocotb_tests.lib import runner
    from cocotb_tests.waves import scenes

    MARKS.parent.mkdir(exist_ok=True)
    MARKS.unlink(missing_ok=True)
    job = runner.Job(
        "cocotb_tests.waves.scenes",
        scenes.TOPLEVEL,
        "icarus",
        tuple(sorted(scenes.PARAMETERS.items())),
        environment=(("MMCS_MARKS", str(MARKS)),),
        waves=True,
    )
    done = runner.run(job, [name], runner.DEFAULT_SEED)[name]
    if not done.passed:
        raise SystemExit(f"wavegen: {name}: the scene failed; {done.text.strip()}")
    start, end = map(int, MARKS.read_text().split())
    return done.log.with_name(runner.WAVES["icarus"]), start, end


def changes(trace: Path, signals: list[list[str]], start: int, end: int) -> list[dict[int, int]]:
    """Of each signal, {time in ps: value} between the marks."""
    import pywellen

    wave = pywellen.Waveform(str(trace))
    step = wave.timescale.factor * PS[str(wave.timescale.unit).rsplit(".", 1)[-1].lower()]
    paths = {}
    for var in wave.all_vars():
        path = var.full_name.removeprefix("mmcs.")
        paths.setdefault(path.rpartition("[")[0] if path.endswith("]") else path, var)
    out = []
    for _, path, *_ in signals:
        base, _, bits = path[:-1].rpartition("[") if path.endswith("]") else (path, "", "")
        high, _, low = bits.partition(":")
        found = {}
        for time, raw in paths[base].signal:
            text = format(raw, "b") if isinstance(raw, int) else str(raw)
            value = int("".join("1" if c == "1" else "0" for c in text), 2)
            if bits:
                value = value >> int(low or high) & (1 << int(high) - int(low or high) + 1) - 1
            if time * step <= end:
                found[max(time * step, start)] = value
        out.append(found)
    return out


def shown(value: int, form: str) -> str:
    if form == "volt":  # signed, 32768 = 10 V
        return f"{(value - (value >> 15 << 16)) / 3276.8:.2f}"
    return f"{value << 1:04X}" if form == "addr" else f"{value:02X}"


def wavejson(entry: dict, found: list[dict[int, int]], start: int) -> dict:
    times = sorted({at for values in found for at in values} | {start})
    rows = []
    for (label, _, *form), values in zip(entry["signals"], found, strict=True):
        wave, data, last = "", [], None
        for at in times:
            value = values.get(at, last)
            if value == last:
                wave += "."
            elif not form or form[0] == "bit":
                wave += str(value)
            else:
                wave += "="
                data.append(shown(value, form[0]))
            last = value
        rows.append({"name": label, "wave": wave, "data": data})
    ticks = " ".join(f"{(at - start) / 1000:g}" for at in times)
    return {"head": {"text": entry["title"]}, "signal": rows, "foot": {"text": f"ns: {ticks}"}}


def draw(name: str, entry: dict) -> str:
    import wavedrom

    trace, start, end = simulate(name)
    found = changes(trace, entry["signals"], start, end)
    svg = wavedrom.render(json.dumps(wavejson(entry, found, start))).tostring() + "\n"
    used = set(re.findall(r'xlink:href="#([^"]+)"', svg))
    head, defs, rest = re.split("(?<=<defs>)|(?=</defs>)", svg)
    kept = [m[0] for m in re.finditer(r'<g id="([^"]+)">.*?</g>', defs) if m[1] in used]
    return head + "".join(kept) + rest


def main() -> int:
    parser = argparse.ArgumentParser(prog="wavegen", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--check", action="store_true", help="which diagrams are stale")
    args = parser.parse_args()
    entries, stale = tomllib.loads(LIST.read_text()), 0
    for name in args.names or entries:
        path, text = OUT / f"{name}.svg", draw(name, entries[name])
        if path.is_file() and path.read_text() == text:
            continue
        print(f"wavegen: {name} {'is stale: run tools/wavegen.py' if args.check else 'written'}")
        stale += args.check
        if not args.check:
            path.write_text(text)
    return int(stale > 0)


if __name__ == "__main__":
    sys.exit(main())
