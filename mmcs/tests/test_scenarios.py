# SPDX-License-Identifier: Apache-2.0
"""The whole loop, firmware to motor and back: ready scenarios meet their own expectations, steps
the reference responses (studies/reference.py).

Run in the build that skips idle clocks; its runs are those of the plain build to the bit, which
sim/tests/engine and studies/lockstep.py show.
"""

import math

import numpy as np
import pytest

from mmcs import logcols
from mmcs.errors import RunError
from mmcs.inputs import INPUTS, UPSET
from mmcs.runs.expect_plant import index_counts
from mmcs.runs.machine import machine
from mmcs.runs.report import make_report
from mmcs.runs.runner import simulate
from mmcs.scenario.files import scenario_names
from mmcs.scenario.load import load
from studies import reference

REQUIREMENTS = {
    "adda_filter": ["SRV-6", "ADC-1"],
    "axes32": ["CRD-1", "DRV-2"],
    "fw2": ["FW-2"],
    "lab500_torque": ["SRV-1"],
    "puma560": ["SRV-1", "DRV-10", "FW-2"],
    "puma560_velocity": ["SRV-1"],
    "puma560_bounce": ["DRV-5", "DRV-6"],
    "puma560_calibrate": ["CAL-1", "DRV-8"],
    "puma560_calibrate_30": ["CAL-1", "DRV-8"],
    "puma560_double_buffer": ["DAC-1"],
    "puma560_single_buffer": ["DAC-1"],
    "servo_overrun": ["DRV-7"],
    "user_loop": ["FW-2"],
    "fault_axis_switch": ["SW-1"],
    "fault_bus_error_read": ["VME-6"],
    "fault_bus_errors": ["VME-6"],
    "fault_cable": ["PAN-1", "PAN-2"],
    "fault_card_absent": ["DRV-7"],
    "fault_dip_double": ["DRV-2", "DRV-3"],
    "fault_dip_swapped": ["DRV-2"],
    "fault_encoder_cut_ilim": ["SRV-4", "DRV-6"],
    "fault_encoder_swap_poschk": ["DRV-6"],
    "fault_estop": ["PAN-1", "DRV-5", "DRV-6"],
    "fault_host_stall": ["HB-1", "HB-2"],
    "fault_irq_lost": ["DRV-7"],
    "fault_panic_open": ["JMP-1", "DRV-7"],
    "fault_pc_power": ["PAN-2"],
    "fault_sclock_open": ["JMP-1", "DAC-1"],
}


WITNESSED = ("puma560", "puma560_velocity", "lab500_torque", "lab500_nocomp")


def cases():
    for name in scenario_names():
        marks = [pytest.mark.req(*REQUIREMENTS[name])] if name in REQUIREMENTS else []
        yield pytest.param(name, marks=marks, id=name)


def check_witnesses(result):
    """Driver, counter and physics agree at the end of the motion.

    The driver's figure is as old as its last sample; what an axis still turns since is allowed.
    """
    for axis, (state, truth) in enumerate(zip(result.states, result.witnesses, strict=True)):
        motor = result.setup.robot.axis[axis]
        moving = state["vel"] != 0
        behind = truth["count"] - state["encnow"]
        assert 0 <= behind * (1 if state["vel"] > 0 else -1) <= abs(state["vel"]) + 2 * moving
        wires = (truth["count"] - truth["register"] + 0x8000) % 0x10000 - 0x8000
        assert abs(wires) <= moving, "the counter has lost or gained edges"
        turned = (truth["angle"] - motor.angle0) * motor.gear / (2 * math.pi)
        assert abs(turned * motor.counts_per_rev - truth["count"]) <= 1


def carry_out(name, *sets):
    result = simulate(load(name, ("skip=true", *sets)))
    return result, make_report(result, "native")


def failures(report):
    return [item["what"] for item in report["expect"] if not item["ok"]]


@pytest.mark.parametrize("name", list(cases()))
def test_scenario(name):
    result, report = carry_out(name)
    if name in WITNESSED:
        check_witnesses(result)
    assert report["expect"], "a scenario that expects nothing shows nothing"
    assert failures(report) == []


@pytest.mark.parametrize("name", ["puma560_calibrate", "puma560_calibrate_30"])
def test_an_index_gives_the_same_count_both_ways(name):
    """Passed upwards, then downwards: whole revolutions apart, to the count."""
    result, _ = carry_out(name)
    for axis, motor in enumerate(result.setup.motors()):
        up, down = index_counts(result, axis)
        assert (up - down) % motor["counts_per_rev"] == 0


