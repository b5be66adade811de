# SPDX-License-Identifier: Apache-2.0
"""The one test runner: builds a top once per simulator and parameters, runs a module on it.

A build lives in build/cocotb/<top>-<key>, the key hashing every source, parameter and option, so
that a second run builds nothing; a lock keeps parallel workers from building the same thing twice.
"""

import hashlib
import os
import re
import resource
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path

from cocotb_tools.runner import Icarus, Verilator

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tools"))
from compiled import locked, written  # noqa: E402
from sources import reached, sources  # noqa: E402

from mmcs import ensure_library  # noqa: E402

SIMULATORS = ("verilator", "icarus")
MISSING = {
    "verilator": "verilator is missing; install it with: make sim",
    "icarus": "iverilog is missing; install it with: sudo apt-get install iverilog",
}
DEFAULT_SEED = 1989
RESTARTS = 8
# Processor time: a guard against a simulator that never ends, not a measure.
HANG_S = 1800
TIMESCALE = ("1ns", "1ps")
# Nearly all the time of a build is g++; the simulations are short, so -O1 ends soonest.
OPTIMISE = ["OPT_FAST=-O1", "OPT_SLOW=-O0", "OPT_GLOBAL=-O1"]
# Counters, or sixteen cards, make the code several times as large and the builds as long: -O0
# ends soonest there.
LARGE = ["OPT_FAST=-O0", "OPT_SLOW=-O0", "OPT_GLOBAL=-O1"]
SHARED = ("verilated.o", "verilated_vpi.o", "verilated_threads.o", "verilated_dpi.o")
# Only with these tops do the bus checkers find what they are bound to.
CHECKED_TOPS = ("mmcs", "mmcs_tb")
TESTBENCH = ROOT / "sim/dpi/mmcs_tb.sv"  # with the engine behind it
# All nets of a design would make twice the code, of a netlist ten times.
PORTS = '`verilator_config\npublic_flat_rw -module "{top}" -var "*"\n'
# Of a long run behind DPI, the machine's wires.
WIRES = PORTS.format(top="mmcs") + (
    'public_flat_rw -module "mmcs_tb" -var "done"\n'
    'public_flat_rd -module "mmcs_cards" -var "card_d_oe"\n'
)
# Verilator's FST wants libraries that not everybody has.
WAVES = {"verilator": "wave.vcd", "icarus": "wave.fst"}
DUMP = (
    'module wave_dump;\ninitial begin $dumpfile("wave.fst"); $dumpvars(0, {top}); end\nendmodule\n'
)
VISIBLE = ROOT / "cocotb_tests/lib/visible.vlt"


class BuildError(Exception):
    """The design does not compile; the text holds the compiler's words."""


@dataclass(frozen=True)
class Job:
    """One simulation: a test module on one top with one set of parameters."""

    module: str
    toplevel: str
    sim: str
    parameters: tuple[tuple[str, object], ...] = ()
    extra: tuple[Path, ...] = ()
    coverage: bool = False
    netlist: tuple[Path, ...] = ()  # in place of the RTL: what was synthesised, and its cells
    includes: tuple[Path, ...] = ()  # further folders of include files
    dpi: tuple[str, ...] = ()  # the scenario behind sim/dpi/mmcs_tb.sv, as words for load()
    environment: tuple[tuple[str, str], ...] = ()
    waves: bool = False  # leaves WAVES of the simulator beside the log


@dataclass
class Outcome:
    passed: bool
    text: str = ""
    seconds: float = 0.0
    log: Path | None = field(default=None)


def build_root() -> Path:
    return Path(os.environ.get("MMCS_BUILD", ROOT / "build")).resolve() / "cocotb"


def toplevel(module, variant: str = "") -> str:
    """The top of a test module: one for all its variants, or each its own."""
    return module.TOPLEVEL if isinstance(module.TOPLEVEL, str) else module.TOPLEVEL[variant]


