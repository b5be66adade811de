# SPDX-License-Identifier: Apache-2.0
"""Every ready scenario meets its own expectations.

Run in the build that skips idle clocks; its runs are those of the plain build to the bit, which
sim/tests/engine and studies/lockstep.py show.
"""

import pytest

from mmcs.runs.expect_plant import index_counts
from mmcs.runs.report import make_report
from mmcs.runs.runner import simulate
from mmcs.scenario.files import scenario_names
from mmcs.scenario.load import load
from mmcs.tests.test_closed_loop import check_witnesses

REQUIREMENTS = {
    "adda_filter": ["SRV-6", "ADC-1"],
    "axes32": ["CRD-1", "DRV-2"],
    "fw2": ["FW-2"],
    "lab500_torque": ["SRV-1"],
    "puma560": ["SRV-1", "DRV-10", "FW-2"],
    "puma560_velocity": ["SRV-1"],
    "puma560_bounce": ["DRV-5", "DRV-6"],
    "puma560_calibrate": ["CAL-1", "DRV-8"],
    "puma560_calibrate_10": ["CAL-1", "DRV-8"],
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
    wrong = failures(carry_out("puma560_calibrate_10", pot)[1])
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
