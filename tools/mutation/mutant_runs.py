# SPDX-License-Identifier: Apache-2.0
"""Runs the cocotb tests of a test top on its mutants, many in one start of the simulator."""

import importlib
import os
import re
import resource
import shutil
import sys
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

from cocotb._decorators import TestGenerator

from cocotb_tests.lib import req as marks
from cocotb_tests.lib import runner
from tools.mutation.mutants import ROOT, TOPS, WORK, Mutant, equivalent

WALL_S = 6 * 3600  # a guard against what hangs without computing; busy machines are slow
LEAST_S = 15  # of processor time that a mutant gets at least
PROOFS_S = {False: 2, True: 30}  # for a proof of a module by itself, and with all below it
BATCH = 10  # mutants that one simulator process runs


@dataclass
class Group:
    """Test modules that share a build: one simulation runs all their tests, the quickest first."""

    job: object  # of the runner; its module does not matter
    tests: list[tuple[str, str]]  # module, attribute
    limit: float = WALL_S  # processor time, s
    order: list[str] = field(default_factory=list)  # names of tests
    count: int = 0  # of tests that end, each set of parameters for itself


def groups(top: str) -> list[Group]:
    """The simulations of a top's mutants: one for each set of parameters, and module on top."""

    def find(name: str) -> tuple:
        name, _, variant = name.partition(":")
        module = importlib.import_module(f"cocotb_tests.{name}")
        own = module.VARIANTS[variant] if variant else getattr(module, "PARAMETERS", {})
        return module, variant, tuple(sorted(own.items()))

    found: dict[tuple, Group] = {}
    for entry in TOPS[top][0]:
        name, _, other = entry.partition("=")
        module, variant, parameters = find(name)
        parameters = find(other)[2] if other else parameters
        top = runner.toplevel(module, variant)
        base = Path(module.__file__).parent
        extra = tuple((base / s).resolve() for s in getattr(module, "SOURCES", ()))
        job = runner.Job("", top, "verilator", parameters, extra)
        group = found.setdefault((top, parameters), Group(job, []))
        for attribute, it in vars(module).items():
            if not isinstance(it, TestGenerator) or it.module != module.__name__:
                continue
            only = getattr(it.func, marks.VARIANTS, None)
            slow = getattr(it.func, marks.SLOW, False)
            if (not only or variant in only) and not slow:
                group.tests.append((module.__name__, attribute))
    return list(found.values())


def built(top: str, group: Group):
    """The runner of a group, built from the tree that holds the mutants."""
    os.environ["MMCS_RTL"] = str(ROOT / WORK / top / "tree" / "rtl")
    os.environ["MMCS_BUILD"] = str(ROOT / WORK / "sim")
    store = runner.build_root() / "objects"
    if not store.is_dir() and (ROOT / "build" / "cocotb" / "objects").is_dir():
        shutil.copytree(ROOT / "build" / "cocotb" / "objects", store, dirs_exist_ok=True)
    runner.CHECKED_TOPS = ()  # the bus checkers look into modules that are wrapped here
    return runner.build(group.job)


# What the simulator's Python imports in place of the tests. It imports these once, then a copy of
# the process goes on for each mutant, with its own folder, log and limit of processor time.
SERVER = """
import ctypes, os, resource, signal, sys
from importlib import import_module
import cocotb.simulator
{tests}
libc = ctypes.CDLL(None)
def end():
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)
for number in {numbers}:
    process = os.fork()
    if not process:
        os.mkdir(str(number))
        os.chdir(str(number))
        log = os.open("sim.log", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(log, 1)
        os.dup2(log, 2)
        with open("mutant.txt", "w") as file:
            print(number, file=file)
        resource.setrlimit(resource.RLIMIT_CPU, ({limit}, {limit}))
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 26, 1 << 26))
        signal.alarm({wall})
        cocotb.simulator.stop_simulator = end
        # However it ends, the simulator would wait for threads that a copy does not have: the last
        # that is registered comes first.
        for call in (libc._exit, libc.fflush):
            getattr(libc, "__cxa_atexit")(call, None, None)
        break
    _, status, used = os.wait4(process, 0)
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGALRM:
        os._exit(1)
    with open(f"{{number}}/seconds", "w") as file:
        print(used.ru_utime + used.ru_stime, file=file)
else:
    if {numbers}:
        os._exit(0)
"""


