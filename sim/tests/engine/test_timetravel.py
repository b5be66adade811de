# SPDX-License-Identifier: Apache-2.0
"""Snapshots: whoever goes back gets the same future, to the bit. MMCS_LONG=1 for 1,000 ticks."""

import os
import random
import re
import runpy

import machines
import pytest
from machines import event, everything, input_number, machine, notes, start

from mmcs import ROOT, load, mcdef, regs
from mmcs import machine as machine_of

pytestmark = pytest.mark.req("API-1")
LONG = os.environ.get("MMCS_LONG") == "1"
SEED = int(os.environ.get("MMCS_SEED", "5"))


def busy(sim):
    """A machine on which everything that holds a state is at work; returns its client."""
    client = start(sim)
    event(sim, 0.0, "pot_noise", 0.05)
    event(sim, 0.0, "encoder_glitch", 200.0)
    event(sim, 0.02, "host_stall", 4.0)
    event(sim, 0.03, "bus_error", 2)
    event(sim, 0.06, "estop", 1, 0)
    event(sim, 0.07, "estop", 0, 0)
    table = [10 * (n % 7) for n in range(40)]
    sim.add_segment(axis=0, kind="sine", t0=0.001, duration=5.0, to=50, amplitude=50, f0=7.0)
    sim.add_segment(axis=1, kind="table", t0=0.0, duration=0.05, table=table)
    sim.start_motion(client)
    return client


def arm(sim):
    client = start(sim)
    for axis in range(sim.axes):
        for n in range(10):  # so short that a detour ends in another one
            sim.add_segment(axis=axis, kind="quintic", t0=2e-3 * n, duration=2e-3, to=90 * n + 90)
    sim.start_motion(client)
    return client


# --- in memory ---------------------------------------------------------------------------------


CASES = {
    "busy": (machine, busy, 700 if LONG else 40),
    "coupled arm": (lambda: machine_of(load("puma560")), arm, 300 if LONG else 10),
}


def test_machines_end_in_any_order():
    """One that ended before must leave nothing behind that another one trips over."""
    for _ in range(5):
        with machine_of(load("lab500")) as first:
            with machine_of(load("lab500")) as second:
                second.run(0.001)
            with machine_of(load("lab500")):
                pass
            first.run(0.001)


@pytest.mark.parametrize("case", CASES)
def test_round_trip_at_random_ticks(case):
    """Every detour into the future and back leaves the run as one that never left: also what a
    process did there."""
    make, prepare, ticks = CASES[case]
    print(f"seed {SEED}")
    rng = random.Random(SEED)
    steps = [rng.uniform(1e-6, 3e-3) for _ in range(ticks)]
    with make() as straight, make() as detoured:
        prepare(straight)
        prepare(detoured)
        for n, step in enumerate(steps):
            goal = straight.time + step
            assert straight.run(goal) and detoured.run(goal)
            number = detoured.snapshot()
            detoured.open(mcdef.O_RDONLY)
            detoured.write(0, [300])
            event(detoured, rng.uniform(0, 4e-3), "estop", 1)
            detoured.run(goal + rng.uniform(0, 4e-3))
            detoured.restore(number)
            assert everything(detoured) == everything(straight), f"tick {n} at {goal} s"
            detoured.drop(number)


def test_snapshot_at_an_instant_in_the_middle_of_the_firmware():
    """It is then of the last instant before; replayed forward it passes the one asked for."""
    with machine(latency_max_us=0.0) as sim:
        start(sim)
        sim.run(sim.time + 0.01)
        sample = sim.clock  # some instant; the passes of 1 ms intervals take about 0.2 ms
        seen = set()
        for n in range(40):
            asked = (sample + n * 8400) / 8e6
            number = sim.snapshot(asked)
            taken = next(s for s in sim.snapshots() if s["id"] == number)
            early = round(asked * 8e6) - taken["clock"]
            assert 0 <= early < 8000 and len(sim.snapshots()) == n + 1
            seen.add(early > 0)
            after = sim.clock, sim.hash()
            sim.restore(number)
            sim.run(asked)
            assert (sim.clock, sim.hash()) == after
        assert seen == {True, False}