def _limit_s() -> int:
    """HANG_S, or what is left to this process, which may have a lower limit (`make mutation`)."""
    most = resource.getrlimit(resource.RLIMIT_CPU)[1]
    return HANG_S if most == resource.RLIM_INFINITY else min(HANG_S, most)


class _Runner:
    """What both simulators share: output to a file, an end to hanging."""

    def _execute_cmds(self, cmds, cwd, stdout=None):
        for place, cmd in enumerate(cmds):
            if place:
                self._between()
            done = subprocess.run(
                ["prlimit", f"--cpu={_limit_s()}", *cmd],
                cwd=cwd,
                env=self.env,
                check=False,
                stdout=stdout,
                stderr=subprocess.STDOUT,
            )
            if done.returncode:
                raise RuntimeError(f"{Path(cmd[0]).name} ended with {done.returncode}")

    def _between(self):
        """What is to be done after the first command, before the next."""


class _Icarus(_Runner, Icarus):
    pass


class _Verilator(_Runner, Verilator):
    optimise, coverage = OPTIMISE, False

    def _between(self):
        _lend_objects(Path(self.build_dir), self.coverage)

    def _build_command(self):
        verilate, make = super()._build_command()
        verilate.remove("--public-flat-rw")
        return [verilate, [*make, *self.optimise]]


def _design(job: Job) -> tuple[list[Path], list[Path]]:
    """Sources and include folders of a job."""
    ports = written(f"{job.toplevel}_ports.vlt", PORTS.format(top=job.toplevel))
    if job.netlist:
        return [ports, *job.extra, *job.netlist], [job.netlist[-1].parent, *job.includes]
    models = {file.name for file in job.extra}  # in the place of files of rtl/ of the same name
    rtl = [file for file in sources("rtl") if file.name not in models]
    testbench = [TESTBENCH] if job.dpi and not job.extra else []
    try:
        files = reached([job.toplevel], [*rtl, *job.extra, *testbench])
    except KeyError:
        raise BuildError(f"no source declares module {job.toplevel}") from None
    if job.toplevel in CHECKED_TOPS and job.sim == "verilator":
        files += [f for f in sources("checkers") if f.is_file()]
    folder = next(p for p in rtl[0].parents if p.name == "rtl")
    if job.sim == "verilator":
        waivers = folder / "verilator.vlt"  # a mutant's own
        ours = [written(f"{job.toplevel}_wires.vlt", WIRES)] if job.dpi else [ports, VISIBLE]
        files = [*ours, *([waivers] if waivers.is_file() else []), *files]
    elif job.waves:
        files += [written(f"{job.toplevel}_waves.sv", DUMP.format(top=job.toplevel))]
    return files, [folder, *job.includes]


def _arguments(job: Job) -> list[str]:
    if job.sim == "icarus":
        return ["-Wall", "-Wno-timescale", *(["-s", "wave_dump"] if job.waves else [])]
    # One file a design: Verilator's headers, which take as long as the design, are read once.
    usual = ["--output-split", "0", *(["--trace-structs"] if _traced(job) else [])]
    if job.dpi:  # its own clock, pins that move with it, no timescale but the testbench's
        args = ["--assert", "--timing", "-DMMCS_NO_BUS_TIMES", "-Wno-TIMESCALEMOD", *usual]
        return [*args, "-LDFLAGS", str(ensure_library(1, "dpi"))]
    if job.netlist:  # written by a program, and cells written by others
        args = ["-Wno-fatal", "-Wno-lint", "-Wno-MODDUP", "-Wno-SPECIFYIGN"]
        return ["--no-timing", *args, *usual]
    args = ["--assert", "--no-timing", *usual]
    # not --coverage: its expression coverage is not asked for, and not sound in this version
    return [*args, "--coverage-line", "--coverage-toggle"] if job.coverage else args


def _traced(job: Job) -> bool:
    return job.waves and job.sim == "verilator"


