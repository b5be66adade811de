# SPDX-License-Identifier: Apache-2.0
"""The whole loop, firmware to motor and back, against the reference responses.

Every run is seen by three witnesses: what the driver reports, what the counter on the card holds,
and what the physics did. The reference responses are in studies/reference.py.
"""

import functools
import math

import numpy as np
import pytest

from mmcs import logcols
from mmcs.errors import RunError
from mmcs.runs.report import make_report
from mmcs.runs.runner import simulate
from mmcs.scenario.load import load
from studies import reference

# One worker measures each response once and keeps it.
pytestmark = pytest.mark.xdist_group("closed_loop")

BREAKAWAY, COULOMB = 132, 105.5  # friction of the bench motor, D/A units


@functools.cache
def carry_out(name, *sets):
    result = simulate(load(name, sets))
    return result, make_report(result, "native")


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


@pytest.mark.req("SRV-1", "SRV-2", "SRV-3", "ENC-1", "DAC-1", "DRV-10", "DRV-11")
@pytest.mark.parametrize("compensation", reference.COMPENSATION)
@pytest.mark.parametrize("row", reference.ROWS, ids=lambda r: f"{r.robot}-{r[1]}-{r[2]}-{r[3]}")
def test_step_response(row, compensation):
    result, _ = reference.measure(row.robot, row.interval_us, row.size, compensation)
    assert reference.outside(row, compensation) == []
    rest = logcols.column(result.log, row.axis, "encoder")[-20:]
    assert rest.max() == rest.min(), "the axis moves although friction should hold it"
    check_witnesses(result)


@pytest.mark.req("SRV-1", "SRV-2", "SRV-3", "SYN-1")
@pytest.mark.parametrize("size", reference.SHIPPED)
@pytest.mark.parametrize("axis", range(6))
def test_shipped_gains_answer_as_the_reference_servo(axis, size):
    assert reference.outside_shipped(axis, size) == []


@pytest.mark.req("SYN-1", "SRV-4")
def test_the_coupled_move_keeps_off_its_limits():
    """The move of puma560_coupled; one count moves no D/A far through the derivative."""
    result, _ = carry_out("puma560_coupled", "motion.1.at=0.639", "expect=[]", "duration=0.64")
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


def test_document_is_current():
    """After the steps above, whose results are kept: this costs nothing more."""
    told = "docs/evidence/closed_loop.md is stale: run `python -m studies.reference`"
    assert reference.DOCUMENT.read_text() == reference.document(), told


@pytest.mark.req("SRV-3")
def test_without_compensation_it_stops_outside():
    result, report = carry_out("lab500_nocomp")
    error = report["axes"][0]["steady_error_counts"]
    gain = (7309 - 7027) / 64
    assert math.ceil(COULOMB / gain) - 1 <= error <= math.ceil(BREAKAWAY / gain) + 1
    assert report["axes"][0]["settle_ms"] is None
    check_witnesses(result)
    compensated = carry_out("lab500")[1]["axes"][0]["steady_error_counts"]
    assert abs(compensated) < error / 3


def test_python_reads_the_inputs_as_the_engine_has_them():
    from mmcs.inputs import INPUTS, UPSET
    from mmcs.runs.machine import machine

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
