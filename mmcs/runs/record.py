# SPDX-License-Identifier: Apache-2.0
"""The run record, run.mmcs: a few kB from which a run can be made again, and judged.

It holds the scenario as it was in force (overrides applied), robot and tables as they were, and
what came out: the hash, and running hashes at samples in between, so that a replay can say where it
parts from the run.
"""

import base64
import json
import re
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

from mmcs import __version__
from mmcs.errors import InputError
from mmcs.files import LONGEST_S, is_name, loads, read_json, short
from mmcs.place import run_file
from mmcs.scenario.compiled import inline
from mmcs.scenario.files import tables_with_files

NAME = "run.mmcs"
FORMAT = 1
MAX_UNPACKED = 64 << 20  # bytes of files; four times what a scenario may have
FILE_NAME = re.compile(r"robot\.toml|table\d{1,6}\.csv|card\d{1,6}\.sv")
POINT = struct.Struct("<qqQQ")  # samples, clock, hash of samples, hash of what left the machine
MOST_POINTS = 32  # that are kept


@dataclass
class Record:
    """What run.mmcs says; `data` is the scenario with all overrides applied."""

    path: Path
    text: dict
    files: dict[str, str]  # the robot, tables and cards, by the names that `data` uses

    def __getattr__(self, name):
        try:
            return self.text[name]
        except KeyError:
            raise AttributeError(name) from None

    @property
    def points(self) -> list[tuple[int, int, int, int]]:
        return list(POINT.iter_unpack(base64.b64decode(self.text["checkpoints"])))

    def setup(self):
        """The run's setup, checked as any."""
        from mmcs.scenario.load import setup_of

        return setup_of(Path(f"{self.text['scenario']}.toml"), dict(self.data), self.files)


# --- writing -----------------------------------------------------------------------------------


def make_record(result, host: str) -> dict:
    """What run.mmcs will say of a run."""
    setup, points = result.setup, result.checkpoints
    every = max(1, -(-len(points) // MOST_POINTS))
    kept = b"".join(POINT.pack(*point) for point in points[every - 1 :: every])
    packed = zlib.compress(json.dumps(setup.files).encode(), 9)
    return {
        "mmcs_run": FORMAT,
        "version": __version__,
        "build": result.build,
        "scenario": setup.name,
        "host": host,
        "image": result.image,
        "seed": setup.scenario.seed,
        "hash": result.hash,
        "cycles": result.cycles,
        "clk_hz": result.clk_hz,
        "motion_start_s": result.motion_start_s,
        "samples": len(result.log),
        "data": inline(setup.data, setup.path.parent),
        "files": base64.b64encode(packed).decode(),
        "checkpoints": base64.b64encode(kept).decode(),
    }


def write_record(record: dict, folder: Path) -> Path:
    path = folder / NAME
    path.write_text(json.dumps(record, separators=(",", ":")).replace(',"', ',\n"') + "\n")
    return path


# --- reading -----------------------------------------------------------------------------------


def find_run(name: str) -> Path:
    """The record that a file, a run's folder or the name of the last run of a scenario means."""
    if path := run_file(name, NAME):
        return short(path)
    hint = f"no such run; give a {NAME}, its folder, or a scenario that has run"
    raise InputError.one(name, "", None, hint)


def read_record(name: str) -> Record:
    path = find_run(name)
    try:
        return parse(path, read_json(path))
    except ValueError as error:
        raise InputError.one(
            path, "", None, f"not a run record of MMCS, or damaged: {error}"
        ) from None


KINDS = {
    "version": str, "build": str, "scenario": str, "host": str, "image": str, "seed": int,
    "hash": str, "cycles": int, "clk_hz": int, "motion_start_s": (int, float), "samples": int,
    "data": dict, "files": str, "checkpoints": str,
}  # fmt: skip


def parse(path: Path, text: dict) -> Record:
    """Raises ValueError when this is not a record; InputError when it is of another format."""
    if not isinstance(text, dict) or "mmcs_run" not in text:
        raise ValueError("it is none")
    if text["mmcs_run"] != FORMAT:
        allowed = f"this version of mmcs reads format {FORMAT}; run the scenario again"
        raise InputError.one(path, "mmcs_run", text["mmcs_run"], allowed)
    for key, kind in KINDS.items():
        if not isinstance(text.get(key), kind) or isinstance(text[key], bool):
            raise ValueError(f"{key} is missing or wrong")
    if not is_name(text["scenario"]):
        raise ValueError("scenario must be a name")
    files = _unpack_files(text["files"])
    _check_data(text["data"], files)
    if not 0 <= text["motion_start_s"] <= LONGEST_S:
        raise ValueError("a time is wrong")
    if len(_decode(text["checkpoints"])) % POINT.size:
        raise ValueError("checkpoints are missing")
    return Record(path, text, files)


def _unpack_files(packed: str) -> dict[str, str]:
    try:
        unpacker = zlib.decompressobj()
        raw = unpacker.decompress(_decode(packed), MAX_UNPACKED)
    except zlib.error:
        raise ValueError("its files do not unpack") from None
    if not unpacker.eof:
        raise ValueError(f"its files are cut short, or larger than {MAX_UNPACKED >> 20} MB")
    files = loads(raw)
    if not isinstance(files, dict) or "robot.toml" not in files:
        raise ValueError("it holds no robot")
    for name, text in files.items():
        if not FILE_NAME.fullmatch(name) or not isinstance(text, str):
            raise ValueError("it holds a file of another kind")
        text.encode()  # a half character is a ValueError
    return files


def _check_data(data: dict, files: dict[str, str]) -> None:
    duration = data.get("duration")
    if not isinstance(duration, int | float) or not 0 < duration <= LONGEST_S:
        raise ValueError("the duration is wrong")
    named = [str(table["file"]) for table in tables_with_files(data).values()]
    if data.get("robot") != "./robot.toml" or not files.keys() >= {*named}:
        raise ValueError("it names a file that it does not hold")


def _decode(text: str) -> bytes:
    return base64.b64decode(text, validate=True)  # binascii.Error is a ValueError


# --- where a replay parts ----------------------------------------------------------------------


def first_difference(record: Record, points) -> str | None:
    """Between which running hashes these first differ from the run's, in one sentence; None when
    nothing does: of the samples, and of what no sample shows."""
    now = {p[0]: p for p in points}
    before = 0
    for samples, clock, hash_, trail in record.points:
        ours = now.get(samples)
        if ours is None:
            return f"servo sample {samples}: it never comes"
        if ours[2] != hash_ or ours[1] != clock:
            return f"servo samples {before} to {samples - 1} since power-on"
        if ours[3] != trail:
            return (
                f"between servo samples {before} and {samples} since power-on: bus cycles, drive "
                "voltages or lines; all samples agree"
            )
        before = samples
    return None
