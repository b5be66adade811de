# SPDX-License-Identifier: Apache-2.0
"""The simulator core: time, bus, interrupts, determinism, and one motor that moves."""

import os
import random
import sys
import zlib

import pytest
from machines import event, machine, start, step_to

from mmcs import ROOT, RunError, load, mcdef, regs, simulate
from mmcs.inputs import INPUTS
from tools.compiled import ran

STEP = 200


def run_step(seconds=0.15, counts=STEP, **config):
    with machine(**config) as sim:
        client = start(sim)
        step_to(sim, client, counts)
        assert sim.run(sim.time + seconds)
        return sim.hash(), sim.stats(), sim.log()


# --- determinism -------------------------------------------------------------------------------


@pytest.mark.req("API-1")
def test_a_machine_knows_what_the_one_before_it_learned(monkeypatch):
    """Transitions stay in the process; each hit of another machine is compared with the model."""
    setup = load("puma560_velocity")
    first = simulate(setup).hash
    assert simulate(setup).hash == first
    monkeypatch.setenv("MMCS_CHECK", "1")
    assert simulate(setup).hash == first


# Passes at any time, so that conversions end within bus cycles; of some seeds with the axes off.
PASSES = """
from machines import ioctl, machine, start
for seed in range(1, 20):
    with machine(seed=seed, latency_max_us=20.0) as sim:
        client = start(sim)
        if seed % 2:
            ioctl(sim, client, "MSTOP")
        assert sim.run(sim.time + 0.1), seed
"""


def test_each_bus_cycle_as_one_step_is_that_of_its_clocks():
    """In a process whose cache has met nothing else."""
    env = {**os.environ, "MMCS_CHECK": "1", "PYTHONPATH": f"{ROOT}:{ROOT}/sim/tests/engine"}
    done = ran(sys.executable, "-c", PASSES, env=env)
    assert done.returncode == 0, done.stderr


@pytest.mark.req("API-1")
def test_a_bus_cycle_is_one_step():
    """Nearly all are, once they have been seen; each takes some ten evaluations otherwise."""
    with machine() as sim:
        client = start(sim)
        step_to(sim, client, STEP)
        assert sim.run(sim.time + 0.05)
        before = sim.stats()
        assert sim.run(sim.time + 0.1)
        made = {name: sim.stats()[name] - before[name] for name in ("evals", "bus_cycles")}
        assert made["bus_cycles"] > 500
        assert made["evals"] < 5 * made["bus_cycles"], made


# Of scenarios without a fault, and with faults of every part of the machine.
RESULTS = {
    "lab500": "ba750e5d", "adda_filter": "2ba1d630", "lab500_torque": "b286b0bc",
    "user_loop": "568e4d11", "arm_move": "a4cc731a", "arm_calibrate": "e4ff4d87",
    "puma560_coupled": "5af01e47", "puma560_velocity": "33e4032d", "puma560_calibrate": "f12eceb1",
    "puma560_bounce": "7dde078e", "puma560_double_buffer": "f18f9a99", "puma560_reach": "36090e35",
    "fault_estop": "6e7884da", "fault_bus_errors": "0d64a766", "fault_encoder_glitch": "ad643410",
    "fault_encoder_slip": "f0b01d40", "fault_seu_encoder": "ae5ee11b",
    "fault_seu_heartbeat": "0bd62671", "fault_host_stall": "b33b778a",
    "fault_brake_stuck_on": "795618f9", "fault_irq_lost": "d0f4ec48", "fault_cable": "fc65b307",
    "fault_late_interrupt": "7d79b5f8", "fault_pot_noise": "a52df3eb", "fault_sysreset": "c9476c11",
    "fault_card_absent": "cf1a7219", "fault_motor_jam": "55488b81", "fault_dip_swapped": "a5f29784",
    "fault_dac_bit": "2532bc3d", "fault_index_stuck": "a9043936",
}  # fmt: skip


@pytest.mark.req("API-1")
@pytest.mark.parametrize("name", RESULTS)
def test_results_are_as_ever(name):
    """To the bit, all that a run tells. Who means to change what is simulated puts the new digests
    here."""
    run = simulate(load(name, "skip=true"))
    told = repr((run.hash, run.notes, run.witnesses, run.states, run.checkpoints)).encode()
    digest = zlib.crc32(told + run.log.tobytes() + run.truth.tobytes())
    assert f"{digest:08x}" == RESULTS[name]