def test_expectations_can_fail():
    """The same run with something broken, or not broken, is found out."""
    pot = 'event=[{at=0.0, input="pot_cut", index=2, value=1}]'
    wrong = failures(carry_out("puma560_calibrate_30", pot)[1])
    assert [what.split(",")[0] for what in wrong] == ["axis 2 calibrated at 2 marks"]
    wrong = failures(carry_out("fault_encoder_slip", "event=[]")[1])  # no slip
    assert [what.split(" in ")[0] for what in wrong] == ["joint 0 true minus encoder"]
    assert len(failures(carry_out("fault_dip_double", "event=[]")[1])) == 1


@pytest.mark.slow
@pytest.mark.req("FW-2")
def test_one_kilohertz_for_a_minute():
    """§1.3.1: six axes at 1 kHz with the default host, 60 s, no interrupt missed."""
    result, report = carry_out("fw2", "duration=60")
    assert failures(report) == []
    assert len(result.log) == pytest.approx(60_000, abs=1)
    assert report["stats"]["interrupts"] >= 60_000


def test_every_named_requirement_belongs_to_a_scenario():
    assert set(REQUIREMENTS) <= set(scenario_names())


def test_fault_table_is_that_of_today():
    """Every row of docs/evidence/faults.md is run again: some 10 s of a processor."""
    from studies.faults import DOCUMENT, table

    old, new = DOCUMENT.read_text().splitlines(), table().splitlines()
    stale = [line for line in new if line not in old]
    assert old == new, f"run `python -m studies.faults`; it would write {stale}"


# --- against the reference -----------------------------------------------------------------------

# One worker measures each response once and keeps it.
ONE_WORKER = pytest.mark.xdist_group("closed_loop")


@ONE_WORKER
@pytest.mark.req("SRV-1", "SRV-2", "SRV-3", "ENC-1", "DAC-1", "DRV-10", "DRV-11")
@pytest.mark.parametrize("compensation", reference.COMPENSATION)
@pytest.mark.parametrize("row", reference.ROWS, ids=lambda r: f"{r.robot}-{r[1]}-{r[2]}-{r[3]}")
def test_step_response(row, compensation):
    result, _ = reference.measure(row.robot, row.interval_us, row.size, compensation)
    assert reference.outside(row, compensation) == []
    rest = logcols.column(result.log, row.axis, "encoder")[-20:]
    assert rest.max() == rest.min(), "the axis moves although friction should hold it"
    check_witnesses(result)


@ONE_WORKER
@pytest.mark.req("SRV-1", "SRV-2", "SRV-3", "SYN-1")
@pytest.mark.parametrize("size", reference.SHIPPED)
@pytest.mark.parametrize("axis", range(6))
def test_shipped_gains_answer_as_the_reference_servo(axis, size):
    assert reference.outside_shipped(axis, size) == []


@pytest.mark.req("SYN-1", "SRV-4")
def test_the_coupled_move_keeps_off_its_limits():
    """The move of puma560_coupled; one count moves no D/A far through the derivative."""
    sets = ("motion.1.at=0.639", "expect=[]", "duration=0.64")
    result = simulate(load("puma560_coupled", sets))
    for axis, motor in enumerate(result.setup.robot.axis):
        error, current = (
            logcols.column(result.log, axis, name)[:638].astype(float)
            for name in ("error", "current")
        )
        assert np.abs(error).max() <= 60 and np.abs(current).max() < motor.servo.ilim
        noise = np.sqrt(np.mean(np.diff(current[50:550]) ** 2))
        assert noise <= (90 if axis == 0 else 150)
        p = result.setup.params[axis]
        assert p["a0"] / p["b0"] - (p["a0"] + p["a1"]) / (p["b0"] + p["b1"]) <= 150


@ONE_WORKER
def test_document_is_current():
    """After the steps above, whose results are kept: this costs nothing more."""
    told = "docs/evidence/closed_loop.md is stale: run `python -m studies.reference`"
    assert reference.DOCUMENT.read_text() == reference.document(), told


def test_python_reads_the_inputs_as_the_engine_has_them():
    setup = load("lab500")
    with machine(setup) as sim:
        assert sim.input_names() == [*INPUTS, *(UPSET + name for name in sim.registers())]
        rows = [sim.lib.mmcs_sim_input(n) for n in range(len(INPUTS) + 1)]
        assert rows.pop() == sim.ffi.NULL
        for row, (name, known) in zip(rows, INPUTS.items(), strict=True):
            texts = [sim.ffi.string(text).decode() for text in
                     (row.name, row.draw, row.sort, row.meaning)]  # fmt: skip
            assert texts == [name, known.draw, known.sort, known.meaning]
            assert (row.low, row.high, row.healthy) == (known.low, known.high, known.healthy)
            assert row.lasting == known.lasting
            assert ("machine", "card", "axis")[row.scope] == known.scope
            for value in (known.low - 1, known.high + 1):
                with pytest.raises(RunError, match="value out of range"):
                    sim.add_event(0.0, rows.index(row), 0, value)