# --- as bytes ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("first", "then"), [
    ("speed", "speed"), ("speed", "trust"), ("speed", "trace"), ("trust", "speed"),
    ("trace", "trust"),
])  # fmt: skip
def test_bytes_continue_in_another_machine(first, then):
    """Of the same build or of another: upset, faults that stand or are on their way, a strange seed
    are all in the snapshot."""
    with machine(kind=first, seed=77) as sim:
        busy(sim)
        for after, name, value in ((0.01, "seu_dac_input", 64), (0.02, "irq_lost", 1),
                                   (0.021, "adc_stuck", 1), (0.022, "dac_stuck1", 8),
                                   (0.023, "panic_open", 1), (0.024, "dip_xor", 2),
                                   (0.0251, "irq_lost", 0), (0.026, "adc_stuck", 0),
                                   (0.027, "dip_xor", 0), (0.031, "seu_heartbeat", 1)):  # fmt: skip
            event(sim, after, name, value)
        sim.snapshot(sim.time + 0.025)
        state = sim.snapshot_bytes(sim.snapshots()[-1]["id"])
        goal = sim.time + 0.03
        assert sim.run(goal)
        past, expected = sim.history_bytes(), (sim.hash(), sim.log().tobytes(), sim.checkpoints())
    with machine(kind=then, seed=77) as other:
        other.restore_bytes(state, past)
        assert other.run(goal), notes(other, "assert")
        assert (other.hash(), other.log().tobytes(), other.checkpoints()) == expected


@pytest.mark.parametrize("first", ["speed", "trust"])
def test_bus_checkers_begin_anew_after_a_way_back(first):
    """Into the middle of a command on the PC bus, of which they know nothing: no false alarm. From
    the next idle bus on they see what is wrong."""
    card, other = (regs.card_offset(number, regs.CARD_DAC1_HI) for number in (0, 1))
    taken = []
    with machine(kind=first) as sim:
        sim.bus_write(regs.PCCSR, 0xF8)
        for clocks in range(12):
            event(sim, 0.0, "bus_error", 1)
            with pytest.raises(OSError, match="bus"):
                sim.bus_write(card, 0x80)  # BERR* ends it; the PC bus goes on
            assert sim.run((sim.clock + clocks - 0.5) / machines.CLK_HZ)
            taken.append((sim.snapshot_bytes(sim.snapshot()), sim.history_bytes()))
            assert sim.run((sim.clock + 100) / machines.CLK_HZ)
    seen = []
    with machine(kind="trust") as sim:
        a_q = "seu.u_adaptor.u_core.u_master.a_q"
        for number, snapshot in enumerate(taken):
            sim.bus_write(regs.PCCSR, 0xF8)
            sim.bus_read(other)
            sim.restore_bytes(*snapshot)
            assert sim.run((sim.clock + 40) / machines.CLK_HZ), (number, notes(sim, "assert"))
            sim.add_event((sim.clock + 8) / machines.CLK_HZ, input_number(sim, a_q), 0, 1)
            sim.bus_write(card, 0x80)
            assert sim.run((sim.clock + 40) / machines.CLK_HZ)
            seen += [note["text"] for note in notes(sim, "assert")][-1:]
    assert len(seen) == len(taken) and all("u_pcbus_checker" in text for text in seen), seen


def test_the_digest_is_of_every_source():
    """Two builds that differ in a file of the model, the engine, the plant or the driver have other
    digests: a snapshot of one is none of the other."""
    made = runpy.run_path(str(ROOT / "sim" / "model" / "digest.py"))["sources"](ROOT)
    folders = ("sim/abi", "sim/model", "sim/engine", "sim/plant", "firmware/mc")
    files = [p for folder in folders for p in (ROOT / folder).iterdir()]
    named = {str(p.relative_to(ROOT)) for p in files if p.suffix in (".c", ".cpp", ".h")}
    assert named <= set(made)


