# SPDX-License-Identifier: Apache-2.0
"""The safe machine: one switch, each piece by itself, and what it does on the simulated arm."""

import random

import pytest

from mmcs import mcdef
from mmcs.runs.machine import machine
from mmcs.runs.session import Session
from mmcs.scenario.load import load
from mmcs.sweeps.campaign import MOTIONS, make_plan
from mmcs.sweeps.faults import Fault
from mmcs.sweeps.twin import Twin

SAFE = 'safety="2026"'


def test_nothing_of_it_unless_asked_for():
    setup = load("arm_move", ())
    config = setup.config()
    assert setup.hardware() == "1989" and not config["amp_panic_cut"]
    assert not any(value for name, value in config.items() if name.startswith("guard_"))


def test_one_switch_takes_its_limits_from_the_robot():
    setup = load("arm_move", (SAFE,))
    assert setup.hardware() == "2026" and setup.config()["amp_panic_cut"] == 3
    assert setup.guard() == {
        "guard_jump": 75, "guard_follow": 300, "guard_samples": 5, "guard_runaway": 4,
        "guard_missed": 5, "guard_lease": 10, "guard_lock": 1, "guard_readback": 1,
        "guard_checked": 1, "guard_brakes": 31000, "guard_latched": 1, "guard_clock": 1,
    }  # fmt: skip
    slow = load("puma560_velocity", (SAFE,)).guard()  # 2 ms
    assert (slow["guard_jump"], slow["guard_lease"], slow["guard_brakes"]) == (149, 5, 32000)
    bare = load("lab500", (SAFE,)).guard()  # no brakes, and nobody knows what it needs
    assert bare["guard_brakes"] == bare["guard_follow"] == bare["guard_samples"] == 0


def test_a_piece_by_itself_and_a_switch_less_a_piece():
    one = load("arm_move", ("host.guard_brakes=20000",))
    assert one.guard()["guard_brakes"] == 20000 and sum(one.guard().values()) == 20000
    assert load("arm_move", ('hardware="2026"',)).guard()["guard_latched"] == 1
    less = load("arm_move", (SAFE, 'hardware="1989"', "host.guard_lease=0", "amp_panic_cut=false"))
    assert less.hardware() == "1989" and less.guard()["guard_lease"] == 0
    assert less.guard()["guard_latched"] == 0 and less.config()["amp_panic_cut"] == 0


def test_what_it_amounts_to_is_told(mmcs):
    told = mmcs("show", "puma560", "--set", SAFE)[1]
    for text in ('hardware = "2026"', 'amp_panic_cut = "dynamic brake"', "guard_follow = 300"):
        assert text in told.replace("\n", " ")
    assert "safety" not in mmcs("show", "puma560")[1]
    assert "lab500 has no [axis.servo] follow" in mmcs("check", "lab500", "--set", SAFE)[1]
    late = ("--set", "interval_us=20000", "--set", 'hardware="2026"')
    assert "above the heartbeat's 10000 us" in mmcs("check", "puma560", *late)[1]
    error = mmcs("check", "puma560", "--set", "amp_panic_cut='x'")[2]
    assert 'must be one of false, true, "brakes first", "dynamic brake"' in error


@pytest.mark.req("DRV-9")
@pytest.mark.parametrize("name", MOTIONS)
def test_healthy_motions_are_not_stopped(name):
    plan = make_plan((name,), (), 1, (SAFE,))
    Twin(plan.setups[name]).close()  # refuses one that stops


def test_drawn_motions_stay_off_the_stops():
    """The first that is drawn for run 635 drives J5 against its joint stop; run 3 is well."""
    from studies.campaign import _beside, _twin, variation, within_limits

    first = variation(MOTIONS[3], random.Random("healthy/635"))
    assert not within_limits(_twin(MOTIONS[3], first))
    drawn = _beside(MOTIONS[3], 635)
    assert drawn["again"] == 1 and drawn["stopped"] == "" and not drawn["harmed"]
    assert _beside(MOTIONS[3], 3)["again"] == 0


def _sunk(sets: tuple[str, ...], input_: str, value: float) -> tuple[float, bool]:
    """Degrees that J2 moved off after a stop of the stretched arm, and whether it is told."""
    setup = load("puma560_hold", (*sets, "duration=0.7"))
    sim = machine(setup)
    session = Session(sim, setup)
    client = session.begin()
    sim.run(session.start + 0.2)
    before = sim.true(1)["angle"]
    if input_ == "MSTOP":
        assert sim.ioctl(client, mcdef.MSTOP) == 0
    else:
        names = sim.input_names()
        sim.add_event(sim.time, names.index(input_), 0, value)
        if input_ == "estop":
            sim.add_event(sim.time + 0.001, names.index(input_), 0, 0)
    sim.run(session.start + 0.6)
    moved, told = abs(sim.true(1)["angle"] - before), bool(sim.stats()["panic_level"])
    sim.destroy()
    return 57.29578 * moved, told


