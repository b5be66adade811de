# SPDX-License-Identifier: Apache-2.0
"""mmcs campaign: each class of fault is known where it must be, and every claim can be repeated."""

import json
import shlex
from collections import Counter

import numpy as np
import pytest

from mmcs import ROBOTS, expect_plant, load, simulate
from mmcs.inputs import INPUTS
from mmcs.sweeps import stops
from mmcs.sweeps import twin as twins
from mmcs.sweeps.campaign import make_plan, run_fault, twin_of
from mmcs.sweeps.campaign_report import how_far
from mmcs.sweeps.classes import CLASSES, DANGEROUS, HARMLESS, LATE, MASKED, NEAR, SAFE
from mmcs.sweeps.faults import KILLS, LINES, MESSAGES, PINS, SORTS, Fault
from mmcs.sweeps.store import ROWS
from mmcs.sweeps.twin import Twin
from mmcs.tests.conftest import cluster, good, one_clear_line

CARD, AXIS = "seu.g_card[1].u_card", "seu.g_card[1].u_card.g_axis[0].u_axis"
SIZE = 100
ROW = {"status": "ok", "class": MASKED, "motion": "m", "sort": "pin", "what": "w", "at": 0.1,
       "lasts": True, "off": 0.0, "beyond": 0.0, "deg": 0.0, "after_ms": None,
       "by": "", "told": ""}  # fmt: skip


@pytest.fixture(scope="module")
def plan():
    return make_plan(("arm_move", "puma560_hold"), SORTS, 1)


@pytest.fixture(scope="module")
def rows(plan):
    """A small campaign, every fault once."""
    return [run_fault(twin_of(plan.setups[f.motion]), f) for f in map(plan.fault, range(SIZE))]


def one(plan, motion, entry):
    kind = "call" if "request" in entry else "event"
    fault = Fault(0, motion, "pin", "test", entry["at"], **{kind: entry})
    return run_fault(twin_of(plan.setups[motion]), fault)


# --- classes -----------------------------------------------------------------------------------


KNOWN = [
    # (motion, what happens, class)
    ("arm_move", {"at": 0.1, "input": f"{AXIS}.u_encoder.snap_q", "value": 64}, MASKED),
    ("arm_move", {"at": 0.1, "input": f"{AXIS}.u_adc.next_q", "value": 1}, MASKED),
    ("puma560_hold", {"at": 0.1, "input": "encoder_swap", "index": 4, "value": 1, "until": 0.1001},
     MASKED),
    ("arm_move", {"at": 0.1, "input": "estop", "value": 1}, SAFE),
    ("arm_move", {"at": 0.2, "input": "pc_power", "value": 0}, SAFE),
    ("puma560_hold", {"at": 0.1, "input": "cable", "value": 0}, SAFE),
    # a PANIC that passes: the brakes open again, and nobody drives J2
    ("puma560_hold", {"at": 0.1, "input": "estop", "value": 1, "until": 0.1005}, LATE),
    ("puma560_hold", {"at": 0.2, "input": "sysreset", "value": 1, "until": 0.201}, LATE),
    # D/As are written to nobody, and keep their last torque until the heartbeats end
    ("arm_move", {"at": 0.1, "input": "host_dead", "value": 1}, LATE),
    ("arm_move", {"at": 0.1, "input": "index_missing", "index": 2, "value": 1}, HARMLESS),
    ("arm_move", {"at": 0.1, "input": f"{CARD}.u_ppi.inte_q", "value": 1}, HARMLESS),
    ("puma560_hold", {"at": 0.1, "input": "panic_open", "index": 0, "value": 1}, HARMLESS),
    ("arm_move", {"at": 0.1, "input": f"{AXIS}.u_encoder.count_q", "value": 512}, DANGEROUS),
    ("arm_move", {"at": 0.1, "input": "encoder_swap", "index": 4, "value": 1}, DANGEROUS),
    ("arm_move", {"at": 0.05, "input": "motor_jam", "index": 0, "value": 1}, DANGEROUS),
    ("arm_move", {"at": 0.1, "input": "writes_lost", "value": 1000}, DANGEROUS),
    ("arm_move", {"at": 0.1, "input": "pc_d_stuck1", "value": 64}, DANGEROUS),
    ("puma560_hold", {"at": 0.1, "input": "amp_dead", "index": 1, "value": 1}, DANGEROUS),
    ("arm_move", {"at": 0.1, "request": "MSETPARAM", "axis": [3], "set": {"ic_pos": 2000}},
     DANGEROUS),
    ("arm_move", {"at": 0.1, "request": "MZEROSTATS"}, HARMLESS),
]  # fmt: skip