def test_foreign_or_damaged_bytes_are_refused_and_change_nothing():
    with machine() as sim:
        early = sim.history_bytes(), (busy(sim), sim.run(sim.time + 0.002)) and sim.history_bytes()
        sim.run(sim.time + 0.01)
        state, past = sim.snapshot_bytes(sim.snapshot()), sim.history_bytes()
        before = everything(sim)
        build = sim.build_id().encode()
        cases = {
            "not a snapshot": [b"", state[:40], b"x" * 4000, past],
            "damaged": [state[:-1], state + b"\0", state[:600] + b"\x55\xaa" + state[602:]],
            "another build": [state.replace(build, b"c9 0123456789abcdef"[: len(build)], 1)],
        }
        for reason, bad in cases.items():
            for data in bad:
                with pytest.raises(ValueError, match=reason) as refusal:
                    sim.restore_bytes(data, past)
                assert "\n" not in str(refusal.value)
                with pytest.raises(ValueError, match="not a snapshot|damaged|another build"):
                    sim.restore_bytes(state, data if data != past else state)
        for history, what in zip(early, ("notes", "log"), strict=True):
            with pytest.raises(ValueError, match=f"the snapshot lacks its {what}"):
                sim.restore_bytes(state, history)
        assert everything(sim) == before
        sim.restore_bytes(state, past)
        assert sim.snapshots() == []
    for other in (
        {"seed": 9}, {"motor": {"gear": 2.0}}, {"latency_max_us": 1.0}, {"amp_panic_cut": 1},
        {"axes": 1}, {"cpu_us_per_axis": 1.0}, {"bus_timeout_us": 17.0}, {"gravity": [0, 0, 1.0]},
    ):  # fmt: skip
        with machine(**other) as sim, pytest.raises(ValueError, match="belongs to another machine"):
            sim.restore_bytes(state, past)
    heavy = load("puma560_coupled")
    heavy.robot.link[1].mass *= 2
    with machine_of(load("puma560_coupled")) as sim, machine_of(heavy) as other:
        state = sim.snapshot_bytes(sim.snapshot()), sim.history_bytes()
        with pytest.raises(ValueError, match="belongs to another machine"):
            other.restore_bytes(*state)


# --- bad arguments -----------------------------------------------------------------------------