# What happens to a machine in the middle of a step: (input, value, from, until).
SEUS = ["seu_encoder", "seu_dac_input", "seu_dac_output", "seu_index_latch", "seu_pccsr"]
LINES = [(name, 1 << n % int(i.high).bit_length())
         for n, (name, i) in enumerate(INPUTS.items()) if i.draw == "bit" and i.sort == "line"
         ]  # fmt: skip
HAPPENS = {
    "nothing": [],
    "upsets": [(name, 1, 0.003 * n + 1e-5, None) for n, name in enumerate(SEUS)],
    "a heartbeat": [("seu_heartbeat", 1, 0.0052, None)],
    "bits held": [("dac_stuck1", 0x15, 0.005, None), ("adc_stuck", 1, 0.02, None)],
    "interrupts lost": [("irq_lost", 1, 0.005, None)],
}
WAYS = {
    "skipping": {},
    "again": {},
    "every clock": {"skip": 0},
    "asserted": {"kind": "trust", "skip": 0},
}


def end_of(events, **way):
    """Hashes of a step of 40 ms to which this happens, also by a way back into the middle of it;
    and the statistics of the first time."""
    with machine(**way) as sim:
        step_to(sim, start(sim), STEP, t0=0.002)
        for name, value, begin, end in events:
            event(sim, begin, name, value)
            if end is not None:
                event(sim, end, name, 0)
        sim.run(sim.time + 0.006)
        id_, until = sim.snapshot(), sim.time + 0.034
        assert sim.run(until)
        hash_, stats = sim.hash(), sim.stats()
        sim.restore(id_)
        assert sim.run(until)
        return {hash_, sim.hash()}, stats


@pytest.mark.req("API-1", "DAC-1", "ADC-1", "INT-1")
@pytest.mark.parametrize("what", HAPPENS)
def test_every_way_to_calculate_a_run_gives_one_hash(what):
    """Skipping what is at rest, or not; with assertions, of which none fails; and far fewer
    evaluations."""
    ends = {way: end_of(HAPPENS[what], **config) for way, config in WAYS.items()}
    assert len(set.union(*(hashes for hashes, _ in ends.values()))) == 1, ends
    skipped, plain = ends["skipping"][1], ends["every clock"][1]
    assert skipped["cycles"] == plain["cycles"] == plain["evals"]
    assert skipped["evals"] * 4 < plain["evals"]
    assert skipped["cache_hits"] > skipped["cache_misses"] and skipped["cache_bytes"] > 0


@pytest.mark.slow
@pytest.mark.req("API-1")
def test_a_held_line_gives_one_hash_by_every_way():
    """Of the buses, for two passes."""
    seen = set()
    for name, value in LINES:
        held = [(name, value, 0.0050512, 0.0073567)]
        hashes = set.union(*(end_of(held, **WAYS[way])[0]
                             for way in ("skipping", "every clock", "asserted")))  # fmt: skip
        assert len(hashes) == 1, name
        seen |= hashes
    assert len(seen) > len(LINES) // 2, "most of them change the run"


@pytest.mark.req("INT-2")
def test_latency_seed_moves_the_interrupt_only():
    """Latency changes when the host comes, not what a double-buffered servo does."""
    (a, _, log_a), (b, _, log_b) = run_step(seed=1), run_step(seed=2)
    assert a != b
    assert (log_a[:, 1] == log_b[:, 1]).all()
    without = run_step(seed=1, latency_max_us=0.0)[0], run_step(seed=2, latency_max_us=0.0)[0]
    assert without[0] == without[1]


# --- the bus -----------------------------------------------------------------------------------


@pytest.mark.req("VME-1", "VME-2", "VME-4", "VME-5", "VME-6", "CSR-1", "API-1")
def test_the_bus_by_hand():
    """What a read gives and takes: a register of the adaptor up to 2 us, a card's 3 us, what nobody
    claims the bus timer's 16 us. An injected bus error is told from that."""
    cases = [(regs.PCCSR, {}, 0x18, 2), (regs.PCCSR, {"am": 0x29}, 0x18, 2),
             (0x408, {"size": 2}, 0xFF18, 2), (regs.VECTOR, {}, 0xFF, 2),  # which is write-only
             (regs.card_offset(5, 0), {}, 0xFF, 3), (regs.card_offset(0, 2), {}, 0xF0, 3),
             (0x008, {}, None, 18), (regs.PCCSR, {"am": 0x3D}, None, 18)]  # fmt: skip
    with machine(bus_timeout_us=16.0) as sim:
        sim.bus_write(regs.PCCSR, 0x18)
        for offset, more, value, most in cases:
            before = sim.clock
            try:
                assert sim.bus_read(offset, **more) == value
            except TimeoutError:
                assert value is None
            assert (16 if value is None else 0.6) <= (sim.clock - before) / 8 <= most
        assert sim.stats()["bus_errors"] == 2
        event(sim, 0.0, "bus_error", 1)
        sim.run(sim.time + 1e-4)
        with pytest.raises(OSError, match="bus error"):
            sim.bus_read(regs.PCCSR)
        assert sim.bus_read(regs.PCCSR) == 0x18


