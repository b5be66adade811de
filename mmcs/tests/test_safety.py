# SPDX-License-Identifier: Apache-2.0
"""The safe machine: one switch, each piece by itself, and what it does on the simulated arm."""

import contextlib
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


@contextlib.contextmanager
def moving(name, *sets, at):
    """The machine at a time of a scenario's motion, and its client of the driver."""
    setup = load(name, sets)
    with machine(setup) as sim:
        session = Session(sim, setup)
        client = session.begin()
        sim.run(session.start + at)
        yield sim, client


def add_input(sim, name, value, after=0.0):
    sim.add_event(sim.time + after, sim.input_names().index(name), 0, value)


def seen_of(name, *sets, **faults):
    """What becomes of each fault in a motion of the safe machine: events, or a call."""
    plan = make_plan((name,), (), 1, (SAFE, *sets))
    twin = Twin(plan.setups[name])
    for kind, entries in faults.items():
        for entry in entries:
            yield twin.run(Fault(0, name, "pin", "test", entry["at"], **{kind: entry}))
    twin.close()


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
    with moving("puma560_hold", *sets, "duration=0.7", at=0.2) as (sim, client):
        before = sim.true(1)["angle"]
        if input_ == "MSTOP":
            assert sim.ioctl(client, mcdef.MSTOP) == 0
        else:
            add_input(sim, input_, value)
            if input_ == "estop":
                add_input(sim, input_, 0, 0.001)
        sim.run(sim.time + 0.4)
        moved = abs(sim.true(1)["angle"] - before)
        return 57.29578 * moved, bool(sim.stats()["panic_level"])


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
    with moving("arm_move", SAFE, at=0.15) as (sim, _):
        at = sim.time
        add_input(sim, "host_dead", 1)
        sim.run(at + 0.2)
        told = next(n["t"] for n in sim.notes() if n["kind"] == "panic" and n["t"] > at)
        assert 0.008 < told - at < 0.0105
        assert all(sim.true(axis)["current"] == pytest.approx(0, abs=1e-6) for axis in range(6))


@pytest.mark.req("DRV-9")
def test_write_of_the_hosts_library_is_checked():
    """And a setpoint that is changed on its way, or lost, stops the machine."""
    for name, value in (("write_flip", 1 << 20), ("writes_lost", 3)):
        with moving("arm_move", "host.guard_checked=true", at=0.1) as (sim, _):
            assert sim.stats()["enabled"]
            add_input(sim, name, value)
            sim.run(sim.time + 0.05)
            assert not sim.stats()["enabled"]
            assert any("PANIC: setpoints" in n["text"] for n in sim.notes())


@pytest.mark.req("PAN-1")
def test_encoder_that_steps_illegally_is_noticed_at_once():
    """A and B of a moving axis are exchanged: where they differ, both change in one clock."""
    times = (0.1400, 0.1403, 0.1406, 0.1409, 0.1412, 0.1415)
    events = [{"at": at, "input": "encoder_swap", "value": 1, "index": 3} for at in times]
    found = list(seen_of("arm_move", event=events))
    assert [more["by"] for _, more in found] == ["PANIC"] * len(times)
    assert min(seen.detected_s for seen, _ in found) < 1e-4


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
    ((seen, more),) = seen_of(name, "axis.all.ilimax=60", event=[event])
    assert more["by"] == "PANIC" and 1e3 * seen.detected_s < ms, (seen, more)


@pytest.mark.req("DRV-9")
def test_gains_of_an_axis_that_is_on_are_refused():
    call = {"at": 0.1, "request": "MSETPARAM", "axis": 5, "set": {"a0": 3}}
    ((_, more),) = seen_of("arm_move", call=[call])
    assert more["by"] == "MSETPARAM refused"


@pytest.mark.req("PAN-3")
def test_wrist_whose_amplifier_is_stuck_does_not_coast():
    """J6 has no brake: what PANIC cuts off alone goes on turning."""
    turned = []
    for cut in ("brakes first", "dynamic brake"):
        stuck = "event=[{at=0.1, input='amp_saturated', index=5, value=1}]"
        sets = (SAFE, f"amp_panic_cut='{cut}'", "duration=0.4", stuck)
        with moving("puma560_hold", *sets, at=0.4) as (sim, _):
            assert sim.stats()["panic_level"] and sim.notes()
            turned.append(57.29578 * abs(sim.true(5)["angle"]))
    assert turned[0] > 5 and turned[1] < 2, turned
