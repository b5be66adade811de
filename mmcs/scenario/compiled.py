# SPDX-License-Identifier: Apache-2.0
"""A checked setup as the records of a set-up file (sim/abi/mmcs_service.h), from which the engine
makes the machine and carries the scenario out."""

import hashlib
import json
import random
import shlex
from collections.abc import Callable
from pathlib import Path

from mmcs import mcdef, setup_file
from mmcs.errors import InputError, suggest
from mmcs.mcdef import make_ffi
from mmcs.scenario.files import tables_with_files
from mmcs.scenario.setup import Setup

PROCESSES = ("pd", "bounce")  # as MMCS_PROCESS_... counts them
NOT_AT_ALL = -1.0  # of an event that does not end


def compile_setup(setup: Setup, build: str, inputs: Callable[[], list[str]],
                  skip: bool | None = None, host: dict | None = None,
                  with_source: bool = False) -> bytes:  # fmt: skip
    """For the build of this mmcs_sim_build_id() and its inputs' names. skip: if not as the scenario
    says; host: fields of mmcs_config that choose it and the library of own cards. with_source:
    `mmcs run` can judge by it."""
    scenario = setup.scenario
    skip, host = scenario.skip if skip is None else skip, host or {}
    key = (build, skip, *host.values(), with_source)
    if setup.binary and _is_that(setup, build, skip, host):
        return setup.binary
    if key not in setup.compiled:
        numbers: list[float] = []
        records = _motions(setup, numbers) | _script(setup, inputs, numbers)
        config = setup.config() | host | {"skip": int(skip)}
        paths = ("processor", "firmware", "card")
        files = {name: _path(config[name]) for name in paths if name in config}
        jitter = any(getattr(process, "jitter_us", 0) for process in scenario.process)
        setup.compiled[key] = setup_file.write(
            build, setup.name, _source(setup) if with_source else None,
            duration=scenario.duration, clk_hz=scenario.clk_hz, by_seed=int(jitter),
            config=[config | files], motor=setup.motors(), link=setup.links(), number=numbers,
            **records,
        )  # fmt: skip
    return setup.compiled[key]


def _is_that(setup: Setup, build: str, skip: bool, host: dict) -> bool:
    """Whether the file that the setup comes from is what is asked for. InputError: it is of another
    build."""
    found = setup_file.read(setup.binary)
    if found["build"] != build:
        allowed = f"is of another build ({found['build']}, not {build}): `mmcs compile` it again"
        raise InputError.one(setup.path, "", None, allowed)
    config = found["config"][0]
    card = make_ffi().string(config.card).decode(errors="replace") == host.get("card", "")
    return config.skip == skip and config.host == host.get("host", 0) and card


def _source(setup: Setup) -> dict:
    """What load() makes the setup of again."""
    return {"data": inline(setup.data, setup.path.parent), "files": setup.files}


def inline(data: dict, folder: Path) -> dict:
    """The scenario, naming the setup's files by the plain names that they have in a record."""
    data = json.loads(json.dumps(data)) | {"robot": "./robot.toml"}
    for name, table in tables_with_files(data).items():
        table["file"] = name
    for program in data.get("program", []):
        program["run"] = absolute(program["run"], folder)
        program["digest"] = digest(program["run"])
    return data


def absolute(command: str, folder: Path) -> str:
    """The command with files of the scenario's folder by their whole paths."""
    words = [
        str((folder / word).absolute()) if (folder / word).is_file() else word
        for word in shlex.split(command)
    ]
    return shlex.join(words)


def digest(command: str) -> str:
    """Of the files that a command names: who replays it hears when they are others."""
    found = hashlib.sha256()
    for word in shlex.split(command):
        if Path(word).is_file():
            found.update(Path(word).read_bytes())
    return found.hexdigest()[:16]


def _path(name: str) -> bytes:
    given = name.encode()
    if len(given) > 255:
        raise InputError.one(name, "", None, "is a path of more than 255 bytes: build elsewhere")
    return given


def _motions(setup: Setup, numbers: list[float]) -> dict[str, list]:
    segments = []
    for fields in setup.segments:
        table = fields.get("table", [])
        segments.append(fields | {"kind": mcdef.SEGMENT_KINDS.index(fields["kind"]),
                                  "table_at": len(numbers), "table_len": len(table)})  # fmt: skip
        segments[-1].pop("table", None)
        numbers += table
    return {"segment": segments}


def _script(setup: Setup, inputs: Callable[[], list[str]], numbers: list[float]) -> dict:
    """What is done, and when."""
    scenario = setup.scenario
    calls, sets = [], []
    for call in sorted(scenario.call, key=lambda call: call.at):
        values = call.set.model_dump(exclude_none=True, exclude={"axis"}) if call.set else {}
        changes = mcdef.sets(values)
        calls.append({"at": call.at, "request": getattr(mcdef, call.request),
                      "axes": _bits(_axes(call.axis, setup)), "value": call.value,
                      "set_at": len(sets), "sets": len(changes)})  # fmt: skip
        sets += changes
    names = inputs() if scenario.event else []
    records = {
        "event": [_event(setup, names, n, event) for n, event in enumerate(scenario.event)],
        "call": calls,
        "set": sets,
        "process": [_process(setup, n, one, numbers) for n, one in enumerate(scenario.process)],
        "refusal": [{"request": name.encode()} for name in setup.refusals() if len(name) < 32],
    }
    if not scenario.program:  # else programs open the driver
        records |= {"driver": [setup.driver()], "param": mcdef.new_params(setup.params)}
    return records


def _event(setup: Setup, names: list[str], place: int, event) -> dict:
    if event.input not in names:
        hint = suggest(event.input, names) or "; `mmcs faults` lists them"
        key, allowed = f"event.{place}.input", f"this machine has no such input{hint}"
        raise InputError.one(setup.path, key, event.input, allowed)
    return {"at": event.at, "until": NOT_AT_ALL if event.until is None else event.until,
            "value": event.value, "input": names.index(event.input), "index": event.index,
            "at_power_on": event.at_power_on}  # fmt: skip


def _process(setup: Setup, number: int, process, numbers: list[float]) -> dict:
    """Its goals of all axes, and its lateness by seed, go into the numbers."""
    axes, goals = _axes(process.axis, setup), [0.0] * setup.axes
    given = process.to if isinstance(process.to, list) else [process.to] * len(axes)
    for axis, goal in zip(axes, given, strict=True):
        goals[axis] = goal
    fields = {"kind": PROCESSES.index(process.kind), "axes": _bits(axes), "at": process.at}
    late_us: list[float] = []
    if process.kind == "pd":
        fields |= {"p": process.p, "d": process.d, "period_us": process.period_us}
        late = random.Random(f"{setup.scenario.seed}/{number}")
        turns = int(setup.scenario.duration * 1e6 / process.period_us) + 2
        if process.jitter_us:
            late_us = [late.uniform(0.0, process.jitter_us) for _ in range(turns)]
    fields |= {"goals_at": len(numbers), "late_at": len(numbers) + len(goals),
               "turns": len(late_us)}  # fmt: skip
    numbers += goals + late_us
    return fields


def _axes(axis, setup: Setup) -> list[int]:
    return list(range(setup.axes)) if axis == "all" else list(axis)


def _bits(axes) -> int:
    return sum(1 << axis for axis in set(axes))