# Calls one after the other on a machine of two axes at 10 ms: what each gives there, and what
# without a machine. `out` is room to write to, `name` a text, other words are NULL.
CALLS = """
run nan: -1 -1; run 1e300: -1 -1; run -1e9: 0 -1; run -1.1e9: -1 -1; run_to -1 0: -1 -1
run_to 0 0: 0 -1; add_event no: -1 -1; add_segment no no: -1 -1; start_motion -1: -9 -9
start_motion 16: -9 -9; start_motion 15: 0 -9; open 3: -22 -6; close 55: -9 -9; close -1: -9 -9
ioctl -1 0 no: -9 -9; read 77 no 4: -9 -9; write 0 no 4: -9 -9; stop: 0 -5; signals -3: 0 0
bus_read 1033 45 1 no: -1 -1; bus_read 1033 45 3 out: -1 -1; bus_read 1033 45 1 out: 0 -1
bus_write 1033 45 3 0: -1 -1; bus_write 1033 45 0 0: -1 -1; bus_write 1033 45 8 0: -1 -1
bus_write 3081 45 1 24: 0 -1; bus_write 8 45 1 0: 1 -1; bus_cycles no: 0 0; bus_cycles out: 0 0
clock: 80157 0; restore 12345: -1 -1; drop -1: -1 -1; ring -1e-9 3: -1 -1; ring nan 3: -1 -1
ring 0.1 -1: -1 -1; ring 0 0: 0 -1; snapshot inf: -1 -1; snapshot nan: -1 -1; snapshot 1e10: -1 -1
snapshot -1: 0 -1; snapshot_bytes 0 no: -1 -1; snapshot_bytes 7 out: -1 -1; history_bytes no: -1 -1
snapshots no: 0 0; snapshots out: 1 0; known: 80157 -1; restore_bytes no 0 no 0 no 0: -1 -1
copy no: -1 -1; again no 1: -1 -1; repeat no 0 1: -1 -1; trace no 0 1: -1 -1; trace name 1 1: -1 -1
trace name 2 1: -1 -1; trace name nan 1: -1 -1; trace name 0 nan: -1 -1; watch no: -1 -1
watch name: -1 -1; changes no: 0 0; changes out: 0 0; notes no: 0 0; notes out: 1 0
checkpoints no: 0 0; checkpoints out: 0 0; true 2 out: -1 -1; true -1 out: -1 -1; true 1 out: 0 -1
caches out 0: 5 0; phases out 9: 0 0; input_value -1 0 0: 0 0; input_value 9999 0 0: 0 0
register -1: 0 0; register 99999: 0 0; samples: 0 0; axes: 2 0; tap -1 0: -1 -1; tap 0 -1: -1 -1
tap 16777217 1: -1 -1; tap 1 16777217: -1 -1; tap 4 4: 0 -1; tap_head no: -1 -1; tap_head out: 0 -1
tap_rows 0 1 out 0 out: 0 -1; tap_rows 0 1 no 0 out: 0 -1; tap_rows 0 1 no 1 out: -1 -1
tap_rows -1 1 out 1 out: -1 -1; tap_rows 0 0 out 1 out: -1 -1; tap_rows 0 1 out -1 out: -1 -1
tap_rows 0 1 out 1 no: -1 -1; tap_events 0 out 1 out: 0 -1; tap_events 0 no 0 out: 0 -1
tap_events 0 no 1 out: -1 -1; tap_events -1 out 1 out: -1 -1; tap_events 0 out -1 out: -1 -1
tap_events 0 out 1 no: -1 -1; tap_note no 0 0 name: -1 -1; tap_note name 0 0 no: -1 -1
tap_note name 0 0 name: 0 -1; set_look no no: 0 -1; trace name 0 1: -1 -1; trace name 1 2: 0 -1
"""


def test_calls_refuse_what_is_impossible_and_nothing_else():
    with machine() as sim:
        assert sim.run(0.01)
        lib, ffi = sim.lib, sim.ffi
        room = {"out": ffi.new("char[]", 4096), "name": ffi.new("char[]", b"name")}
        for handle, column in ((sim.handle, 0), (ffi.NULL, 1)):
            for call in re.split(r"[;\n]+", CALLS.strip()):
                words, _, expected = call.partition(": ")
                name, *given = words.split()
                function = getattr(lib, f"mmcs_sim_{name}")
                arguments = [
                    ffi.cast(kind, room.get(word, ffi.NULL)) if kind.kind in ("pointer", "function")
                    else float(word) if kind.cname == "double" else int(word)
                    for kind, word in zip(ffi.typeof(function).args[1:], given, strict=True)
                ]  # fmt: skip
                assert function(handle, *arguments) == int(expected.split()[column]), call
        assert lib.mmcs_sim_log(ffi.NULL, ffi.NULL, ffi.NULL) == ffi.NULL
        assert lib.mmcs_sim_hash(ffi.NULL) == lib.mmcs_sim_register_width(-1) == 0
        for function in (lib.mmcs_sim_input_name, lib.mmcs_sim_input, lib.mmcs_sim_register_name):
            assert function(-1) == function(9999) == ffi.NULL != function(0)
        assert lib.mmcs_sim_restore_bytes(ffi.NULL, *[ffi.NULL, 0] * 2, room["out"], 6) == -1
        assert ffi.string(room["out"]) == b"no si"
        lib.mmcs_sim_get_stats(sim.handle, ffi.NULL)
        lib.mmcs_sim_destroy(ffi.NULL)


# --- what decides the future -------------------------------------------------------------------