@pytest.mark.req("SW-1")
@pytest.mark.parametrize(("motion", "entry", "name"), KNOWN)
def test_known_faults_get_their_class(plan, motion, entry, name):
    row = one(plan, motion, entry)
    assert row["class"] == name, row


def test_detection_is_told_with_its_time_and_its_means(plan):
    row = one(plan, "arm_move", {"at": 0.1, "input": "estop", "value": 1})
    assert row["by"] == "PANIC" and 0 <= row["after_ms"] < 0.01
    row = one(plan, "arm_move", {"at": 0.1, "input": "host_stall", "value": 1000.0})
    assert row["by"] == "PANIC" and 40 < row["after_ms"] < 51  # the heartbeats


# --- a small campaign --------------------------------------------------------------------------


def test_small_campaign_finds_every_class(rows):
    found = Counter(row["class"] for row in rows)
    assert set(found) == set(CLASSES), found
    far = [row["deg"] for row in rows if row["class"] in (LATE, DANGEROUS)]
    table = "\n".join(how_far(rows))
    assert min(far) > 0.01 and max(far) > 5 and f"| {DANGEROUS}, per million | " in table
    assert all(row["off"] <= NEAR for row in rows if row["class"] in (MASKED, HARMLESS))


def test_what_ends_early_would_have_gone_as_the_twin(plan, rows):
    """A run that is cut short as masked, made to its end, is the twin to the bit."""
    masked = [n for n, row in enumerate(rows) if row["class"] == MASKED]
    assert len(masked) >= 10
    for n in masked[:10]:
        fault = plan.fault(n)
        twin = twin_of(plan.setups[fault.motion])
        row = run_fault(twin, fault, whole=True)
        assert twin.sim.future() == twin.futures[-1]
        assert {k: row[k] for k in ("class", "off")} == {k: rows[n][k] for k in ("class", "off")}


def test_a_stop_that_ends_at_rest_would_have_gone_no_further(plan, monkeypatch):
    twin, places = twin_of(plan.setups["arm_move"]), (0, 33, 66)
    short = [[*twin._stop(place)] for place in places]
    monkeypatch.setattr(twins, "PROMISE_S", 10.0)  # longer than the motion
    monkeypatch.setattr(twin, "_stops", {})
    assert np.array_equal(short, [[*twin._stop(place)] for place in places])


def test_order_does_not_matter(plan, rows):
    """What a fault has left in the machine is gone before the next one."""
    for n in (SIZE - 1, 7, 42, 0):
        fault = plan.fault(n)
        assert run_fault(twin_of(plan.setups[fault.motion]), fault) == rows[n]


@pytest.mark.req("API-1")
@pytest.mark.parametrize("name", CLASSES)
def test_example_of_each_class_is_made_again_by_the_command_it_prints(
    plan, rows, mmcs, tmp_path, name
):
    n = next(n for n, row in enumerate(rows) if row["class"] == name)
    fault = plan.fault(n)
    fresh = Twin(plan.setups[fault.motion])  # one that has yet to press the button beside it
    row = run_fault(fresh, fault, whole=True)
    fresh.close()
    command = shlex.split(plan.command(n))
    assert command[0] == "mmcs"
    status, out, err = mmcs(*command[1:], "--out", tmp_path / "run")
    assert status in (0, 1), err
    assert json.loads((tmp_path / "run" / "report.json").read_text())["hash"] == row["hash"]
    status, out, _ = mmcs("replay", tmp_path / "run")
    assert status == 0 and row["hash"] in out


def kept(folder):
    """What the file of rows holds, line by line."""
    return [json.loads(line) for line in (folder / ROWS).read_text().splitlines()[1:]]


def campaign(mmcs, folder, count, *more):
    arguments = ("--faults", count, "--seed", 1, "--out", folder, *more)
    return mmcs("campaign", "arm_move", "puma560_hold", *arguments)


@pytest.mark.slow  # four workers start, each with twins of its own
def test_rows_depend_on_nothing_but_the_plan(mmcs, rows, tmp_path):
    """Nor on the number of workers, nor on a stop half-way."""
    half, stopped = SIZE // 2, SIZE // 3
    good(campaign(mmcs, tmp_path / "a", half, "--workers", 2))
    lines = (tmp_path / "a" / ROWS).read_text().splitlines(keepends=True)
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / ROWS).write_text("".join(lines[: stopped + 1]) + lines[stopped + 1][:20])
    out = good(campaign(mmcs, tmp_path / "b", half, "--workers", 1, "--resume"))
    assert out.startswith(f"{half - stopped} faults in")
    for folder in "ab":
        found = {line["n"]: line["row"] for line in kept(tmp_path / folder)}
        assert [found[n] for n in range(half)] == rows[:half]
    reports = [(tmp_path / folder / "report.md").read_bytes() for folder in "ab"]
    assert reports[0] == reports[1]
    text = reports[0].decode()
    headings = ["By sort", "What stays undetected", "How far"]
    assert [h for h in headings if f"\n## {h}\n" in text] == headings
    for name in CLASSES:
        share = sum(row["class"] == name for row in rows[:half])
        assert f"* **{name}**" in text and f" {share:,} |" in text
    answer = campaign(mmcs, tmp_path / "b", half, "--resume", "--sort", "pin")
    one_clear_line(answer, "is another campaign")


