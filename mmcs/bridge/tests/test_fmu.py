# SPDX-License-Identifier: Apache-2.0
"""The machine as an FMU 3.0: FMPy checks it and gets what our engine gives; make fmu-test."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from mmcs import load, machine, mcdef, run
from mmcs.bridge.fmu import write
from mmcs.tests.conftest import call, good

STEP = 0.001
ANGLE, ENCODER, SETPOINT = 300, 200, 100  # references, of axis 0
ESTOP_CLOSED, ENABLED, PANIC, HASH = 1, 2, 3, 4


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """The unit of lab500, unpacked."""
    path = tmp_path_factory.mktemp("fmu")
    good(call("export", "fmu", "lab500", "--out", path / "lab500.fmu"))
    return path


class Unit:
    """One instance, initialized; what it logs."""

    def __init__(self, unpacked: Path):
        about = fmpy.read_model_description(str(unpacked))
        self.said: list[str] = []
        self.slave = FMU3Slave(
            guid=about.guid, unzipDirectory=str(unpacked), instanceName="unit",
            modelIdentifier=about.coSimulation.modelIdentifier,
        )  # fmt: skip
        self.slave.instantiate(
            loggingOn=True, logMessage=lambda env, status, kind, text: self.said.append(text)
        )

    def begin(self) -> Unit:
        self.slave.enterInitializationMode(startTime=0.0)
        self.slave.exitInitializationMode()
        self.steps = 0
        return self

    def step(self, setpoint: float) -> tuple[float, float]:
        self.slave.setFloat64([SETPOINT], [setpoint])
        self.slave.doStep(self.steps * STEP, STEP)
        self.steps += 1
        return tuple(self.slave.getFloat64([ENCODER, ANGLE]))


@pytest.fixture
def unit(folder, tmp_path):
    made = Unit(Path(fmpy.extract(str(folder / "lab500.fmu"), str(tmp_path / "unit"))))
    yield made.begin()
    made.slave.freeInstance()


def demand(n: int) -> int:
    return 0 if n < 5 else 400 if n < 150 else -250


@pytest.mark.req("DRV-4")
def test_fmpy_finds_nothing_wrong(folder, tmp_path):
    assert validate_fmu(str(folder / "lab500.fmu")) == []
    write(load("puma560"), tmp_path / "arm.fmu")
    assert validate_fmu(str(tmp_path / "arm.fmu")) == []
    fmpy.simulate_fmu(str(tmp_path / "arm.fmu"), stop_time=0.02, output_interval=STEP)


def test_the_same_machine_is_the_same_unit(folder, tmp_path):
    write(load("lab500"), tmp_path / "again.fmu")
    assert (tmp_path / "again.fmu").read_bytes() == (folder / "lab500.fmu").read_bytes()
    with zipfile.ZipFile(tmp_path / "again.fmu") as files:  # unzip gives them these permissions
        assert {one.external_attr >> 16 for one in files.infolist()} == {0o644}


@pytest.mark.req("DRV-4", "SRV-7")
def test_it_is_our_machine_to_the_bit(unit):
    """300 steps in the unit, and the same calls of the engine from Python."""
    setup = load("lab500")
    sim = machine(setup)
    client = sim.open(mcdef.O_RDWR)
    assert sim.configure(client, setup.driver(), setup.params) == (0, "")
    begin, seen, ours = sim.time, [], []
    for n in range(300):
        seen.append(unit.step(demand(n)))
        sim.write(client, [demand(n)])
        assert sim.run(begin + n * STEP + STEP)
        ours.append((float(sim.read(client)[0]["encnow"]), sim.true(0)["angle"]))
    assert seen == ours
    assert seen[140][0] > 380 and seen[-1][0] < -230, "it moves"


@pytest.mark.req("DRV-4", "API-1")
def test_with_its_motions_it_is_the_run_of_the_scenario(tmp_path):
    setup = load("lab500")
    write(setup, tmp_path / "moves.fmu", motions=True)
    assert validate_fmu(str(tmp_path / "moves.fmu")) == []
    unit = Unit(Path(fmpy.extract(str(tmp_path / "moves.fmu"), str(tmp_path / "unit")))).begin()
    for n in range(round(setup.scenario.duration / STEP)):
        unit.slave.doStep(n * STEP, STEP)
    assert f"0x{unit.slave.getUInt64([HASH])[0]:016x}" == run(setup).hash
    unit.slave.freeInstance()


@pytest.mark.req("DRV-4")
def test_reset_repeats_and_two_live_side_by_side(unit, folder, tmp_path):
    other = Unit(Path(fmpy.extract(str(folder / "lab500.fmu"), str(tmp_path / "other")))).begin()
    first = [unit.step(demand(n)) for n in range(40)]
    assert [other.step(demand(n)) for n in range(40)] == first
    unit.slave.reset()
    unit.begin()
    assert [unit.step(demand(n)) for n in range(40)] == first
    other.slave.freeInstance()


@pytest.mark.req("DRV-4", "API-1")
@pytest.mark.parametrize("motions", [False, True])
def test_a_state_set_back_goes_on_to_the_same_bits(tmp_path, motions):
    """In the unit itself, earlier and later states in any order; from bytes in another unit, one
    with a machine and one without."""
    scenario = load("user_loop" if motions else "lab500")
    write(scenario, tmp_path / "it.fmu", motions=motions)

    def made(name: str) -> Unit:
        return Unit(Path(fmpy.extract(str(tmp_path / "it.fmu"), str(tmp_path / name))))

    def go(unit: Unit, begin: int, end: int) -> list:
        for n in range(begin, end):
            if not motions:
                unit.slave.setFloat64([SETPOINT], [demand(2 * n)])
            unit.slave.doStep(n * STEP, STEP)
        return [*unit.slave.getUInt64([HASH]), *unit.slave.getFloat64([ENCODER, ANGLE])]

    unit, other, empty = made("unit").begin(), made("other").begin(), made("empty")
    go(unit, 0, 60)
    early = unit.slave.getFMUState()
    go(unit, 60, 90)
    late = unit.slave.getFMUState()
    last = go(unit, 90, 130)
    unit.slave.setFMUState(early)
    again = unit.slave.serializeFMUState(early)
    assert go(unit, 60, 130) == last
    unit.slave.setFMUState(late)
    assert go(unit, 90, 130) == last
    go(other, 0, 5)
    for another in (other, empty):
        another.slave.setFMUState(another.slave.deserializeFMUState(again))
        assert go(another, 60, 130) == last
    for one in (unit, other, empty):
        one.slave.freeInstance()


@pytest.mark.req("PAN-1", "DRV-6")
def test_an_open_stop_loop_stops_it(unit):
    unit.step(0)
    assert unit.slave.getBoolean([ENABLED, PANIC]) == [True, False]
    unit.slave.setBoolean([ESTOP_CLOSED], [False])
    unit.step(100)
    unit.step(100)
    assert unit.slave.getBoolean([ESTOP_CLOSED, ENABLED, PANIC]) == [False, False, True]


@pytest.mark.parametrize(("what", "told"), [
    (lambda u: u.slave.setFloat64([SETPOINT], [float("nan")]), "setpoint: must be a number of cou"),
    (lambda u: u.slave.setFloat64([SETPOINT], [2.0**31]), "setpoint: must be a number of counts"),
    (lambda u: u.slave.setFloat64([ENCODER], [0.0]), "fmi3SetFloat64: there is no such input"),
    (lambda u: u.slave.getFloat64([ENCODER + 1]), "fmi3GetFloat64: there is no such variable"),
    (lambda u: u.slave.setBoolean([PANIC], [False]), "fmi3SetBoolean: there is no such input"),
    (lambda u: u.slave.doStep(5.0, STEP), "fmi3DoStep: a step goes on where the last one ended"),
    (lambda u: u.slave.doStep(0.0, -STEP), "fmi3DoStep: a step goes on where the last one ended"),
    (lambda u: u.slave.getInt32([0]), "fmi3GetInt32: is not offered"),
    (lambda u: u.slave.deserializeFMUState(b"x" * 5000), "fmi3DeserializeFMUState: not a state"),
])  # fmt: skip
def test_what_cannot_be_is_told_in_one_sentence(unit, what, told):
    with pytest.raises(fmpy.fmi1.FMICallException):
        what(unit)
    assert len(unit.said) == 1 and told in str(unit.said[0])
    assert unit.step(0)[0] == 0, "and the unit goes on"


@pytest.mark.parametrize("harm", ["gone", "short", "another"])
def test_a_damaged_unit_does_not_begin(folder, tmp_path, harm):
    unpacked = Path(fmpy.extract(str(folder / "lab500.fmu"), str(tmp_path / "unit")))
    file = unpacked / "resources/setup.bin"
    good = file.read_bytes()
    file.unlink()
    if harm != "gone":
        file.write_bytes(good[:-1] if harm == "short" else good[:8] + b"0" * 63 + good[71:])
    with pytest.raises(Exception, match="instantiate"):
        Unit(unpacked)
