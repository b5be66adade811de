# SPDX-License-Identifier: Apache-2.0
"""The engine behind a testbench, in another simulator's schedule of the same RTL: log and bus
cycles are those of the engine's own machine, to the byte."""

from pathlib import Path

import pytest

from mmcs import ROOT, Setup, load, run_scenario, simulate, write_setup
from mmcs.place import digest
from tools import dpi
from tools.compiled import ran, written

# pins of the machine, lines of encoders and of the bus, the host
FAULTS = ["fault_estop", "fault_cable", "fault_pc_power", "fault_sysreset", "fault_axis_switch",
          "fault_dip_swapped", "fault_encoder_glitch", "fault_encoder_cut", "fault_bus_errors",
          "fault_bus_error_write", "fault_host_stall", "fault_late_interrupt"]  # fmt: skip
HELD = 'event=[{at = 0.02, input = "vme_d_stuck0", value = 4, until = 0.022}]'
# By test: a scenario, its cards and what is changed of it. First the whole shape of one in a tenth
# of a second: its move, and its step.
BRIEF = {
    "lab500": ("lab500", 3, "cards=3", "duration=0.12"),
    "puma560": ("puma560", 3, "duration=0.1", "motion.0.duration=0.03", "motion.1.at=0.085"),
    "fault_estop": ("fault_estop", 3, "duration=0.12"),
}
SLOW = {
    "lab500 whole": ("lab500", 1),
    "puma560 whole": ("puma560", 3),
    "puma560_coupled": ("puma560_coupled", 3),
    "a data line is held": ("arm_move", 3, "expect=[]", "duration=0.04", HELD),
    **{f"{name} whole": (name, 3, "expect=[]") for name in FAULTS},
}


def through_dpi(program: Path, setup: Setup, folder: Path):
    write_setup(setup, folder / "setup.bin")
    return dpi.run(program, folder / "setup.bin", folder, capture_output=True, text=True)


def differing(name: str, tmp_path: Path, cards: int, sets=(), program=None) -> list[str]:
    """The files of the two ways that are not the same."""
    setup = load(name, *sets)
    run_scenario(setup, tmp_path / "engine", carry_out=lambda s: simulate(s, bus=True))
    (tmp_path / "dpi").mkdir()
    done = through_dpi(program or dpi.bench(cards), setup, tmp_path / "dpi")
    found = []
    for file in ("log.csv", "bus.csv"):
        ours, theirs = (tmp_path / way / file for way in ("engine", "dpi"))
        assert theirs.is_file(), done.stderr + done.stdout
        assert len(ours.read_bytes().splitlines()) > 30
        if ours.read_bytes() != theirs.read_bytes():
            found.append(file)
    return found


@pytest.mark.req("FW-1", "API-1")
@pytest.mark.parametrize("what", [*BRIEF, *(pytest.param(k, marks=pytest.mark.slow) for k in SLOW)])
def test_log_and_bus_cycles_are_the_engines(tmp_path, what):
    """A fault until 0.1 s after its last event: the heartbeats end 50 ms after it."""
    name, cards, *sets = (BRIEF | SLOW)[what]
    if name in FAULTS and what in SLOW:
        ends = [event.until or event.at for event in load(name).scenario.event]
        sets.append(f"duration={max(ends, default=0.1) + 0.1:g}")
    assert differing(name, tmp_path, cards, sets) == []


# A phase that moves: the pins a clock late, or at once and in whose turn it happens to be.
PHASES = {
    "a clock late": ("    bus <= next_bus;", "    bus_late <= next_bus;\n    bus <= bus_late;"),
    "blocking": ("    bus <= next_bus;", "    bus = next_bus;"),
}


@pytest.mark.slow  # a testbench that is built anew
@pytest.mark.req("FW-1")
@pytest.mark.parametrize("phase", PHASES)
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
def test_waveforms_are_drawn_by_the_simulator(tmp_path):
    write_setup(load("lab500", "duration=0.055"), tmp_path / "setup.bin")
    dpi.run(dpi.bench(1, trace=True), tmp_path / "setup.bin", tmp_path, tmp_path / "run.vcd",
            capture_output=True)  # fmt: skip
    text = (tmp_path / "run.vcd").read_text()
    assert text.startswith("$") and " mmcs_tb $end" in text and text.count("\n") > 100_000


# --- what it cannot do -------------------------------------------------------------------------

INSIDE = "it is inside the hardware, where no call of DPI reaches"
EVENT = 'event=[{at = 0.01, input = "%s", value = 1}]'
REFUSED = [
    (["fault_seu_dac"], f"seu_dac_output at 0.104538 s: event refused: {INSIDE}"),
    (["fault_card_absent"], f"card_absent at 0.103938 s: event refused: {INSIDE}"),
    (["fault_irq_lost"], f"irq_lost at 0.103938 s: event refused: {INSIDE}"),
    (["lab500", "cards=3", EVENT % "seu.u_adaptor.u_core.vector_q"],
     "an upset of a register at 0.013572 s: event refused: no such input"),
    (["lab500"], f"setup is for the simulator c1 {digest()}, and this is c3 {digest()}: "
     "`mmcs compile` it again"),
    (["lab500", "cards=3", "motion=[]", "expect=[]", 'program=[{run = "true"}]'],
     "the set-up's [[program]] needs `mmcs run`"),
]  # fmt: skip


@pytest.mark.parametrize(("words", "sentence"), REFUSED)
def test_what_it_cannot_do_is_refused_in_a_sentence(tmp_path, words, sentence):
    done = through_dpi(dpi.bench(3), load(*words), tmp_path)
    assert done.returncode != 0
    assert done.stderr.strip() == f"mmcs: {sentence.replace('setup', words[0])}"
    assert "the run ended with status 1" in done.stdout


def test_the_hash_of_the_registers_is_not_made_up(tmp_path):
    done = through_dpi(dpi.bench(3), load("lab500", "cards=3", "duration=0.06"), tmp_path)
    assert "; no hash: no register can be read" in done.stdout


@pytest.mark.parametrize(("file", "told"), [
    (None, "mmcs_tb: no set-up; name one, as in +setup=build/setups/puma560.bin"),
    ("none.bin", "none.bin: there is no such set-up: make it by `mmcs compile`"),
    (__file__, "this is no set-up: make it by `mmcs compile`"),
])  # fmt: skip
def test_a_testbench_without_a_set_up_says_so(tmp_path, file, told):
    done = ran(dpi.bench(3), *([f"+setup={file}"] if file else []), f"+out={tmp_path}")
    assert told in done.stdout + done.stderr and done.returncode
