# SPDX-License-Identifier: Apache-2.0
"""Set-up files (sim/abi/mmcs_service.h): written for the engine's reader, and what Python needs of
one."""

import hashlib
import json
import re
import zlib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from mmcs.folder import whole_file
from mmcs.mcdef import make_ffi
from mmcs.place import BUILD, ROBOTS, ROOT, SCENARIOS, digest, workshop

RECORDS = dict(
    re.findall(r"^RECORD\((\w+), ([\w ]+)\)", (ROOT / "sim/setup/records.def").read_text(), re.M)
)
MAGIC, ALIGNED = b"mmcsset\n", 8
NO_FILE = "is no set-up, cut short, or damaged: make it by `mmcs compile`"


def write(build: str, name: str, source: object = None, **given) -> bytes:
    """given: duration, clk_hz and by_seed of the head; and of each kind its records, as fields by
    name or an array of ffi. source: anything that JSON has."""
    ffi = make_ffi()
    packed = b"" if source is None else zlib.compress(json.dumps(source).encode())
    records = {"source": packed} | {kind: given.pop(kind) for kind in RECORDS if kind in given}
    head = ffi.new("mmcs_setup *", given)
    head.build, head.name = build.encode(), name.encode()[:63].decode(errors="ignore").encode()
    parts = []
    for n, (kind, structure) in enumerate(RECORDS.items()):
        found = records.get(kind, ())
        array = found if isinstance(found, ffi.CData) else ffi.new(f"{structure}[]", found)
        data = bytes(ffi.buffer(array))
        head.count[n] = len(array)
        parts.append(data + bytes(-len(data) % ALIGNED))
    head.magic = MAGIC
    head.bytes = ffi.sizeof("mmcs_setup") + sum(map(len, parts))
    rest = bytes(ffi.buffer(head))[ffi.offsetof("mmcs_setup", "build") :] + b"".join(parts)
    head.sum = zlib.crc32(rest)
    return bytes(ffi.buffer(head))[: ffi.offsetof("mmcs_setup", "build")] + rest


def read(data: bytes) -> dict[str, list]:
    """The head's fields by name, and of each kind its records. ValueError: it is none."""
    ffi = make_ffi()
    size = ffi.sizeof("mmcs_setup")
    if len(data) < size or data[:8] != MAGIC:
        raise ValueError(NO_FILE)
    head = ffi.new("mmcs_setup *")
    ffi.buffer(head)[:] = data[:size]
    checked = data[ffi.offsetof("mmcs_setup", "build") :]
    if head.bytes != len(data) or head.sum != zlib.crc32(checked):
        raise ValueError(NO_FILE)
    found = {"build": ffi.string(head.build).decode(), "name": ffi.string(head.name).decode(),
             "duration": head.duration, "clk_hz": head.clk_hz, "sum": head.sum}  # fmt: skip
    for count, (kind, structure) in zip(head.count, RECORDS.items(), strict=True):
        array = ffi.new(f"{structure}[]", count)
        bytes_ = ffi.sizeof(array)
        ffi.buffer(array)[:] = data[size : size + bytes_]
        found[kind] = array
        size += bytes_ + -bytes_ % ALIGNED
    return found


def source(found: dict) -> object:
    """What write() was given."""
    try:
        return json.loads(zlib.decompress(bytes(make_ffi().buffer(found["source"]))))
    except zlib.error:
        raise ValueError("holds no scenario to judge by: make it by `mmcs compile`") from None


def kept(scenario: str, sets: tuple[str, ...], make: Callable[[], tuple[dict, bytes]]):
    """What make() makes of a scenario: something that JSON has, and a set-up. That of a scenario of
    ours is kept until a source changes, since to check it takes longer than a short run."""
    if scenario.endswith((".toml", ".bin")) or "/" in scenario:
        return make()
    made_of = hashlib.sha256(repr((digest(), scenario, sets)).encode())
    for folder in (SCENARIOS, ROBOTS, Path(__file__).parent / "scenario", Path(__file__).parent):
        for file in sorted(folder.glob("**/*.*" if folder == SCENARIOS else "*.*")):
            made_of.update(file.read_bytes())
    key, path = made_of.hexdigest().encode(), workshop() / BUILD / "setups" / f"{scenario}.kept"
    with suppress(OSError, ValueError):
        of, told, setup = path.read_bytes().split(b"\n", 2)
        if of == key and read(setup):
            return json.loads(told), setup
    told, setup = make()
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as part:
            part.write_bytes(b"\n".join((key, json.dumps(told).encode(), setup)))
    return told, setup
