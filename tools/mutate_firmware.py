# SPDX-License-Identifier: Apache-2.0
"""Mutation score of the servo and the driver: `make mutation-firmware`.

Mutants of every file of firmware/mc come from the universalmutator package, fetched at a fixed
version into uv's cache. A mutant that does not compile, or whose optimised object code equals the
original's or an earlier mutant's, does not count. The others meet, until one notices:

  unit      the C test programs of firmware/tests, every test function; then once more with
            address and undefined-behaviour sanitizers
  servo     20,000 samples of the servo law against firmware/tests/servo_reference.py
  scenario  closed loops on the simulated machine, judged by their own expectations

Score = noticed / relevant. `--sample N` takes N relevant mutants of every file (seed printed),
`--all` every one; `--only TEXT` the files so named; survivors are listed in
build/mutation_firmware/survivors.txt; `--write` puts the table into docs/mutation_firmware.md.
"""

from __future__ import annotations

import argparse
import datetime
import multiprocessing
import os
import random
import shutil
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MC = ROOT / "firmware" / "mc"
TESTS = ROOT / "firmware" / "tests"
WORK = ROOT / "build" / "mutation_firmware"
FIXED, FIXED_CHECKED = WORK / "fixed", WORK / "fixed_checked"
OBJ = ROOT / "build" / "sim" / "obj"
PAGE = ROOT / "docs" / "mutation_firmware.md"
TOOL = "universalmutator==1.14.1"
INCLUDE = [f"-I{ROOT / 'firmware' / d}" for d in ("include", "mc", "tests")]
NO = ["-Werror=int-conversion", "-Werror=incompatible-pointer-types"]  # as in the true build
CFLAGS = ["-std=c11", "-O2", "-fPIC", *NO, *INCLUDE]
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-O1"]
CARDS = (1, 3)  # what the scenarios below need
LIMIT_S = 20  # a guard against endless loops; a whole test program takes well under a second
# Quick ones first; together they use every call, mode, limit and error of the driver.
SCENARIOS = [
    "lab500", "lab500_torque", "fault_estop", "fault_encoder_cut_ilim", "fault_host_stall",
    "fault_irq_lost", "fault_bus_errors", "fault_card_absent", "fault_encoder_swap_poschk",
    "puma560_calibrate_30", "puma560_bounce", "user_loop", "adda_filter", "servo_overrun",
]  # fmt: skip


@dataclass
class Mutant:
    source: Path  # the file of firmware/mc
    text: str
    number: int
    object: Path | None = None
    noticed: str = ""  # the stage and test that saw it; empty: it survived


def cc(source: Path, out: Path, *flags: str) -> bool:
    command = ["cc", *CFLAGS, *flags, "-c", "-o", str(out), source.name]
    done = subprocess.run(command, cwd=source.parent, capture_output=True, check=False, timeout=60)
    return done.returncode == 0


def generate(source: Path) -> list[Mutant]:
    """Every mutant that the generator makes of a file, in its order."""
    folder = WORK / "mutants" / source.stem
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    command = ["uv", "tool", "run", "-q", "--from", TOOL, "mutate", str(source), "--noCheck"]
    done = subprocess.run(
        [*command, "--mutantDir", str(folder)], capture_output=True, text=True, check=False
    )
    found = sorted(folder.glob("*.c"), key=lambda p: int(p.stem.rpartition(".")[2]))
    if done.returncode or not found:
        print(
            f"mutation: {TOOL} made nothing of {source.name}: {done.stderr[-300:]}", file=sys.stderr
        )
        raise SystemExit(1)
    return [Mutant(source, p.read_text(), i) for i, p in enumerate(found)]


def relevant(mutants: list[Mutant], want: int) -> list[Mutant]:
    """The first `want` mutants (0: all) that compile to code of their own."""
    source = mutants[0].source
    folder = WORK / "objects" / source.stem
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "plain").mkdir(parents=True)
    shutil.copy(source, folder / "plain" / source.name)
    cc(folder / "plain" / source.name, folder / "plain.o")
    seen = {(folder / "plain.o").read_bytes()}
    kept: list[Mutant] = []

    def compiled(m: Mutant) -> Mutant | None:
        place = folder / str(m.number)
        place.mkdir()
        (place / source.name).write_text(m.text)
        m.object = folder / f"{m.number}.o"
        good = cc(place / source.name, m.object)
        shutil.rmtree(place)
        return m if good else None

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for start in range(0, len(mutants), 32):
            for m in filter(None, pool.map(compiled, mutants[start : start + 32])):
                code = m.object.read_bytes()
                if code in seen or (want and len(kept) == want):
                    m.object.unlink()
                    continue
                seen.add(code)
                kept.append(m)
            if want and len(kept) == want:
                break
    return kept


# --- the tests, quick ones first -----------------------------------------------------------