@pytest.mark.req("PAN-1", "PAN-3", "DRV-9")
@pytest.mark.parametrize("sets", [(SAFE,), (SAFE, 'hardware="1989"')], ids=["2026", "driver"])
@pytest.mark.parametrize("input_", ["MSTOP", "estop"])
def test_joint_2_does_not_sink_in_a_stop(input_, sets):
    """A press of 1 ms, or MSTOP: in 1989 D/As are zero, and the brakes open or not yet closed."""
    before, _ = _sunk((), input_, 1)
    after, panics = _sunk(sets, input_, 1)
    assert before > 0.5 and after < 0.05 and panics


@pytest.mark.req("PAN-3", "HB-1")
def test_host_that_dies_is_noticed_after_10_ms():
    setup = load("arm_move", (SAFE,))
    sim = machine(setup)
    session = Session(sim, setup)
    session.begin()
    sim.run(session.start + 0.15)
    at = sim.time
    sim.add_event(at, sim.input_names().index("host_dead"), 0, 1)
    sim.run(at + 0.2)
    told = next(n["t"] for n in sim.notes() if n["kind"] == "panic" and n["t"] > at)
    assert 0.008 < told - at < 0.0105
    assert all(sim.true(axis)["current"] == pytest.approx(0, abs=1e-6) for axis in range(6))
    sim.destroy()


@pytest.mark.req("DRV-9")
def test_write_of_the_hosts_library_is_checked():
    """And a setpoint that is changed on its way, or lost, stops the machine."""
    for name, value in (("write_flip", 1 << 20), ("writes_lost", 3)):
        setup = load("arm_move", ("host.guard_checked=true",))
        sim = machine(setup)
        session = Session(sim, setup)
        session.begin()
        sim.run(session.start + 0.1)
        assert sim.stats()["enabled"]
        sim.add_event(sim.time, sim.input_names().index(name), 0, value)
        sim.run(session.start + 0.15)
        assert not sim.stats()["enabled"]
        assert any("PANIC: setpoints" in n["text"] for n in sim.notes())
        sim.destroy()


@pytest.mark.req("PAN-1")
def test_encoder_that_steps_illegally_is_noticed_at_once():
    """A and B of a moving axis are exchanged: where they differ, both change in one clock."""
    plan = make_plan(("arm_move",), (), 1, (SAFE,))
    twin = Twin(plan.setups["arm_move"])
    after = []
    for at in (0.1400, 0.1403, 0.1406, 0.1409, 0.1412, 0.1415):
        event = {"at": at, "input": "encoder_swap", "value": 1, "index": 3}
        seen, more = twin.run(Fault(0, "arm_move", "pin", "encoder_swap", at, event=event))
        assert more["by"] == "PANIC"
        after.append(seen.detected_s)
    assert min(after) < 1e-4
    twin.close()


# What a machine with the checks of 1989 and the guard notices late or never.
NOTICED = [
    ("arm_move", {"at": 0.26, "input": "encoder_a_cut", "value": 1, "index": 4}, 30),
    ("arm_move", {"at": 0.28, "input": "encoder_b_cut", "value": 1, "index": 1}, 30),
    ("puma560_hold", {"at": 0.1, "input": "amp_saturated", "value": 1, "index": 5}, 15),
    ("arm_calibrate", {"at": 0.1, "input": "encoder_swap", "value": 1, "index": 5}, 10),
    ("puma560_velocity", {"at": 0.5346, "input": "sclock_open", "value": 1, "index": 2}, 12),
]


@pytest.mark.req("DRV-9", "PAN-1")
@pytest.mark.parametrize(("name", "event", "ms"), NOTICED, ids=lambda v: str(v)[:20])
def test_what_is_noticed_in_time(name, event, ms):
    plan = make_plan((name,), (), 1, (SAFE, "axis.all.ilimax=60"))
    twin = Twin(plan.setups[name])
    seen, more = twin.run(Fault(0, name, "pin", "test", event["at"], event=event))
    twin.close()
    assert more["by"] == "PANIC" and 1e3 * seen.detected_s < ms, (seen, more)


@pytest.mark.req("DRV-9")
def test_gains_of_an_axis_that_is_on_are_refused():
    plan = make_plan(("arm_move",), (), 1, (SAFE,))
    twin = Twin(plan.setups["arm_move"])
    call = {"at": 0.1, "request": "MSETPARAM", "axis": 5, "set": {"a0": 3}}
    _, more = twin.run(Fault(0, "arm_move", "message", "test", 0.1, call=call))
    twin.close()
    assert more["by"] == "MSETPARAM refused"


@pytest.mark.req("PAN-3")
def test_wrist_whose_amplifier_is_stuck_does_not_coast():
    """J6 has no brake: what PANIC cuts off alone goes on turning."""
    turned = []
    for cut in ("brakes first", "dynamic brake"):
        stuck = "event=[{at=0.1, input='amp_saturated', index=5, value=1}]"
        setup = load("puma560_hold", (SAFE, f"amp_panic_cut='{cut}'", "duration=0.4", stuck))
        sim = machine(setup)
        session = Session(sim, setup)
        session.begin()
        sim.run(session.start + 0.4)
        assert sim.stats()["panic_level"] and sim.notes()
        turned.append(57.29578 * abs(sim.true(5)["angle"]))
        sim.destroy()
    assert turned[0] > 5 and turned[1] < 2, turned