def write_tests(folder: Path, group: Group, numbers: list[int]) -> None:
    """A test module that holds the tests of several, in the order in which they shall run."""
    order = group.order or [name for _, name in group.tests]
    named = sorted(group.tests, key=lambda t: order.index(t[1]))
    tests = "\n".join(
        f"t{n} = import_module({module!r}).{attribute}"
        for n, (module, attribute) in enumerate(named)
    )
    text = SERVER.format(tests=tests, numbers=numbers, limit=round(group.limit), wall=WALL_S)
    (folder / "mutant_tests.py").write_text(text)


def simulate(top: str, group: Group, numbers: list[int]) -> Path:
    """Runs a group's tests on some mutants, or on none; the folder of it."""
    sim, job = built(top, group), group.job
    folder = sim.build_dir / f"mutants-{os.getpid()}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    write_tests(folder, group, numbers)
    runner.HANG_S = BATCH * WALL_S
    sys.path.insert(0, str(folder))  # the runner hands it on
    try:
        sim.test(
            test_module="mutant_tests",
            hdl_toplevel=job.toplevel,
            hdl_toplevel_lang="verilog",
            build_dir=sim.build_dir,
            test_dir=folder,
            results_xml=str(folder / "results.xml"),
            seed=runner.DEFAULT_SEED,
            timescale=runner.TIMESCALE,
            parameters=dict(job.parameters),
            log_file=folder / "sim.log",
            extra_env={"MMCS_SIM": job.sim, "MMCS_PARAMETERS": repr(dict(job.parameters))},
        )
    except (RuntimeError, SystemExit):
        pass
    finally:
        sys.path.remove(str(folder))
    return folder


def verdicts(log: Path) -> dict[str, bool]:
    """What the log says of the tests that ended: name without parameters, whether it passed."""
    text = log.read_text(errors="replace") if log.is_file() else ""
    ends = re.findall(r"cocotb\.regression +cocotb_tests\.(\S+) (passed|failed)", text)
    return {name: how == "passed" for name, how in ends}


def used() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def baseline(top: str) -> list[Group]:
    """Groups of a top, built, their tests in order, what a mutant may take; fails if a test does.

    The unbroken model runs here: a failure is one of the tests or of this tool.
    """
    settings()
    made = groups(top)
    for group in made:
        built(top, group)
        before = used()
        folder = simulate(top, group, [])
        ended = verdicts(folder / "sim.log")
        bad = [name for name, good in ended.items() if not good]
        names = {re.sub(r"/.*", "", name).rpartition(".")[2] for name in ended}
        missing = [t for _, t in group.tests if t not in names]
        if bad or missing:
            raise RuntimeError(f"{top} without a mutant fails {(bad or missing)[0]}; see {folder}")
        seconds: dict[str, float] = {}
        for case in ET.parse(folder / "results.xml").iter("testcase"):
            name = re.sub(r"/.*", "", case.get("name"))
            seconds[name] = seconds.get(name, 0) + float(case.get("time", 0))
        group.order, group.count = sorted(seconds, key=seconds.get), len(ended)
        group.limit = max(LEAST_S, 3 * (used() - before))
    return made


def settings() -> None:
    os.environ["MMCS_RANDOM_OPS"] = "2000"
    os.environ["COCOTB_MAX_FAILURES"] = "1"


def fates(mutants: list[Mutant], made: list[Group]) -> list[Mutant]:
    """A top's tests on some mutants, and proofs for those that survive: fate, what noticed it,
    seconds of processor time."""
    settings()
    for group in made:
        left = [m for m in mutants if not m.by]
        folder = simulate(left[0].top, group, [m.number for m in left]) if left else None
        for m in left:
            place = folder / str(m.number)
            if not (place / "seconds").is_file():
                raise RuntimeError(f"{m.top}: mutant {m.number} did not run; see {folder}")
            m.seconds = round(m.seconds + float((place / "seconds").read_text()), 2)
            ended = verdicts(place / "sim.log")
            failed = [name for name, good in ended.items() if not good]
            if failed or len(ended) < group.count:
                m.by = failed[0] if failed else f"(end) {last_words(place / 'sim.log')}"
    for m in mutants:
        same = not m.by and any(equivalent(m, s, whole) for whole, s in PROOFS_S.items())
        m.fate = "killed" if m.by else "equivalent" if same else "survived"
    return mutants


def last_words(log: Path) -> str:
    """Why a simulation ended without results: the design's complaint, else the time limit."""
    text = log.read_text(errors="replace") if log.is_file() else "no log"
    complaint = re.findall(r"%(?:Error|Fatal)[^\n]*", text)
    return complaint[0][-90:] if complaint else "it goes on for ever"