def test_future_is_equal_where_only_the_past_differs():
    """An upset that is gone leaves counts and hashes different, and nothing that will matter."""
    with machine() as sim:
        start(sim)
        sim.run(sim.time + 0.02)
        began, id_ = sim.time, sim.snapshot()
        plain = [sim.future() for n in range(8) if sim.run(began + 0.001 * n)]
        end = sim.hash()
        assert len(set(plain)) == len(plain)  # time is part of it
        sim.restore(id_)
        path = "seu.g_card[0].u_card.g_axis[0].u_axis.u_encoder.snap_q"
        sim.add_event(began + 1e-6, input_number(sim, path), 0, 1 << 5)
        seen = [sim.future() for n in range(8) if sim.run(began + 0.001 * n)]
        assert seen[0] != plain[0] and seen[2:] == plain[2:]
        assert sim.hash() == end  # nothing of it was read
        sim.restore(id_)
        event(sim, 5e-4, "host_stall", 0.01)
        seen = [sim.future() for n in range(8) if sim.run(began + 0.001 * n)]
        assert seen[0] != plain[0] and seen[2:] == plain[2:]
        sim.restore(id_)
        event(sim, 1e-6, "bus_error", 1)
        seen = [sim.future() for n in range(8) if sim.run(began + 0.001 * n)]
        assert seen[7] != plain[7]  # the driver has stopped
        sim.restore(id_)
        event(sim, 0.5, "estop", 1)
        assert sim.future() not in plain  # what is still to come
        sim.restore(id_)
        assert sim.future() == plain[0]


# --- what is done to one, done to another --------------------------------------------------------


def test_deeds_lead_another_machine_the_same_way():
    """Requests, also refused ones, bus cycles, events, motions; with some left out it differs."""
    rng = random.Random(1989)
    with machine() as sim, machine() as other:
        client = start(sim)
        sim.run(sim.time + 0.002)
        lib, begun = sim.lib, sim.clock
        lib.mmcs_sim_keep_deeds(sim.handle)
        sim.snapshot()
        deeds = [
            lambda: sim.write(client, [rng.randrange(-500, 500), 7]),
            lambda: sim.read(client),
            lambda: sim.ioctl(client, mcdef.MSETENC, mcdef.new_int(rng.randrange(2))),
            lambda: sim.ioctl(client, mcdef.MSETINTERVAL, mcdef.new_int(3)),
            lambda: sim.ioctl(client, mcdef.MENABLE),
            lambda: lib.mmcs_sim_stop(sim.handle),
            lambda: sim.bus_read(0x001),
            lambda: sim.bus_write(0x041, rng.randrange(256)),
            lambda: [sim.bus_read(0x001) for _ in range(2000)],  # interrupts rise within them
            lambda: event(sim, sim.time + 0.0005, "pot_noise", rng.random()),
            lambda: sim.close(sim.open(mcdef.O_RDONLY)),
        ]
        sim.add_segment(axis=1, kind="table", t0=0.0, duration=0.05, table=[0, 40, 10])
        sim.start_motion(client)
        clocks = []
        for deed in deeds + rng.choices(deeds, k=40):
            clocks.append(sim.clock)
            deed()
            sim.run(sim.time + rng.randrange(3) / 1000)
        kept = sim.snapshot()
        sim.write(client, [900, 9])  # which is undone
        sim.restore(kept)
        sim.drop(kept)
        assert lib.mmcs_sim_known(sim.handle) == begun
        assert lib.mmcs_sim_again(other.handle, sim.handle, begun - 1) == -1
        assert lib.mmcs_sim_again(other.handle, sim.handle, sim.clock) == 0
        assert other.future() == sim.future()
        assert lib.mmcs_sim_again(other.handle, sim.handle, clocks[0]) == 0
        assert lib.mmcs_sim_repeat(other.handle, sim.handle, clocks[12], sim.clock) == 0
        assert other.future() != sim.future()
        assert lib.mmcs_sim_copy(other.handle, sim.handle) == 0
        assert other.future() == sim.future() and len(sim.snapshots()) == 1
