# SPDX-License-Identifier: Apache-2.0
"""The engine behind a testbench, in another simulator's schedule of the same RTL: log and bus
cycles are those of the engine's own machine, to the byte."""

import json
import os
import sys
from collections import defaultdict
from pathlib import Path

import pytest

from mmcs import ROOT, load, run_scenario, simulate
from tools import dpi
from tools.compiled import compiled, ran, written

CARDS = defaultdict(lambda: 3, lab500=1)
WHOLE = ["lab500", "puma560", "puma560_coupled"]
# pins of the machine, lines of encoders and of the bus, the host
FAULTS = ["fault_estop", "fault_cable", "fault_pc_power", "fault_sysreset", "fault_axis_switch",
          "fault_dip_swapped", "fault_encoder_glitch", "fault_encoder_cut", "fault_bus_errors",
          "fault_bus_error_write", "fault_host_stall", "fault_late_interrupt"]  # fmt: skip
HELD_LINE = """\
extends = "arm_move"
description = "A data line of the VME bus is held low for a while"
[[event]]
at = 0.02
input = "vme_d_stuck0"
value = 4
until = 0.022
[[expect]]
kind = "stats"
panics = 0
"""


# The whole shape of a scenario in a tenth of a second: its move, and its step.
BRIEF = {
    "lab500": ["duration=0.12"],
    "puma560": ["duration=0.1", "motion.0.duration=0.03", "motion.1.at=0.085"],
    "fault_estop": ["duration=0.12"],
}


def through_dpi(program: Path, words: list):
    return dpi.run(program, words, capture_output=True, text=True)


def differing(scenario, tmp_path: Path, cards: int, sets: tuple = (), program=None) -> list[str]:
    """The files of the two ways that are not the same."""
    setup = load(str(scenario), *sets)
    run_scenario(setup, tmp_path / "engine", carry_out=lambda s: simulate(s, bus=True))
    words = [word for given in sets for word in ("--set", given)]
    words = [scenario, *words, "--bus", "--out", tmp_path / "dpi"]
    done = through_dpi(program or dpi.bench(cards), words)
    found = []
    for name in ("log.csv", "bus.csv"):
        ours, theirs = (tmp_path / way / name for way in ("engine", "dpi"))
        assert theirs.is_file(), done.stderr + done.stdout
        assert len(ours.read_bytes().splitlines()) > 30
        if ours.read_bytes() != theirs.read_bytes():
            found.append(name)
    assert not (tmp_path / "dpi" / "run.mmcs").exists()  # nothing could compare a replay
    return found


@pytest.mark.req("FW-1", "API-1")
@pytest.mark.parametrize("scenario", BRIEF)
def test_log_and_bus_cycles_are_the_engines(tmp_path, scenario):
    assert differing(scenario, tmp_path, CARDS[scenario], tuple(BRIEF[scenario])) == []


@pytest.mark.slow
@pytest.mark.req("FW-1", "API-1")
@pytest.mark.parametrize("scenario", WHOLE)
def test_whole_scenarios_are_the_engines(tmp_path, scenario):
    assert differing(scenario, tmp_path, CARDS[scenario]) == []


@pytest.mark.slow
@pytest.mark.req("FW-1", "API-1")
@pytest.mark.parametrize("scenario", FAULTS)
def test_faults_are_the_engines(tmp_path, scenario):
    """Until 0.1 s after the last event: the heartbeats end 50 ms after it."""
    ends = [event.until or event.at for event in load(scenario).scenario.event]
    sets = ("expect=[]", f"duration={max(ends, default=0.1) + 0.1:g}")
    assert differing(scenario, tmp_path, 3, sets) == []


@pytest.mark.req("FW-1")
def test_the_engine_sees_each_pin_at_the_clock_of_its_change():
    """It sleeps between the changes that it asked for: none is missed, none told too early."""
    compiler = [os.environ.get("CXX", "g++"), "-std=c++17", "-O1"]
    command = [*compiler, *(f"-Isim/{d}" for d in ("dpi", "model", "abi"))]
    parts = ["tests/dpi/bench.cpp", "dpi/dpi_model.cpp", "dpi/bench.cpp", "model/pins.cpp"]
    program = compiled("dpi_bench", command, [f"sim/{part}" for part in parts])
    done = ran(program)
    assert (done.returncode, done.stdout) == (0, "")


# A phase that moves: the pins a clock late, or at once and in whose turn it happens to be.
PHASES = {
    "a clock late": ("    bus <= next_bus;", "    bus_late <= next_bus;\n    bus <= bus_late;"),
    "blocking": ("    bus <= next_bus;", "    bus = next_bus;"),
}


