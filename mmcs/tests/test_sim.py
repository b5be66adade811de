# SPDX-License-Identifier: Apache-2.0
"""The wrapper of the simulator library: what a Python program can do with the machine by hand."""

import pytest

from mmcs.engine import hosts
from mmcs.errors import RunError
from mmcs.mcdef import declarations
from mmcs.runs.machine import machine
from mmcs.scenario.load import load


@pytest.fixture
def setup():
    return load("lab500")


@pytest.fixture
def sim(setup):
    with machine(setup) as made:
        yield made


def test_build_says_what_it_is(sim):
    assert sim.build() == {"cards": 1, "clk_hz": 8_000_000, "skip": 1, "trace": 0}
    assert (sim.time, sim.clock) == (0.0, 0)


def test_refusals_are_one_line(setup, sim, tmp_path):
    with pytest.raises(RunError, match="the trace file cannot be made"):
        sim.trace(tmp_path / "x.fst")  # the speed build has no tracing
    with pytest.raises(RunError, match="the engine refuses a motion of axis 7"):
        sim.add_segment(axis=7, kind="step", t0=0.0, to=1.0)
    with pytest.raises(RunError, match="the simulator library does not load"):
        machine(setup, library=tmp_path / "none.so")


def test_declarations_drop_what_cffi_cannot_read():
    text = "/* c */\n#ifndef A\n#define A\n#define N 0x10\n#include <x.h>\nint f(void);\n#endif\n"
    assert declarations(text).split("\n")[0] == "#define N 0x10"
    assert "#include" not in declarations(text) and "int f(void);" in declarations(text)


def test_a_host_whose_processor_is_not_installed(monkeypatch):
    monkeypatch.setattr(hosts.shutil, "which", lambda name: name)
    monkeypatch.setattr(hosts.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(RunError, match="--host m68020 needs .* core: make firmware"):
        hosts.config("m68020")
