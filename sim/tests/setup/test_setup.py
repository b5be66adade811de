# SPDX-License-Identifier: Apache-2.0
"""Set-up files: one hash by whichever way they are carried out, and what the reader refuses."""

import random
import zlib

import pytest

from mmcs import (
    InputError,
    RunError,
    ensure_library,
    load,
    make_ffi,
    mcdef,
    run,
    scenario_names,
    setup_file,
    simulate,
    write_setup,
)
from mmcs.engine.script import made_from
from mmcs.engine.sim import load_library

pytestmark = pytest.mark.req("API-1")
HEAD, SUM, BUILD, NAME = 0, 12, 16, 80  # offsets of fields of mmcs_setup
AGAIN = "make it by `mmcs compile`"
CUT, DAMAGED, NONE = "the set-up is cut short", "the set-up is damaged", "this is no set-up"


@pytest.fixture(scope="module")
def good(tmp_path_factory) -> bytes:
    """A set-up with records of most kinds."""
    path = tmp_path_factory.mktemp("setup") / "good.bin"
    calls = 'call=[{at = 0.1, request = "MSETPARAM", set = {a0 = 7000, flags = ["coulcomp"]}}]'
    event = 'event=[{at = 0.1, input = "load_torque", value = 0.001, until = 0.12}]'
    write_setup(load("lab500", calls, event, "expect=[]"), path)
    return path.read_bytes()


@pytest.fixture(scope="module")
def lib():
    return load_library(ensure_library(1, "speed"))


def refused(lib, data: bytes) -> str:
    """The sentence; both readers have the same."""
    told = []
    for create in (lib.mmcs_sim_create_from, lib.mmcs_script_create_from):
        with pytest.raises(RunError) as failure:
            made_from(create, data)
        told.append(str(failure.value).removeprefix("the machine cannot be made: "))
    assert told[0] == told[1] and "\n" not in told[0]
    return told[0]


def with_sum(data: bytes) -> bytes:
    """The same with its length and sum made right: what somebody has made up."""
    data = data[:8] + len(data).to_bytes(4, "little") + data[12:]
    return data[:SUM] + zlib.crc32(data[BUILD:]).to_bytes(4, "little") + data[BUILD:]


def test_every_byte_that_is_another_is_noticed(lib, good):
    """Each of the head and of the records' beginning, and others by chance."""
    chance = random.Random(1)
    head = make_ffi().sizeof("mmcs_setup")
    for at in [*range(head + 64), *(chance.randrange(len(good)) for _ in range(300))]:
        data = good[:at] + bytes([good[at] ^ 1 << chance.randrange(8)]) + good[at + 1 :]
        told = refused(lib, data)
        expected = NONE if at < 8 else (CUT, DAMAGED) if at < 12 else DAMAGED
        assert told.startswith(expected) and told.endswith(AGAIN), (at, told)


def test_every_length_that_is_another_is_noticed(lib, good):
    head = make_ffi().sizeof("mmcs_setup")
    for size in (*range(head + 9), *range(head, len(good), 97), len(good) - 8, len(good) - 1):
        told = refused(lib, good[:size])
        expected = "there is no set-up" if size == 0 else NONE if size < 8 else CUT
        assert told.startswith(expected), (size, told)
    for more in (b"\0", bytes(8), good):
        assert refused(lib, good + more).startswith(DAMAGED)


def test_foreign_files_and_builds_are_refused(lib, good):
    for text in (b"mmcsfmu3" + good[8:], b"\x7fELF" + bytes(900), b'{"mmcs_run": 1}', b"x" * 999):
        assert refused(lib, text) == f"{NONE}: {AGAIN}"
    build = good[BUILD:NAME].rstrip(b"\0")
    for other in (
        b"c1 00000000",
        build.replace(b"c1", b"c3"),
        build.replace(b"c1 ", b"c1_beat10000 "),
    ):
        data = good[:BUILD] + other.ljust(64, b"\0") + good[NAME:]
        told = f"lab500 is for the simulator {other.decode()}, and this is {build.decode()}:"
        assert refused(lib, with_sum(data)) == f"{told} `mmcs compile` it again"


# --- what comes of one ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["lab500", "lab500_nocomp", "fault_estop"])
def test_a_file_gives_the_hash_of_its_scenario(tmp_path, name):
    setup = load(name, duration=0.15)
    path = tmp_path / f"{name}.bin"
    write_setup(setup, path)
    again = load(str(path))
    assert again.binary and simulate(again).hash == simulate(setup).hash
    assert run(str(path), seed=setup.scenario.seed + 1).hash == run(
        name, duration=0.15, seed=setup.scenario.seed + 1).hash  # fmt: skip