def _lend_objects(folder: Path, coverage: bool) -> None:
    """Verilator's run-time library is the same in every build: compile it once.

    Not so the main program, verilator.o: it knows the size of the design's class. To make, they
    must look newer than the Makefile that Verilator has just written.
    """
    store = build_root() / ("objects-coverage" if coverage else "objects")
    for name in SHARED:
        if (store / name).is_file():
            shutil.copyfile(store / name, folder / name)


def _first_build(job: Job):
    """Others wait for the first build by Verilator, whose run-time library takes twice its time."""
    store = build_root() / ("objects-coverage" if job.coverage else "objects")
    kept = job.sim == "icarus" or all((store / name).is_file() for name in SHARED)
    return nullcontext() if kept else locked(store.with_suffix(".lock"))


def _keep_objects(folder: Path, coverage: bool) -> None:
    store = build_root() / ("objects-coverage" if coverage else "objects")
    store.mkdir(exist_ok=True)
    for name in SHARED:
        if (folder / name).is_file() and not (store / name).is_file():
            shutil.copyfile(folder / name, store / f"{name}.{os.getpid()}")
            os.replace(store / f"{name}.{os.getpid()}", store / name)


def digest_of(files: list[Path]):
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.name.encode() + file.read_bytes())
    return digest


def build(job: Job):
    """The runner with the design built, building only what no earlier run has built."""
    if not shutil.which({"icarus": "iverilog"}.get(job.sim, job.sim)):
        raise BuildError(MISSING[job.sim])
    files, includes = _design(job)
    arguments = _arguments(job)
    files_read = [*files, *(f for folder in includes for f in sorted(folder.rglob("*.svh")))]
    digest = digest_of(files_read)
    runner = (_Verilator if job.sim == "verilator" else _Icarus)()
    runner.coverage = job.coverage
    if job.coverage or dict(job.parameters).get("NumCards") == 16:
        runner.optimise = LARGE
    digest.update(repr((job.toplevel, job.sim, job.parameters, arguments, OPTIMISE)).encode())
    digest.update(sys.version.encode() + sys.prefix.encode())
    folder = build_root() / f"{job.toplevel}-{job.sim}-{digest.hexdigest()[:12]}"
    log = folder.with_suffix(".log")
    with locked(folder.with_suffix(".lock")):
        if not (folder / "built").is_file():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            try:
                with _first_build(job):
                    runner.build(
                        sources=files,
                        includes=includes,
                        hdl_toplevel=job.toplevel,
                        parameters={} if job.netlist else dict(job.parameters),
                        build_args=arguments,
                        build_dir=folder,
                        timescale=TIMESCALE,
                        log_file=log,
                        always=True,
                        waves=_traced(job),
                    )
                    if job.sim == "verilator":
                        _keep_objects(folder, job.coverage)
                if unknown := re.search(r"parameter \w+ not found", log.read_text()):
                    raise RuntimeError(unknown[0])  # Icarus takes it for a warning
            except RuntimeError as error:
                raise BuildError(f"{job.toplevel}: {error}\n{_tail(log)}") from None
            (folder / "built").touch()
    runner.build_dir = folder
    return runner


def _tail(log: Path, lines: int = 60) -> str:
    text = log.read_text(errors="replace") if log.is_file() else ""
    return "\n".join(text.splitlines()[-lines:])


def run(job: Job, tests: list[str], seed: int, worker: str = "main") -> dict[str, Outcome]:
    """Runs the named tests of a module in one simulation; an outcome for each.

    A test that ends the simulation (an assertion of the design) fails alone: the tests after it
    run in another.
    """
    try:
        runner = build(job)
    except BuildError as error:
        return {t: Outcome(False, f"the design does not build\n{error}") for t in tests}
    outcomes, left = {}, list(tests)
    began = _processor_s()
    for attempt in range(RESTARTS):
        if attempt and _processor_s() > began + HANG_S:
            break
        found, complaint, log = _simulate(runner, job, left, seed, f"{worker}-{attempt}")
        outcomes |= found or _salvage(job, log)
        left = [t for t in left if t not in outcomes]
        if not left:
            return outcomes
        outcomes[left.pop(0)] = Outcome(False, complaint, log=log)
    why = f"given up after {RESTARTS} crashes or {HANG_S} s of processor time"
    return outcomes | {t: Outcome(False, why) for t in left}