def programs() -> dict[str, list[str]]:
    """Test program -> its functions; also compiles what all mutants share."""
    for folder, flags in ((FIXED, []), (FIXED_CHECKED, SANITIZE)):
        folder.mkdir(parents=True, exist_ok=True)
        for source in [*MC.glob("*.c"), *TESTS.glob("*.c")]:
            assert cc(source, folder / f"{source.stem}.o", *flags), source
    table = {}
    for source in sorted(TESTS.glob("test_*.c")):
        program = link(source.stem, FIXED, [FIXED / f"{p.stem}.o" for p in MC.glob("*.c")])
        listed = subprocess.run([program], capture_output=True, text=True, check=True).stdout
        table[source.stem] = listed.split()
    return table


def link(program: str, fixed: Path, driver: list[Path], out: Path | None = None) -> Path:
    out = out or fixed / program
    flags = SANITIZE if fixed == FIXED_CHECKED else []
    command = ["cc", *flags, "-o", out, fixed / f"{program}.o", fixed / "mock.o", *driver]
    subprocess.run(command, check=True, capture_output=True)
    return out


def checked_object(m: Mutant) -> Path:
    """The mutant compiled with sanitizers."""
    place = m.object.with_suffix(".checked")
    place.mkdir()
    (place / m.source.name).write_text(m.text)
    out = m.object.with_suffix(".checked.o")
    cc(place / m.source.name, out, *SANITIZE)
    shutil.rmtree(place)
    return out


def unit(m: Mutant, table: dict[str, list[str]], fixed: Path) -> str:
    mutated = checked_object(m) if fixed == FIXED_CHECKED else m.object
    driver = [fixed / f"{p.stem}.o" for p in MC.glob("*.c") if p != m.source] + [mutated]
    for program, functions in table.items():
        out = m.object.with_suffix("." + program)
        try:
            link(program, fixed, driver, out)
        except subprocess.CalledProcessError:
            return "does not link"
        try:
            for name in functions:
                done = subprocess.run(
                    [out, name], capture_output=True, check=False, timeout=LIMIT_S
                )
                if done.returncode:
                    return f"unit {name}"
        except subprocess.TimeoutExpired:
            return "unit: never ends"
        finally:
            out.unlink()
    return ""


def in_child(work, *args) -> str:
    """Runs work(*args) -> text in a child process: what crashes or hangs is noticed too."""
    ours, theirs = multiprocessing.Pipe(duplex=False)

    def body():
        sys.stdout = sys.stderr = open(os.devnull, "w")  # noqa: SIM115
        try:
            theirs.send(work(*args))
        except BaseException as error:  # noqa: BLE001
            theirs.send(f"{work.__name__}: {type(error).__name__}")

    child = multiprocessing.get_context("fork").Process(target=body)
    child.start()
    theirs.close()
    told = "crash"
    if ours.poll(LIMIT_S * 30):
        try:
            told = ours.recv()
        except EOFError:
            told = f"{work.__name__}: crash"
    else:
        told = f"{work.__name__}: never ends"
    child.kill()
    child.join()
    return told


def servo(m: Mutant) -> str:
    if m.source.name != "servo.c":
        return ""
    library = m.object.with_suffix(".so")
    parts = [m.object, FIXED / "servo_batch.o"]
    subprocess.run(["cc", "-shared", "-o", library, *parts], check=True)
    return in_child(servo_samples, library)


def servo_samples(library: Path) -> str:
    sys.path.insert(0, str(TESTS))
    import test_servo

    test_servo.compile_c = lambda *_: library
    try:
        for seed in (1, 2):
            test_servo.lock_step(seed, 10_000)
        test_servo.test_integrator_loses_nothing()
        test_servo.test_saturates_with_the_right_sign()
    except AssertionError:
        return "servo lock step"
    return ""


def scenario(m: Mutant) -> str:
    return in_child(closed_loops, m.object, m.source.stem)


def closed_loops(mutated: Path, stem: str) -> str:
    from mmcs import build
    from mmcs.load import load
    from mmcs.report import make_report
    from mmcs.runner import simulate

    made: dict[int, Path] = {}

    def with_mutant(cards, *_args, **_more) -> Path:
        if cards not in made:
            made[cards] = mutated.with_suffix(f".{cards}.so")
            objects = [o for o in (WORK / "sim").glob("*/*.o") if o.stem != stem]
            objects += [*(WORK / "sim" / f"{cards}.cards").glob("*.obj"), mutated]
            command = ["g++", "-shared", "-Wl,-Bsymbolic", "-o", made[cards], *objects, "-pthread"]
            subprocess.run(command, check=True)
        return made[cards]

    build.ensure_library = with_mutant
    try:
        for name in SCENARIOS:
            report = make_report(simulate(load(name, ("skip=true",))), "native")
            missed = [item["what"] for item in report["expect"] if not item["ok"]]
            if missed:
                return f"scenario {name}"
    finally:
        for file in made.values():
            file.unlink(missing_ok=True)
    return ""


