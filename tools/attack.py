#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`make attack`: every test that means no good, and so many damaged inputs for each parser.

attack.py [--inputs N] [--seed S]
"""

import argparse
import random
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tools.parsers import parsers

ROOT = Path(__file__).resolve().parent.parent
TESTS = ["labs/tests/test_grader_attacks.py", *(f"mmcs/tests/test_{name}.py" for name in (
    "hostile", "damaged", "whole", "mistakes", "exec", "place", "device_attacks", "device_ends",
    "messages", "stop", "tool_stop"))]  # fmt: skip


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


def fuzz(inputs: int, seed: int) -> int:
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