# --- the servo ---------------------------------------------------------------------------------


@pytest.mark.req("PAN-1")
@pytest.mark.parametrize("how", [{"skip": 1}, {"skip": 0}])
def test_a_clock_that_stops_closes_the_brakes(how):
    """By the charge pump, in 10 ms and the brake's delay; the button does it at once."""
    motor = {"brake_torque": 1.0, "brake_delay": 0.001, "brake_release_delay": 0.001}
    for button in (False, True):
        with machine(axes=1, motor=motor, **how) as sim:
            start(sim)
            sim.run(sim.time + 0.05)
            event(sim, 0.0, "load_torque", -0.05)
            event(sim, 0.0, "clock_stop", 1)
            if button:
                event(sim, 0.0005, "estop", 1)
            sim.run(sim.time + 0.0045)
            assert (abs(sim.true(0)["velocity"]) < 0.01) is button
            sim.run(sim.time + 0.015)
            assert abs(sim.true(0)["velocity"]) < 0.01
            angle = sim.true(0)["angle"]
            sim.run(sim.time + 0.1)
            assert sim.true(0)["angle"] == pytest.approx(angle, abs=1e-6)


# --- motions and inputs ------------------------------------------------------------------------


@pytest.mark.req("DRV-2", "DRV-4", "PIT-2")
def test_motions_are_as_ever():
    """Setpoints of random segments, as the driver had them at each interval. Who means to change
    them puts the new digest here."""
    chance, t = random.Random(1989), 0.0
    with machine() as sim:
        client = start(sim)
        for n in range(240):
            to = chance.choice([0, 0, 90, -400.5, 3e9, -3e9])
            sim.add_segment(axis=n % 2, kind=chance.choice(mcdef.SEGMENT_KINDS), t0=t, to=to,
                            duration=chance.choice([0, 0.015, 0.02, 0.05]), amplitude=1e4,
                            f0=chance.choice([40, -40, 25, 333.3]), f1=90.5, table=[3, 90, 40],
                            v_max=chance.choice([0, 9e3]), a_max=n % 3 * 1e6)  # fmt: skip
            t += chance.choice([0, 0.005, 0.02, 0.06])
        with pytest.raises(RunError):
            sim.add_segment(axis=0, kind="table")
        sim.start_motion(client)
        assert sim.run(sim.time + t + 0.1)
        told = sim.log()[:, [0, 1, 8]]
    assert len({*told[:, 1]}) > 400
    assert f"{zlib.crc32(told.tobytes()):08x}" == "6332ed92"


@pytest.mark.req("API-1")
def test_a_motion_that_starts_at_a_sample_has_it_in_the_log():
    first = 0.0  # from the start of the motion on, at the second machine 0
    for _ in range(2):
        with machine() as sim:
            client = start(sim)
            sim.run(sim.time + first)
            sim.start_motion(client)
            sim.run(sim.time + 0.002)
            before, first = first, sim.log()[0][0]
    assert before > 0 and first == 0


FULL = """
import resource, sys
sys.path.insert(0, sys.argv[1])
from machines import machine, start
with machine() as sim:
    start(sim)
    sim.bus_cycles()  # from now on grows with each access, most of them in the handler
    used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (used + (1 << 20), most))
    while sim.run(sim.time + 0.1):
        pass
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    before, notes = sim.stats()["interrupts"], [n["text"] for n in sim.notes()]
    sim.run(sim.time + 0.1)
    print(notes[-1], sim.stats()["interrupts"] - before > 90)
"""


@pytest.mark.req("API-1")
def test_interrupts_go_on_after_memory_was_full_in_one():
    done = ran(sys.executable, "-c", FULL, ROOT / "sim/tests/engine", check=True)
    assert done.stdout == "out of memory True\n"