def keep_simulator() -> None:
    """Builds the simulator and keeps its parts: a later change of the sources does not meddle."""
    from mmcs.build import ensure_library

    shutil.rmtree(WORK / "sim", ignore_errors=True)
    for cards in CARDS:
        library = ensure_library(cards, "speed", skip=True)
        folder = WORK / "sim" / f"{cards}.cards"
        folder.mkdir(parents=True)
        shutil.copy(library.parent / "build_id.o", folder / "build_id.obj")
        # one model serves machines of all sizes
        shutil.copy(library.parents[1] / "speed_rack" / "model.o", folder / "model.obj")
    for part in ("engine", "plant", "mc", "runtime"):
        shutil.copytree(OBJ / part, WORK / "sim" / part)


def judge(m: Mutant, table: dict[str, list[str]]) -> Mutant:
    m.noticed = unit(m, table, FIXED) or servo(m) or unit(m, table, FIXED_CHECKED) or scenario(m)
    return m


# --- what is told --------------------------------------------------------------------------


def change(m: Mutant) -> str:
    """The first line that differs: number, what it was, what it is."""
    old, new = m.source.read_text().splitlines(), m.text.splitlines()
    for i, (a, b) in enumerate(zip(old, new, strict=False), 1):
        if a != b:
            return f"{m.source.name}:{i}: {a.strip()}  ->  {b.strip() or '(nothing)'}"
    return f"{m.source.name}: the last lines differ"


def page(rows: list[tuple], survivors: list[Mutant], command: str) -> str:
    lines = [
        "# Mutation score of the firmware",
        "",
        "How many small changes of the servo and driver the tests notice. The method, and what",
        "counts, is told at the head of `tools/mutate_firmware.py`. Generated by",
        f"`{command}` on {datetime.date.today()}.",
        "",
        "| file | relevant mutants | noticed by unit tests | by the servo's reference "
        "| by scenarios | survive | score |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, total, by_unit, by_servo, by_loop, left in rows:
        score = f"{100 * (total - left) / total:.1f} %" if total else "-"
        lines.append(
            f"| `{name}` | {total} | {by_unit} | {by_servo} | {by_loop} | {left} | {score} |"
        )
    lines += ["", "## What survives", "", "```"]
    lines += [change(m) for m in survivors] or ["nothing"]
    lines += ["```", ""]
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--sample", type=int, default=60, metavar="N", help="mutants of each file")
    parser.add_argument("--all", action="store_true", help="every mutant")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--only", default="", metavar="TEXT", help="files whose name holds the text"
    )
    parser.add_argument("--write", action="store_true", help=f"write {PAGE.relative_to(ROOT)}")
    args = parser.parse_args()
    files = [p for p in sorted(MC.glob("*.c")) if args.only in p.name]
    if not files:
        print(f"mutation: no file of firmware/mc is called {args.only!r}", file=sys.stderr)
        return 2
    sys.path.insert(0, str(ROOT))
    import mmcs.report
    import mmcs.runner  # noqa: F401  before the first fork: a child inherits what is loaded

    keep_simulator()
    started = time.monotonic()
    print(f"mutation: seed {args.seed}, {'every mutant' if args.all else f'{args.sample} a file'}")
    table = programs()
    for source in files:  # what counts as noticed must not be noticed in the files as they are
        whole = Mutant(source, source.read_text(), -1, FIXED / f"{source.stem}.o")
        if judge(whole, table).noticed:
            print(f"mutation: {source.name} as it is fails: {whole.noticed}", file=sys.stderr)
            return 1
    rows, survivors = [], []
    for source in files:
        mutants = generate(source)
        random.Random(f"{args.seed}{source.name}").shuffle(mutants)
        kept = relevant(mutants, 0 if args.all else args.sample)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            judged = list(pool.map(lambda m: judge(m, table), kept))
        judged = [m for m in judged if m.noticed != "does not link"]
        by = [sum(m.noticed.startswith(s) for m in judged) for s in ("unit", "servo")]
        left = [m for m in judged if not m.noticed]
        loops = len(judged) - sum(by) - len(left)
        for how, n in Counter(m.noticed for m in judged).most_common():
            print(f"  {n:4} {how or 'survive'}", flush=True)
        rows.append((source.name, len(judged), *by, loops, len(left)))
        survivors += left
        for m in left:
            print("survives", change(m), flush=True)
        print(f"{source.name}: {len(judged) - len(left)} of {len(judged)} noticed", flush=True)
    totals = [sum(r[i] for r in rows) for i in range(1, 6)]
    rows.append(("all", *totals))
    (WORK / "survivors.txt").write_text("\n".join(map(change, survivors)) + "\n")
    how = "--all" if args.all else f"--sample {args.sample} --seed {args.seed}"
    if args.write:
        PAGE.write_text(page(rows, survivors, f"python tools/mutate_firmware.py {how}"))
    score = 100 * (totals[0] - totals[4]) / totals[0]
    print(
        f"mutation: {totals[0] - totals[4]} of {totals[0]} noticed, {score:.1f} %,"
        f" {time.monotonic() - started:.0f} s"
    )
    return 0 if score >= 90 else 1


if __name__ == "__main__":
    raise SystemExit(main())