@pytest.mark.req("FW-1")
@pytest.mark.parametrize(
    "phase", ["a clock late", pytest.param("blocking", marks=pytest.mark.slow)]
)
def test_a_phase_that_moves_is_noticed(tmp_path, phase):
    """Else the comparison would hold for any testbench."""
    right, wrong = PHASES[phase]
    text = (ROOT / "sim/dpi/mmcs_tb.sv").read_text()
    assert text.count(right) == 1
    text = text.replace(right, wrong).replace(
        "safety;\n", "safety;\n  longint unsigned bus_late;\n", 1
    )
    broken = written("mmcs_tb.sv", text)
    listed = (ROOT / "sim/dpi/mmcs_tb.f").read_text().split()
    files = [f for f in listed if f.startswith("rtl/") and f.endswith(".sv")]
    name = f"c1_{broken.parent.name}"
    program = dpi.bench(1, NAME=name, SOURCES=" ".join([*files, str(broken)]), OPT="-O0")
    assert "bus.csv" in differing("lab500", tmp_path, 1, ("duration=0.06",), program)


@pytest.mark.slow
@pytest.mark.req("FW-1")
def test_a_line_that_is_held_is_the_engines(tmp_path):
    file = tmp_path / "held.toml"
    file.write_text(HELD_LINE)
    assert differing(file, tmp_path, 3, ("duration=0.04",)) == []


@pytest.mark.slow
def test_waveforms_are_drawn_by_the_simulator(tmp_path):
    program = dpi.bench(1, trace=True)
    words = ["lab500", "--set", "duration=0.055", "--out", tmp_path]
    dpi.run(program, words, tmp_path / "run.vcd", capture_output=True)
    text = (tmp_path / "run.vcd").read_text()
    assert text.startswith("$") and " mmcs_tb $end" in text and text.count("\n") > 100_000


@pytest.mark.req("FW-1")
def test_the_example_moves_its_motor():
    """The driver alone, in a testbench to copy: a step of 200 counts by a servo of 1 ms. As its
    page has it typed: in a shell that has not activated .venv."""
    make = ["make", "-s", "-f", "sim/dpi/Makefile", "library", "example"]
    ran(*make, env={"PATH": os.defpath}, check=True)
    done = ran("build/sim/dpi/example/example_tb", check=True)
    said = "example: result 0, passes 163, missed 0, setpoint 200, encoder 199"
    assert done.stdout.splitlines()[0] == said


# --- what it cannot do -------------------------------------------------------------------------

INSIDE = "it is inside the hardware, where no call of DPI reaches"
EVENT = 'event=[{at = 0.01, input = "%s", value = 1}]'
REFUSED = [
    (["fault_seu_dac"], 3, f"seu_dac_output at 0.104538 s: event refused: {INSIDE}"),
    (["fault_card_absent"], 3, f"card_absent at 0.103938 s: event refused: {INSIDE}"),
    (["fault_irq_lost"], 3, f"irq_lost at 0.103938 s: event refused: {INSIDE}"),
    (["lab500", "--set", EVENT % "seu.u_adaptor.u_core.vector_q"], 1,
     "seu.u_adaptor.u_core.vector_q: through DPI no register can be read or written"),
    (["lab500", "--trace", "x.fst"], 1,
     "--trace: not through DPI: the simulator draws waveforms: +trace=FILE"),
    (["lab500", "--snapshot", "0.1"], 1, "--snapshot: not through DPI: no register can be read"),
    (["--from", "x"], 1, "--from: not through DPI: no register can be written"),
    (["lab500", "--host", "m68020"], 1, "--host: not through DPI: the driver runs as native code"),
    (["puma560"], 1, "the testbench has NumCards=1, and puma560 needs 3"),
    (["lab500", "--set", "clk_hz=16000000"], 1,
     "the testbench has ClkHz=8000000, and lab500 needs 16000000"),
]  # fmt: skip


@pytest.mark.parametrize(("words", "cards", "sentence"), REFUSED)
def test_what_it_cannot_do_is_refused_in_a_sentence(tmp_path, words, cards, sentence):
    done = through_dpi(dpi.bench(cards), [*words, "--out", tmp_path])
    assert done.returncode != 0
    assert done.stderr.strip() == f"mmcs: {sentence}"
    assert "the program ended with status" in done.stdout


def test_the_hash_of_the_registers_is_not_made_up(tmp_path):
    done = through_dpi(dpi.bench(1), ["lab500", "--set", "duration=0.06", "--out", tmp_path])
    assert "; no hash: no register can be read" in done.stdout
    assert json.loads((tmp_path / "report.json").read_text())["hash"] == ""


def test_a_testbench_without_a_scenario_or_a_program_says_so():
    program = dpi.bench(1)
    assert "no scenario; name one, as in +scenario=puma560" in ran(program).stdout
    env = {"MMCS": "no-such-program", "PATH": "/usr/bin:/bin"}
    done = ran(program, "+scenario=lab500", env=env)
    assert "no-such-program: not found" in done.stderr
    assert "the program ended with status 127" in done.stdout


def test_the_line_is_given_by_a_simulator_only(tmp_path):
    done = ran(sys.executable, "-m", "mmcs", "run", "lab500", "--dpi", "99", "--out", tmp_path)
    assert (
        done.stderr.strip() == "mmcs: --dpi 99: Bad file descriptor; a simulator gives this option"
    )
    assert done.returncode == 1
