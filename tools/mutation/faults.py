# SPDX-License-Identifier: Apache-2.0
"""Seeds the faults of faults.toml, each in a copy of the project, and wants each one noticed.

    faults.py tests [--only TEXT]     a test of each requirement must fail: part of make mutation
    faults.py proofs [--only TEXT]    a proof of each group must fail: make formal SEEDED=1

The tests must pass on the project as it is. SHARE=0 to 9 runs a tenth of the faults.
"""

import os
import re
import shutil
import sys
import time
import tomllib
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tools import formal
from tools.compiled import ROOT, ran
from tools.share import shared

LIST = ROOT / "tools" / "mutation" / "faults.toml"
WORK = Path("build") / "faults"  # relative: the provers see the folder they are started in
CPU_S = 900  # of processor time for a process of a broken design: it hangs, and that is noticed
WALL_S = 4 * 3600  # a guard against what hangs without computing: that says nothing
COPIED = ("rtl", "formal", "firmware", "mmcs", "tools", "sim", "web", "mmcs.core", "conftest.py",
          "pyproject.toml")  # fmt: skip
NO_BUILD = "the project with the fault does not build"


def read() -> tuple[list[dict], dict[str, str]]:
    """The faults, and the requirements that have none, with the reason."""
    listed = tomllib.loads(LIST.read_text())
    without = listed.pop("without")
    return [{"file": f, "name": n} | e for f, es in listed.items() for n, e in es.items()], without


def chosen(key: str, only: str = "") -> list[dict]:
    """Faults for a test or a proof whose name, file, requirement or proof holds `only`."""
    mine = [e for e in read()[0] if key in e]
    said = [f"{e['name']}\n{e['file']}\n{e.get('req')}\n{e.get('proof')}" for e in mine]
    return [e for e, text in zip(mine, said, strict=True) if only in text]


def seed(fault: dict, folder: Path) -> str | None:
    """Copies the project and replaces the text, or the whole file's; the complaint if it does not
    stand there once."""
    shutil.rmtree(folder, ignore_errors=True)
    for part in COPIED:
        (folder / part).parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if (ROOT / part).is_dir() else shutil.copy
        copy(ROOT / part, folder / part)
    (folder / "FUSESOC_IGNORE").touch()  # its mmcs.core is not another core
    file = folder / fault["file"]
    if "text" in fault:
        file.write_text(fault["text"])
        return None
    text = file.read_text() if file.is_file() else ""
    if text.count(fault["find"]) != 1:
        return f"the text stands {text.count(fault['find'])} times in {fault['file']}, not once"
    file.write_text(text.replace(fault["find"], fault["replace"]))
    return None


def pytest(tests: list[str], folder: Path, *options: str, cpu_s: int = CPU_S):
    """Tests of cocotb run on the RTL of the folder, others in it."""
    env = os.environ | {"MMCS_BUILD": str(folder / "build"), "MMCS_RTL": str(folder / "rtl"),
                        "MMCS_RANDOM_OPS": "2000", "PYTHONPATH": str(folder)}  # fmt: skip
    env.pop("SHARE", None)
    cocotb = tests[0].startswith("cocotb_tests")
    if not cocotb:
        del env["MMCS_BUILD"]
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *options, *tests]
    command += ["--sim", "icarus"] if cocotb else []
    where = ROOT if cocotb else folder
    return ran("prlimit", f"--cpu={cpu_s}", *command, cwd=where, env=env, timeout=WALL_S)


def by_test(fault: dict, folder: Path) -> str | None:
    """None if the test failed by what it saw, else what happened instead."""
    done = pytest([fault["test"]], folder, "-x", cpu_s=fault.get("cpu_s", CPU_S))
    out = done.stdout + done.stderr
    if "does not build" in out or "CompileError" in out:
        return NO_BUILD
    if re.search(r"\b[1-9]\d* failed\b", out):
        return None
    if done.returncode == 0:
        return "the test passes"
    return "the test did not run: " + (out.strip().splitlines() or ["no output"])[-1]


def by_proof(fault: dict, folder: Path) -> str | None:
    """None if the proof failed as it must, else what happened instead."""
    about = fault["proof"]
    file = ROOT / "formal" / f"{about['group']}.sby"
    result = formal.run(file, about.get("task", "prove"), folder)
    wanted = about.get("property")
    if result.verdict == "FAIL" and (not wanted or wanted in result.failed):
        return None
    if result.verdict == "FAIL":
        return f"{', '.join(result.failed) or 'something'} fails, not {wanted}"
    if result.verdict == "UNKNOWN" and about.get("induction"):
        return None
    return f"the proof says {result.verdict} {result.note}".strip()


def run(faults: list[dict], judge) -> int:
    """Seeds each in turn and prints its fate; how many nothing noticed, whose copies stay."""

    def one(number: int) -> str | None:
        folder = ROOT / WORK / f"{os.getpid()}_{number:03d}"
        complaint = seed(faults[number], folder) or judge(faults[number], folder)
        if complaint is None:
            shutil.rmtree(folder, ignore_errors=True)
        return complaint

    started, missed = time.monotonic(), 0
    with ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        for fault, complaint in zip(faults, pool.map(one, range(len(faults))), strict=True):
            missed += complaint is not None
            what = fault.get("req") or fault["proof"]["group"]
            fate = f"NOT NOTICED: {complaint}" if complaint else "noticed"
            print(f"{what:8s} {fault['file']}: {fault['name']}: {fate}", flush=True)
    noticed = f"{len(faults) - missed} of {len(faults)} faults noticed"
    print(f"faults: {noticed}, {time.monotonic() - started:.0f} s")
    return missed


def main() -> int:
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["tests", "proofs"])
    parser.add_argument("--only", default="", metavar="TEXT")
    args = parser.parse_args()
    faults = chosen(args.what.removesuffix("s"), args.only)
    if not faults:
        print(f"faults: no fault is called {args.only!r}; see {LIST.name}", file=sys.stderr)
        return 0
    faults = faults if args.only else shared(faults)
    if args.what == "proofs":
        if missing := [tool for tool in formal.NEEDED if not shutil.which(tool)]:
            print(f"faults: {missing[0]} is missing; `make formal` installs it", file=sys.stderr)
            return 2
        return int(run(faults, by_proof) > 0)
    for rtl in (True, False):
        tests = sorted({f["test"] for f in faults if f["test"].startswith("cocotb") == rtl})
        if not tests:
            continue
        workers = ("-n", os.environ.get("JOBS", "2"), "--dist", "loadgroup")
        done = pytest(tests, ROOT, *workers)
        if done.returncode:
            print(done.stdout[-3000:] + done.stderr, file=sys.stderr)
            print("faults: the tests must pass on the project as it is", file=sys.stderr)
            return 1
    return int(run(faults, by_test) > 0)


if __name__ == "__main__":
    raise SystemExit(main())