def test_every_scenario_survives_the_file(tmp_path):
    one, two, buffer = tmp_path / "one.bin", tmp_path / "two.bin", make_ffi().buffer
    for name in scenario_names():
        setup = load(name)
        if setup.scenario.cards > 3 or setup.scenario.program:
            continue
        write_setup(setup, one)
        again = load(str(one))
        again.binary, again.path = b"", setup.path
        write_setup(again, two)
        ours, theirs = setup_file.read(one.read_bytes()), setup_file.read(two.read_bytes())
        for kind in {*setup_file.RECORDS} - {"source"}:
            assert bytes(buffer(ours[kind])) == bytes(buffer(theirs[kind])), (name, kind)


def test_a_file_of_another_build_is_refused_by_the_commands(tmp_path, good):
    data = good[:BUILD] + b"c1 00000000".ljust(64, b"\0") + good[NAME:]
    (tmp_path / "old.bin").write_bytes(with_sum(data))
    with pytest.raises(InputError, match=r"is of another build \(c1 00000000, not c1 .*compile"):
        simulate(load(str(tmp_path / "old.bin")))
    (tmp_path / "half.bin").write_bytes(good[:-9])
    with pytest.raises(InputError, match="is no set-up, cut short, or damaged: .*mmcs compile"):
        load(str(tmp_path / "half.bin"))


# --- overrides -----------------------------------------------------------------------------------


def hash_of(lib, data: bytes, **given) -> int:
    """Of a run by the C ABI alone, as a C program does it."""
    ffi = make_ffi()
    over, err = ffi.new("mmcs_overrides *", given), ffi.new("char[]", 300)
    args = ffi.from_buffer(data), len(data), over, err, 300
    sim, script = lib.mmcs_sim_create_from(*args), lib.mmcs_script_create_from(*args)
    assert sim and script, ffi.string(err)
    assert lib.mmcs_script_begin(script, sim, err, 300) == 0, ffi.string(err)
    end = lib.mmcs_script_duration(script)
    assert lib.mmcs_script_act(script, sim, end, err, 300) == 0
    assert lib.mmcs_sim_run(sim, lib.mmcs_script_start(script) + end) == 0
    found = lib.mmcs_sim_hash(sim)
    lib.mmcs_script_destroy(script)
    lib.mmcs_sim_destroy(sim)
    return found


def test_overrides_are_the_scenario_with_these_values(lib, tmp_path):
    ffi, setup = make_ffi(), load("lab500")
    write_setup(setup, tmp_path / "lab500.bin")
    data = (tmp_path / "lab500.bin").read_bytes()
    lab = lambda *sets: int(run("lab500", *sets).hash, 0)  # noqa: E731
    assert hash_of(lib, data) == lab()
    assert hash_of(lib, data, what=lib.MMCS_OVER_SEED, seed=7) == lab("seed=7")
    assert hash_of(lib, data, what=lib.MMCS_OVER_DURATION, duration=0.1) == lab("duration=0.1")
    torque = {"at": 0.1, "until": -1, "value": 0.001, "index": 0}
    number = next(n for n in range(99) if ffi.string(lib.mmcs_sim_input_name(n)) == b"load_torque")
    events = ffi.new("mmcs_timed_event[]", [torque | {"input": number}])
    pushed = 'event=[{at = 0.1, input = "load_torque", value = 0.001}]'
    found = hash_of(lib, data, what=lib.MMCS_OVER_EVENTS, events=events, event_count=1)
    assert found == lab(pushed) != lab()
    sets = ffi.new("mmcs_set[]", mcdef.sets({"a0": 3000}))
    call = {"at": 0.1, "request": mcdef.MSETPARAM, "axes": 1, "sets": 1}
    calls = ffi.new("mmcs_call[]", [call])
    found = hash_of(lib, data, what=lib.MMCS_OVER_CALLS, calls=calls, call_count=1, sets=sets,
                    set_count=1)  # fmt: skip
    assert found == lab('call=[{at = 0.1, request = "MSETPARAM", set = {a0 = 3000}}]') != lab()
    assert hash_of(lib, data, what=lib.MMCS_OVER_SKIP, skip=0) == lab()


def test_another_seed_is_refused_where_records_come_from_it(lib, tmp_path):
    process = (
        'process=[{kind = "pd", axis = [0], at = 0, period_us = 5000, p = 1, d = 0, to = 9, %s}]'
    )
    sets = ("motion=[]", "expect=[]", process % "jitter_us = 100")
    write_setup(load("lab500", *sets), tmp_path / "late.bin")
    data, ffi = (tmp_path / "late.bin").read_bytes(), make_ffi()
    over = ffi.new("mmcs_overrides *", {"what": lib.MMCS_OVER_SEED, "seed": 7})
    err = ffi.new("char[]", 300)
    assert not lib.mmcs_sim_create_from(ffi.from_buffer(data), len(data), over, err, 300)
    assert b"[[process]] with jitter by its seed: `mmcs compile` it" in ffi.string(err)