@pytest.mark.slow  # a scheduler and a worker start
def test_same_rows_from_dask(mmcs, plan, tmp_path):
    with cluster(1) as one_worker:
        good(campaign(mmcs, tmp_path, 12, "--dask", one_worker.scheduler_address))
    here = [run_fault(twin_of(plan.setups[f.motion]), f) for f in map(plan.fault, range(12))]
    assert {line["n"]: line["row"] for line in kept(tmp_path)} == dict(enumerate(here))


def test_chunk_that_fails_is_run_fault_by_fault(mmcs, tmp_path, monkeypatch):
    """One impossible fault takes no other one along."""

    def here(tasks, workers, work):
        for numbers, (_, faults) in tasks:
            bad = 5 in numbers
            names = "motion", "sort", "at", "what"
            rows = [ROW | {name: getattr(f, name) for name in names} for f in faults]
            yield numbers, {"status": "failed", "why": "no"} if bad else {"rows": rows}

    monkeypatch.setattr("mmcs.sweeps.workers.run_here", here)
    status, out, _ = campaign(mmcs, tmp_path, 20)
    assert status == 1 and "1 of 20 faults could not be run" in out
    lines = kept(tmp_path)
    assert sorted(line["n"] for line in lines) == list(range(20))
    assert [line["n"] for line in lines if line["row"]["status"] == "failed"] == [5]


# --- what is drawn -----------------------------------------------------------------------------


def test_every_input_has_its_sort_and_values():
    drawn = {name for name, i in INPUTS.items() if i.draw != "none" and i.made_by != "UPSET"}
    assert {*PINS, *LINES, *KILLS, *MESSAGES} == drawn
    for i in (INPUTS[name] for name in drawn):
        values = i.drawn() or [float(v) for v in i.draw.split()[0].split("..")]
        assert all(i.low <= value <= i.high for value in values), i


def test_every_fault_drawn_is_one_that_a_scenario_takes(plan):
    from mmcs.scenario.files import Files
    from mmcs.scenario.setup import make_setup

    files = Files()
    for n in range(600):
        fault, data = plan.fault(n), dict(plan.setups["arm_move"].data)
        data |= {"event": [fault.event]} if fault.event else {"call": [fault.call]}
        make_setup(plan.setups["arm_move"].path, data, files)


# --- ways to stop ------------------------------------------------------------------------------


def test_stops_are_those_of_whole_runs(mmcs, tmp_path, monkeypatch):
    """The worst degrees after the button and after MSTOP, by runs that know nothing of snapshots;
    and an own robot file moves as others with as many axes."""
    monkeypatch.setattr(stops, "MOMENTS", 4)
    worst = {}
    for n in range(4):
        at = 0.1 * n
        for way, key, entry in (("button", "event", 'input = "estop", value = 1'),
                                ("MSTOP", "call", 'request = "MSTOP"')):  # fmt: skip
            sets = ("duration=1.0", "expect=[]", f"{key}=[{{at = {at}, {entry}}}]")
            result = simulate(load("lab500", *sets))
            worst[way] = max(worst.get(way, 0.0), expect_plant.moved_deg(result, 0, at))
    own = tmp_path / "own.toml"
    own.write_text((ROBOTS / "lab500.toml").read_text())
    for robot in ("lab500", str(own)):
        out = good(mmcs("campaign", robot, "--stops", "--workers", 1, "--out", tmp_path / "out"))
        table = stops_of("\n".join(line for line in out.splitlines() if line.startswith("|")))
        assert set(stops.WAYS) < set(table) and "left out: user_loop: it has a [[process]]" in out
        for way in stops.WAYS:
            degrees, counts = (float(cell.strip("≥ ")) for cell in table[way][1:3])
            assert degrees >= worst.get(way, 0.0) - 0.1, (way, table)
            assert counts == pytest.approx(degrees * 2000 / 360, abs=0.8), (way, table)
        assert "≥" in table["host dead"][1], "a bench motor has no brake: it goes on"
        assert table == stops_of((tmp_path / "out" / "report.md").read_text())


def stops_of(text):
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines()]
    return {row[0]: row for row in rows}
