# SPDX-License-Identifier: Apache-2.0
"""Is a test any good? Breaks the design on purpose and asks whether anything notices.

    run.py tests [--only TEXT] [--sample N] [--seed S] [--sim SIM]    make sabotage
    run.py proofs [--only TEXT]                                       make formal SABOTAGE=1
    run.py mutants ...                                                make mutation
    run.py driver-mutants ...                                         make mutation-firmware

`tests` and `proofs` take the breakages of list.toml: each is one line of a copy below
build/breakage, and the named tests of cocotb, of the driver, of programs or proof must turn red.
What the list names must pass on the design as it is. The mutants of the RTL and of the driver are
made by generators (mutate.py, mutate_firmware.py, which have options of their own).
"""

import argparse
import os
import random
import re
import shutil
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
LIST = HERE / "list.toml"
WORK = Path("build") / "breakage"  # relative: the provers see the folder they are started in
CPU_S = 900  # of processor time for a process of a broken design: it hangs, and that is noticed
WALL_S = 4 * 3600  # a guard against what hangs without computing: that says nothing
# (entry, folder of the broken copy) -> (complaint, or None if it was noticed; what noticed it)
Judge = Callable[[dict, Path], tuple[str | None, str]]
KINDS = {"tests": ("test", "unit", "served"), "proofs": ("proof",)}
PARTS = {  # that are copied
    "test": ("rtl",), "unit": ("firmware",), "proof": ("rtl", "formal"),
    "served": ("rtl", "firmware", "sim", "mmcs", "docs/labs", "tools", "mmcs.core", "conftest.py",
               "pyproject.toml"),
}  # fmt: skip


def entries(kind: str, only: str = "") -> list[dict]:
    """Breakages for tests, or for proofs; `only`: whose name, file, proof or requirement has it."""
    listed = tomllib.loads(LIST.read_text()).items()
    every = [{"file": file, "name": name} | e for file, es in listed for name, e in es.items()]
    mine = [e for e in every if any(key in e for key in KINDS[kind])]
    group = [e.get("proof", {}).get("group", "") for e in mine]
    text = [f"{e['name']}\n{e['file']}\n{e.get('req', '')}" for e in mine]
    return [e for e, t, g in zip(mine, text, group, strict=True) if only in f"{t}\n{g}"]


def broken(entry: dict, folder: Path, parts: tuple[str, ...] = ("rtl",)) -> str | None:
    """Copies the parts of the project and breaks a line; the complaint if it is not there once."""
    shutil.rmtree(folder, ignore_errors=True)
    for part in parts:
        copy = shutil.copytree if (ROOT / part).is_dir() else shutil.copy
        copy(ROOT / part, folder / part)
    file = folder / entry["file"]
    if not file.is_file():
        return f"there is no {entry['file']}"
    text = file.read_text()
    if text.count(entry["find"]) != 1:
        return f"the text stands {text.count(entry['find'])} times in {entry['file']}, not once"
    file.write_text(text.replace(entry["find"], entry["replace"]))
    return None


def meet(todo: list[dict], key: Callable[[dict], str], judges: dict[str, Judge]) -> int:
    """Breaks each in turn, prints its fate; the number that nothing noticed.

    The copy of one that was not noticed stays.
    """

    def one(numbered: tuple[int, dict]) -> tuple[dict, str | None, str]:
        number, entry = numbered
        folder = ROOT / WORK / f"{os.getpid()}_{number:03d}"
        complaint, seen = broken(entry, folder, PARTS[key(entry)]), ""
        if complaint is None:
            complaint, seen = judges[key(entry)](entry, folder)
        if complaint is None:
            shutil.rmtree(folder, ignore_errors=True)
        return entry, complaint, seen

    started, green = time.monotonic(), 0
    with ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        for entry, complaint, seen in pool.map(one, enumerate(todo)):
            green += complaint is not None
            head = "NOT CAUGHT" if complaint else "caught"
            block = Path(entry["file"]).stem
            print(f"{head:10s} {block}: {entry['name']}: {complaint or seen}", flush=True)
    files = len({e["file"] for e in todo})
    caught = f"{len(todo) - green} of {len(todo)} breakages caught"
    print(f"breakage: {caught}, {files} files, {time.monotonic() - started:.0f} s")
    return green


# --- tests of cocotb ---------------------------------------------------------------------------


def nodes(entry: dict, sim: str) -> list[str]:
    """The pytest ids of an entry's tests on a simulator; the list names Icarus."""
    return [re.sub(r"icarus\]$", f"{sim}]", test) for test in entry.get("test", "").split()]


