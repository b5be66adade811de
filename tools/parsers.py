# SPDX-License-Identifier: Apache-2.0
"""Every parser in Python with a good input, and inputs damaged at random for each: the end of `make
attack`.

parsers.py [--inputs N] [--seed S]
"""

import argparse
import base64
import json
import random
import socket
import struct
import sys
import tempfile
import zlib
from collections import Counter
from pathlib import Path

import mmcs
from mmcs import ROBOTS, ROOT, InputError, load, mcdef
from mmcs.device import wire
from mmcs.device.messages import LENGTH, Messenger
from mmcs.device.programs import Program
from mmcs.device.server import Server
from mmcs.device.stop import Stop
from mmcs.files import loads
from mmcs.runs.record import KINDS
from mmcs.sweeps.plan import parse_grid
from mmcs.sweeps.store import _entry, checksum


class Parser:
    """good: an input that is taken; take(bytes): parses; refusals: how it may end."""

    def __init__(self, name: str, good: bytes, take, refusals=(InputError,)):
        self.name, self.good, self.take, self.refusals = name, good, take, refusals


def parsers(folder: Path) -> list[Parser]:
    """Files go into this folder."""
    return [
        _scenario(folder), _robot(folder), _record(folder), _rows(), _grid(), _wire(folder),
        _messages(folder), _stop(folder),
    ]  # fmt: skip


def _written(path: Path, data: bytes) -> str:
    path.unlink(missing_ok=True)  # a file that is written over waits for the disk
    path.write_bytes(data)
    return str(path)


def _scenario(folder: Path) -> Parser:
    path = folder / "s.toml"
    good = mmcs.find(mmcs.scenario_names()[0]).read_bytes()
    return Parser("scenario", good, lambda data: load(_written(path, data)))


def _robot(folder: Path) -> Parser:
    path = folder / "r.toml"
    good = (ROBOTS / "lab500.toml").read_bytes()
    return Parser("robot", good, lambda data: mmcs.load_robot(_written(path, data)))


def _good_record() -> dict:
    """Of a run that was never made: enough for what reads records."""
    files = {"robot.toml": (ROBOTS / "lab500.toml").read_text()}
    packed = base64.b64encode(zlib.compress(json.dumps(files).encode())).decode()
    plain = {key: kind() for key, kind in KINDS.items() if isinstance(kind, type)}
    return {"mmcs_run": 1} | plain | {
        "scenario": "lab500", "motion_start_s": 0.1, "clk_hz": 8_000_000,
        "files": packed, "data": {"robot": "./robot.toml", "duration": 0.3},
    }  # fmt: skip


def _record(folder: Path) -> Parser:
    good = json.dumps(_good_record()).encode()
    refusals = (InputError, ValueError)  # whose sentence read_record() tells
    return Parser("record", good, lambda data: mmcs.parse(folder / "x", loads(data)), refusals)


def _rows() -> Parser:
    row = {"status": "ok", "unmet": 0, "why": "", "hash": "0x0", "settle_ms": 1.5}
    good = json.dumps({"n": 3, "row": row, "sum": checksum("me", 3, row)}).encode()
    return Parser("rows", good, lambda data: _entry(data, "me"), ())


def _grid() -> Parser:
    return Parser("grid", b"axis.0.b0=80..100:5", lambda d: parse_grid(d.decode(errors="replace")))


# --- what comes over sockets: nothing at all may come out of it --------------------------------


def _packets(folder: Path, name: str, good: bytes, kind, cut, first: bytes = b"") -> Parser:
    """Of a server's connections of this kind, which are given packets by hand as `cut` makes them
    of an input; their answers go nowhere. first: for one that stays open, in whatever state inputs
    leave it."""
    servers: list[Server] = []

    def feed(*packets: bytes):
        mine, theirs = socket.socketpair()
        mine.close()  # what is sent there is lost
        connection = kind(theirs, servers[0])
        connection.ended = False
        connection._send, connection.flush = lambda packet: None, lambda: None
        for packet in packets:
            connection.take = lambda packet=packet: packet
            connection.receive()
            while connection.has_request() and not connection.busy:  # that is answered later
                connection.serve(nested=False)
        return connection

    def take(data: bytes) -> None:
        if not servers:
            text = (ROOT / "sim" / "scenarios" / "basic" / "lab500.toml").read_bytes()
            setup = load(_written(folder / f"{name}.toml", text))
            servers.append(Server(mmcs.machine(setup), folder / name / "mc0.sock", None))
            feed(*[first] * bool(first))
        connection = feed(*cut(data))
        connection.close()
        connection.leave()

    return Parser(name, good, take, ())


