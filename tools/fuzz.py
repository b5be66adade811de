#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`make fuzz`: inputs for every parser, led by the code that they reach.

fuzz.py [--inputs N] [--only TEXT]      N each for those in C and C++, N/100 for those in Python

C and C++ run with sanitizers; a finding stays in build/fuzz, and so do the inputs that reached
something new, which the next run begins with.
"""

import argparse
import contextlib
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build" / "fuzz"
CC = "clang-16"
SANITIZE = ["-g", "-O1", "-fsanitize=fuzzer,address,undefined", "-fno-sanitize-recover=undefined"]
OPTIONS = {
    "ASAN_OPTIONS": "detect_leaks=0:quarantine_size_mb=16", "UBSAN_OPTIONS": "print_stacktrace=1",
}  # fmt: skip
LIMITS = ["-timeout=300", "-rss_limit_mb=4096", "-max_len=40000"]


def client() -> Path:
    """The program, compiled anew: what it is made of is many files."""
    command = [CC, *SANITIZE, "-Isim/device", "sim/tests/fuzz/client.c", "-ldl", "-lpthread"]
    subprocess.run([*command, "-o", BUILD / "client"], cwd=ROOT, check=True)
    return BUILD / "client"


def calls() -> Path:
    sys.path.insert(0, str(ROOT / "firmware" / "tests"))
    from test_firmware import program

    return program()


def corpus(name: str) -> Path:
    folder = BUILD / "corpus" / name
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def fuzz(name: str, command: list, inputs: int) -> bool:
    """One run to its end; its last lines are told, and all of it kept."""
    log = BUILD / f"{name}.log"
    with log.open("w") as file:
        done = subprocess.run(
            [*map(str, command), f"-runs={inputs}", *LIMITS, f"-artifact_prefix={BUILD}/{name}-",
             str(corpus(name))],
            env={**os.environ, **OPTIONS}, cwd=ROOT, stdout=file, stderr=file, check=False,
        )  # fmt: skip
    reached = re.findall(r"cov: (\d+)", text := log.read_text(errors="replace"))
    runs = re.findall(r"^#(\d+)", text, flags=re.M)
    state = "well" if done.returncode == 0 else f"WRONGLY: see {log.relative_to(ROOT)}"
    told = f"{runs[-1] if runs else 0} inputs, {reached[-1] if reached else 0} places reached"
    print(f"fuzz: {name}: {told}, ended {state}", flush=True)
    return done.returncode == 0


def random_calls(inputs: int) -> bool:
    command = [calls(), "test_random_calls", str(inputs), "1"]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    state = "well" if done.returncode == 0 else f"WRONGLY: {done.stdout}{done.stderr}"
    print(f"fuzz: calls: {inputs} calls of the driver, ended {state}", flush=True)
    return done.returncode == 0


def one(name: str) -> None:
    """The process of one Python parser: never returns."""
    import atheris

    with atheris.instrument_imports(include=["mmcs"], enable_loader_override=False):
        from tools.parsers import parsers

        folder = Path(tempfile.mkdtemp(prefix="mmcs-fuzz"))
        parser = next(p for p in parsers(folder) if p.name == name)
        parser.take(parser.good)
    (corpus(name) / "good").write_bytes(parser.good)

    def take(data: bytes) -> None:
        with contextlib.suppress(parser.refusals):
            parser.take(data)

    rest = sys.argv[sys.argv.index("--") + 1 :]
    atheris.Setup([sys.argv[0], *rest], take)
    atheris.Fuzz()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--only", default="", help="those whose name holds this")
    options = parser.parse_args()
    from tools.parsers import parsers

    names = [p.name for p in parsers(Path("/tmp"))]
    BUILD.mkdir(parents=True, exist_ok=True)
    every = {
        "calls": random_calls,
        "client": lambda n: fuzz("client", [client()], n),
    } | {
        name: lambda n, name=name: fuzz(name, [sys.executable, __file__, name, "--"], n // 100)
        for name in names
    }  # fmt: skip
    ends = [run(options.inputs) for name, run in every.items() if options.only in name]
    print(f"fuzz: {sum(ends)} of {len(ends)} ended well")
    return 0 if all(ends) and ends else 1


if __name__ == "__main__":
    if len(sys.argv) > 2 and sys.argv[2] == "--":
        one(sys.argv[1])
    sys.exit(main())
