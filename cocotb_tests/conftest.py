# SPDX-License-Identifier: Apache-2.0
"""pytest collects every cocotb_*.py here: one item for each test x variant x simulator.

A module says `TOPLEVEL` (one name, or one for each variant), and if it likes `PARAMETERS` (one
dictionary) or `VARIANTS` (name: dictionary) and `SOURCES` (further files beside it), and by variant
what runs behind `DPI`. The simulation of a module runs once for each variant and simulator with all
selected tests; the items read their result.
"""

import importlib.util
import os
from pathlib import Path

import pytest

from cocotb_tests.lib import req as marks
from cocotb_tests.lib import runner
from tools.sources import in_tree

ROOT = Path(__file__).resolve().parent.parent


def pytest_addoption(parser):
    group = parser.getgroup("mmcs")
    group.addoption(
        "--sim",
        choices=[*runner.SIMULATORS, "both"],
        default=os.environ.get("MMCS_SIM", "verilator"),
        help="simulator of the cocotb tests (also MMCS_SIM); default verilator",
    )
    group.addoption(
        "--seed",
        type=int,
        default=int(os.environ.get("MMCS_SEED", runner.DEFAULT_SEED)),
        help="seed of the random tests (also MMCS_SEED)",
    )
    group.addoption(
        "--waves", action="store_true", help="keep the waves of each simulation; tells where"
    )
    group.addoption("--rtl-coverage", action="store_true", help="collect coverage (Verilator)")


def pytest_configure(config):
    if importlib.util.find_spec("cocotbext.vme") is None:
        pytest.exit("the bus models of bfm/ are not installed: run `make .venv/.test`", 4)
    config.addinivalue_line("markers", "slow: left out of make test-fast")
    config.addinivalue_line("markers", "xdist_group(name): tests of one simulation")


def pytest_report_header(config):
    return f"mmcs: --sim {config.getoption('--sim')} --seed {config.getoption('--seed')}"


def pytest_terminal_summary(terminalreporter):
    for file in getattr(terminalreporter._session, "mmcs_waves", ()):
        terminalreporter.write_line(f"waves: {file}")


def pytest_collect_file(file_path, parent):
    if file_path.suffix == ".py" and file_path.name.startswith("cocotb_"):
        return CocotbFile.from_parent(parent, path=file_path)
    return None


class CocotbFile(pytest.File):
    def collect(self):
        from cocotb._decorators import TestGenerator

        name = ".".join(self.path.relative_to(ROOT).with_suffix("").parts)
        module = importlib.import_module(name)
        variants = getattr(module, "VARIANTS", None) or {"": getattr(module, "PARAMETERS", {})}
        chosen = self.config.getoption("--sim")
        sims = runner.SIMULATORS if chosen == "both" else (chosen,)
        named = ((self.path.parent / s).resolve() for s in getattr(module, "SOURCES", ()))
        extra = tuple(in_tree(file) for file in named)
        generators = [o for o in vars(module).values() if isinstance(o, TestGenerator)]
        for variant, parameters in variants.items():
            dpi = getattr(module, "DPI", {}).get(variant, ())
            for sim in sims:
                if dpi and sim == "icarus":  # has no DPI-C: docs/use/dpi.md
                    continue
                job = runner.Job(
                    name,
                    runner.toplevel(module, variant),
                    sim,
                    tuple(sorted(parameters.items())),
                    extra,
                    self.config.getoption("--rtl-coverage") and sim == "verilator",
                    dpi=dpi,
                    environment=(("MMCS_VARIANT", variant),),
                    waves=self.config.getoption("--waves"),
                )
                label = f"{variant}-{sim}" if variant else sim
                for generator in generators:
                    only = getattr(generator.func, marks.VARIANTS, None)
                    if only and variant not in only:
                        continue
                    for test in generator.generate_tests():
                        yield CocotbItem.from_parent(
                            self, name=f"{test.name}[{label}]", job=job, test=test
                        )


class CocotbItem(pytest.Item):
    def __init__(self, *, job, test, **kwargs):
        super().__init__(**kwargs)
        self.job, self.test_name, self.doc = job, test.name, test.doc
        ids = getattr(test.func, marks.REQ, ())
        if ids:
            self.add_marker(pytest.mark.req(*ids))
        if getattr(test.func, marks.SLOW, False):
            self.add_marker(pytest.mark.slow)
        variant = self.name.rpartition("[")[2].rstrip("]")
        self.add_marker(pytest.mark.xdist_group(f"{job.module}-{variant}"))

    def runtest(self):
        done = self.session.__dict__.setdefault("mmcs_outcomes", {})
        if self.job not in done:
            tests = [
                i.test_name
                for i in self.session.items
                if isinstance(i, CocotbItem) and i.job == self.job
            ]
            worker = os.environ.get("PYTEST_XDIST_WORKER", "main")
            done[self.job] = runner.run(self.job, tests, self.config.getoption("--seed"), worker)
        outcome = done[self.job][self.test_name]
        if self.job.waves and outcome.log:
            self.session.__dict__.setdefault("mmcs_waves", {})[
                outcome.log.with_name(runner.WAVES[self.job.sim])
            ] = None
        if not outcome.passed:
            raise CocotbFailure(outcome, self.config.getoption("--seed"))

    def repr_failure(self, excinfo):
        if isinstance(excinfo.value, CocotbFailure):
            outcome, seed = excinfo.value.args
            log = f"\nlog: {outcome.log}" if outcome.log else ""
            return f"{outcome.text}\n{self.doc or ''}\nseed {seed}{log}"
        return super().repr_failure(excinfo)

    def reportinfo(self):
        return self.path, None, self.name


class CocotbFailure(Exception):
    """A cocotb test failed; the simulation's own words are the report."""