def _processor_s() -> float:
    """Of all programs that have run here and ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _setup(job: Job, folder: Path) -> list[str]:
    """Of the engine behind sim/dpi/mmcs_tb.sv: its set-up file."""
    if not job.dpi:
        return []
    from mmcs import load, write_setup

    write_setup(load(*job.dpi), folder / "setup.bin")
    return ["+setup=setup.bin"]


def _simulate(runner, job: Job, tests: list[str], seed: int, label: str):
    """One simulation: the outcomes it left, what to say about those it did not, its log."""
    of = [job.module.rpartition(".")[2], *(value for _, value in job.environment if value), label]
    folder = _run_folder(runner.build_dir / "-".join(of))  # of one variant: its coverage stays
    log, results = folder / "sim.log", folder / "results.xml"
    names = "|".join(re.escape(t) for t in tests)
    # under pytest the runner would look at results.xml by itself and end the process
    current = os.environ.pop("PYTEST_CURRENT_TEST", None)
    note = "the test did not run"
    try:
        runner.test(
            test_module=job.module,
            hdl_toplevel=job.toplevel,
            hdl_toplevel_lang="verilog",
            build_dir=runner.build_dir,
            test_dir=folder,
            results_xml=str(results),
            test_filter=rf"^{re.escape(job.module)}\.({names})$",
            seed=seed,
            timescale=TIMESCALE,
            parameters=dict(job.parameters),
            log_file=log,
            plusargs=[f"+verilator+seed+{seed}", *_setup(job, folder)],
            test_args=["--trace-file", WAVES[job.sim]] if _traced(job) else [],
            waves=job.waves,
            extra_env={
                "MMCS_SIM": job.sim,
                "MMCS_PARAMETERS": repr(dict(job.parameters)),
                **dict(job.environment),
            },
        )
    except (RuntimeError, SystemExit) as error:
        note = f"the simulation ended early: {error}"
    finally:
        if current is not None:
            os.environ["PYTEST_CURRENT_TEST"] = current
    return _read(results, log), f"{note}\n{_tail(log, 12)}", log


def _run_folder(stem: Path) -> Path:
    """An empty folder that no other process writes to; those of ended processes go."""
    for old in stem.parent.glob(f"{stem.name}-*"):
        if not Path(f"/proc/{old.name.rpartition('-')[2]}").is_dir():
            shutil.rmtree(old, ignore_errors=True)
    folder = stem.with_name(f"{stem.name}-{os.getpid()}")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def _salvage(job: Job, log: Path) -> dict[str, Outcome]:
    """What the log says of the tests that ended before the simulation crashed."""
    text = log.read_text(errors="replace") if log.is_file() else ""
    ends = re.findall(rf"regression +{re.escape(job.module)}\.(\S+) (passed|failed)$", text, re.M)
    return {t: Outcome(how == "passed", f"failed; see {log}", log=log) for t, how in ends}


def _read(results: Path, log: Path) -> dict[str, Outcome]:
    said, out = log.read_text(errors="replace") if log.is_file() else "", {}
    try:
        tree = ET.parse(results)
    except (ET.ParseError, FileNotFoundError):
        return {}
    for case in tree.iter("testcase"):
        bad = [e for e in case if e.tag in ("failure", "error")]
        ran = said.partition(f".{case.get('name')} (")[2].partition("running ")[0]
        broken = re.findall(r"^FATAL: .*", ran, re.M) if bad else []  # of Icarus, in the log alone
        text = "\n".join([*broken, *(f"{e.get('message') or ''}\n{e.text or ''}" for e in bad)])
        out[case.get("name")] = Outcome(not bad, text.strip(), float(case.get("time", 0)), log)
    return out