def _wire(folder: Path) -> Parser:
    def request(op, a, data=b""):
        return wire.REQUEST.pack(wire.MAGIC, op, 1, a, 0, len(data), 1) + data

    def cut(data):
        return [b"MMC1" + rest for rest in data.split(b"MMC1")[1:]]

    good = request(wire.READ, 56) + request(wire.WRITE, 0, bytes(4))
    good += request(wire.IOCTL, mcdef.MSETINTERVAL, struct.pack("<I", 1000))
    good += request(wire.IOCTL, mcdef.MLEASE, bytes([1, 0, 0, 0]))
    return _packets(folder, "wire", good, Program, cut, request(wire.OPEN, 2, b"/dev/mc0"))


def _messages(folder: Path) -> Parser:
    def cut(data):
        return [LENGTH.pack(len(text)) + text if text else b"" for text in data.split(b"\n")]

    asked = [
        {"id": 1, "op": "open", "mode": "rw"},
        {"id": 2, "op": "call", "request": "MSETINTERVAL", "value": 1000},
        {"id": 3, "op": "change", "axis": 0, "param": {"a0": 5}},
        {"id": 4, "op": "write", "setpoints": [1]},
        {"id": 5, "op": "input", "name": "estop", "value": 1},
        {"id": 6, "op": "follow", "every": 2, "past": 3},
        {"id": 7, "op": "snapshot"},
        {"id": 8, "op": "rewind", "t": 0.1},
    ]
    good = b"\n".join(json.dumps(a).encode() for a in asked)
    return _packets(folder, "messages", good, Messenger, cut)


def _stop(folder: Path) -> Parser:
    def cut(data):
        return [data[n : n + 64] for n in range(0, len(data), 64)]

    return _packets(folder, "stop", b"state\nstop\npress\nrelease\n", Stop, cut)


# --- damage --------------------------------------------------------------------------------------


def damaged(data: bytes, chance: random.Random) -> bytes:
    """The bytes with something changed, cut out, doubled or put in."""
    out = bytearray(data)
    for _ in range(chance.randrange(1, 4)):
        at, kind = chance.randrange(len(out) + 1), chance.randrange(5)
        end = min(len(out), at + chance.randrange(1, 40))
        if kind == 0:
            out[at:end] = b""
        elif kind == 1:
            out[at:at] = out[at:end]
        elif kind == 2:
            out[at:at] = chance.choice((b"\0", b"\xff", b"[", b"{", b"nan", b"-1", b"1e999", b'"'))
        elif at < len(out):
            out[at] = chance.randrange(256) if kind == 3 else out[at] ^ 1 << chance.randrange(8)
    return bytes(out)


def attack(inputs: int, seed: int) -> int:
    """Damaged inputs for each parser; how many ended in neither a result nor a sentence."""
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for parser in parsers(Path(folder)):
            chance, ends = random.Random(f"{seed}/{parser.name}"), Counter()
            parser.take(parser.good)  # else what is damaged of it would be refused at once
            for n in range(inputs):
                data = damaged(parser.good, chance)
                try:
                    parser.take(data)
                    ends["taken"] += 1
                except parser.refusals:
                    ends["refused"] += 1
                except Exception as error:
                    ends["wrong"] += 1
                    print(f"attack: {parser.name}, input {n}: {error!r}", flush=True)
            wrong += ends["wrong"]
            print(f"attack: {parser.name}: {inputs} inputs, {dict(ends)}", flush=True)
    return wrong


if __name__ == "__main__":
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--inputs", type=int, default=20_000, help="for each parser")
    asked.add_argument("--seed", type=int, default=1989)
    sys.exit(attack(**vars(asked.parse_args())) > 0)