def pytest(tests: list[str], sim: str, build: Path, rtl: Path | None = None, workers: int = 0):
    env = dict(os.environ, MMCS_BUILD=str(build), MMCS_RANDOM_OPS="2000")
    env |= {"MMCS_RTL": str(rtl)} if rtl else {}
    many = ["-n", str(workers), "--dist", "loadgroup"] if workers else ["-x"]
    limit = ["prlimit", f"--cpu={CPU_S}"] if rtl else []
    command = [*limit, sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--sim", sim]
    return subprocess.run(
        [*command, *many, *tests], cwd=ROOT, env=env, text=True, capture_output=True, check=False,
        timeout=WALL_S,
    )  # fmt: skip


def verdict(done: subprocess.CompletedProcess) -> str | None:
    """None if a test turned red by what it saw, else what happened instead."""
    out = done.stdout + done.stderr
    if "does not build" in out:
        return "the broken project does not build"
    if re.search(r"\b[1-9]\d* failed\b", out):
        return None
    if done.returncode == 0:
        return "the test stays green"
    return "the test did not run: " + (out.strip().splitlines() or ["no output"])[-1]


def cocotb(sim: str) -> Judge:
    """Runs the named tests on the broken copy; one that computes for ever is noticed too."""

    def look(entry: dict, folder: Path) -> tuple[str | None, str]:
        try:
            complaint = verdict(pytest(nodes(entry, sim), sim, folder / "build", folder / "rtl"))
        except subprocess.TimeoutExpired:
            complaint = f"not done after {WALL_S} s"
        return complaint, entry["test"].partition("::")[2]

    return look


# --- tests of the driver -----------------------------------------------------------------------


def driver(entry: dict, folder: Path) -> tuple[str | None, str]:
    """Compiles the broken driver with a test program of firmware/tests, and runs one test of it."""
    program, test = entry["unit"].split()
    mc, tests = folder / "firmware" / "mc", folder / "firmware" / "tests"
    command = ["cc", "-std=c11", "-O0", "-w", "-o", folder / "program", *sorted(mc.glob("*.c"))]
    command += [tests / "mock.c", tests / f"{program}.c"]
    command += [f"-I{folder / 'firmware' / part}" for part in ("include", "mc", "tests")]
    if subprocess.run(command, check=False, capture_output=True).returncode:
        return "the broken driver does not compile", ""
    listed = subprocess.run([folder / "program"], capture_output=True, text=True, check=True).stdout
    if test not in listed.split():
        return f"{program} has no {test}", ""
    run = ["prlimit", "--cpu=60", folder / "program", test]
    red = subprocess.run(run, check=False, capture_output=True, timeout=WALL_S).returncode
    return (None if red else "the test stays green"), entry["unit"]


# --- tests of programs beside a served machine -----------------------------------------------


def served(entry: dict, folder: Path) -> tuple[str | None, str]:
    """Runs the named test in the copy, which builds an engine of its own."""
    env = os.environ | {"PYTHONPATH": str(folder), "MMCS_FAMILY": "all"}
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", entry["served"]]
    done = subprocess.run(
        command, cwd=folder, env=env, text=True, capture_output=True, check=False, timeout=WALL_S
    )
    return verdict(done), entry["served"].partition("::")[2]


# --- proofs ------------------------------------------------------------------------------------


def proof(entry: dict, folder: Path) -> tuple[str | None, str]:
    """Complaint (None: the proof turned red as it must), and what turned red."""
    from tools import formal

    about = entry["proof"]
    file = ROOT / "formal" / f"{about['group']}.sby"
    result = formal.run(file, about.get("task", "prove"), folder)
    wanted = about.get("property")
    if result.verdict == "FAIL" and (not wanted or wanted in result.failed):
        return None, "counter-example to " + ", ".join(result.failed)
    if result.verdict == "FAIL":
        return f"{', '.join(result.failed) or 'something'} fails, not {wanted}", ""
    if result.verdict == "UNKNOWN" and about.get("induction"):
        return None, "no longer inductive"
    return f"the proof says {result.verdict} {result.note}".strip(), ""


# --- the doors ---------------------------------------------------------------------------------


def run_tests(args: argparse.Namespace, todo: list[dict]) -> int:
    if args.sample:
        todo = random.Random(args.seed).sample(todo, min(args.sample, len(todo)))
        print(f"breakage: seed {args.seed}")
    tests = sorted({t for e in todo for t in nodes(e, args.sim)})
    if tests:
        whole = pytest(tests, args.sim, ROOT / WORK / "whole", workers=os.cpu_count() or 1)
        if whole.returncode:
            print(whole.stdout[-3000:] + whole.stderr, file=sys.stderr)
            print("breakage: the tests must pass on the RTL as it is, and do not", file=sys.stderr)
            return 1
        print(f"breakage: {len(tests)} tests pass on the RTL as it is", flush=True)
    judges = {"test": cocotb(args.sim), "unit": driver, "served": served}
    return meet(todo, lambda e: next(kind for kind in judges if kind in e), judges)


def main() -> int:
    if sys.argv[1:2] == ["mutants"] or sys.argv[1:2] == ["driver-mutants"]:
        from tools.breakage import mutate, mutate_firmware

        which = {"mutants": mutate, "driver-mutants": mutate_firmware}[sys.argv.pop(1)]
        return which.main()
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=["tests", "proofs", "mutants", "driver-mutants"])
    parser.add_argument("--only", default="", metavar="TEXT")
    parser.add_argument("--sim", default="icarus", choices=["icarus", "verilator"])
    parser.add_argument("--sample", type=int, default=0, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    todo = entries(args.what, args.only)
    if not todo:
        print(f"breakage: no breakage is called {args.only!r}; see {LIST.name}", file=sys.stderr)
        return 2
    if args.what == "proofs":
        from tools import formal

        if missing := [tool for tool in formal.NEEDED if not shutil.which(tool)]:
            print(f"breakage: {missing[0]} is missing; `make formal` installs it", file=sys.stderr)
            return 2
        return int(meet(todo, lambda _: "proof", {"proof": proof}) > 0)
    return int(run_tests(args, todo) > 0)


if __name__ == "__main__":
    raise SystemExit(main())
