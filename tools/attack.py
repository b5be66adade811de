#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`make attack`: every test that means no good, and so many damaged inputs for each parser.

attack.py [--inputs N] [--seed S]
"""

from __future__ import annotations

import argparse
import json
import random
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TESTS = [f"mmcs/tests/test_{name}.py" for name in (
    "hostile", "whole", "mistakes", "robot_mistakes", "rough_input", "kills", "exec")]  # fmt: skip


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


def parsers(folder: Path):
    """(name, a good input, what takes a damaged one) of every parser in Python."""
    from mmcs import ROBOTS
    from mmcs.record.record import KINDS, parse
    from mmcs.scenario.files import loads, scenario_names
    from mmcs.scenario.load import load, load_robot
    from mmcs.sweep.plan import parse_grid
    from mmcs.sweep.store import _entry

    def scenario(data):
        (folder / "s.toml").write_bytes(data)
        load(str(folder / "s.toml"))

    def robot(data):
        (folder / "r.toml").write_bytes(data)
        load_robot(str(folder / "r.toml"))

    record = {"mmcs_run": 1} | {
        key: kind() for key, kind in KINDS.items() if isinstance(kind, type)
    }
    row = {"n": 3, "row": {"status": "ok", "unmet": 0, "why": "", "hash": "0x0", "settle_ms": 1.5}}
    from mmcs.scenario.files import find

    yield "scenario", find(scenario_names()[0]).read_bytes(), scenario
    yield "robot", (ROBOTS / "lab500.toml").read_bytes(), robot
    yield "record", json.dumps(record).encode(), lambda d: parse(folder / "x", loads(d))
    yield "rows", json.dumps(row).encode(), _entry
    yield "grid", b"axis.0.b0=80..100:5", lambda d: parse_grid(d.decode(errors="replace"))


def fuzz(inputs: int, seed: int) -> int:
    """Damaged inputs for each parser; how many ended in neither a result nor a sentence."""
    from mmcs.errors import InputError

    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, good, take in parsers(Path(folder)):
            allowed = (InputError, ValueError) if name == "record" else InputError
            chance, ends = random.Random(f"{seed}/{name}"), Counter()
            for n in range(inputs):
                data = damaged(good, chance)
                try:
                    take(data)
                    ends["taken"] += 1
                except allowed:
                    ends["refused"] += 1
                except Exception as error:
                    ends["wrong"] += 1
                    print(f"attack: {name}, input {n}: {error!r}", flush=True)
            wrong += ends["wrong"]
            print(f"attack: {name}: {inputs} inputs, {dict(ends)}", flush=True)
    return wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=20_000, help="for each parser")
    parser.add_argument("--seed", type=int, default=1989)
    options = parser.parse_args()
    wrong = fuzz(options.inputs, options.seed)
    done = subprocess.run([sys.executable, "-m", "pytest", "-q", *TESTS], cwd=ROOT, check=False)
    print(f"attack: {wrong} inputs ended wrongly, tests ended with {done.returncode}")
    return 1 if wrong or done.returncode else 0


if __name__ == "__main__":
    sys.exit(main())
