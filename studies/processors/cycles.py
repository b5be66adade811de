# SPDX-License-Identifier: Apache-2.0
"""Runs the servo arithmetic (firmware/ports/bench.c) natively and on the 68020; times it.

As a program it rewrites the tables of docs/simulator/processors.md.
"""

import argparse
import ctypes as c
import os
import subprocess

from mmcs import ROOT, Session, hosts, load, machine
from tools.pages import committed, rewrite

FIRMWARE = ROOT / "build" / "firmware"
FOLDERS = "firmware rtl sim"  # that the tables depend on
BLOCK = 0x1E000
MARK, DONE = BLOCK + 16, BLOCK + 12
MHZ = 50 / 3
PROFILES = ("P", "PD, gains of the PUMA 560", "PID, friction, filter, limits", "velocity",
            "torque, A/D offset", "A/D feedback, 2nd order", "triangle",
            "A/D demand, open loop, b0 = 19", "PD, limits, saturated",
            "PD of numbers beyond 32 bits", "PD without a filter")  # fmt: skip

READ = c.CFUNCTYPE(c.c_int, c.c_void_p, c.c_uint32, c.c_int, c.POINTER(c.c_uint32))
WRITE = c.CFUNCTYPE(c.c_int, c.c_void_p, c.c_uint32, c.c_int, c.c_uint32)
ACK = c.CFUNCTYPE(c.c_int, c.c_void_p, c.c_int)


class Bus(c.Structure):
    _fields_ = [("ctx", c.c_void_p), ("read", READ), ("write", WRITE), ("acknowledge", ACK)]


class Timing(c.Structure):
    _fields_ = [("cache", c.c_int32), ("wait_states", c.c_int32)]


def build() -> None:
    """Compiles what is not up to date, for both processors."""
    for host in ("m68020", "rv32"):
        hosts.make("firmware/Makefile", host)
    hosts.make("sim/hosts/Makefile", "all")


def native():
    """bench(profile, ticks) of this machine."""
    library = FIRMWARE / "bench_native.so"
    part = library.with_suffix(f".{os.getpid()}")
    mc = ROOT / "firmware"
    subprocess.run(
        ["cc", "-O2", "-shared", "-fPIC", "-DBENCH_NATIVE", f"-I{mc / 'mc'}", f"-I{mc / 'include'}",
         "-o", str(part), str(mc / "ports" / "bench.c"),
         *map(str, sorted((mc / "mc").glob("servo*.c")))],
        check=True,
    )  # fmt: skip
    part.replace(library)
    function = c.CDLL(str(library)).bench
    function.restype, function.argtypes = c.c_uint32, (c.c_uint32, c.c_uint32)
    return function


def iss():
    lib = c.CDLL(str(ROOT / "build" / "hosts" / "libm68020.so"))
    lib.iss_create.restype = c.c_void_p
    lib.iss_create.argtypes = (c.c_uint32, c.c_char_p, c.c_size_t, c.POINTER(Bus),
                               c.POINTER(Timing))  # fmt: skip
    lib.iss_cycles.restype = c.c_int64
    for name in ("iss_cycles", "iss_destroy"):
        getattr(lib, name).argtypes = (c.c_void_p,)
    lib.iss_run.argtypes = (c.c_void_p, c.c_int)
    return lib


def on_68020(profile: int, ticks: int, cache: int = 0, waits: int = 0):
    """(hash, cycles per tick: mean and worst) of the compiled firmware."""
    lib = iss()
    words = {BLOCK: profile, BLOCK + 4: ticks, BLOCK + 8: 0, DONE: 0, MARK: 0}
    spans: list[int] = []
    begin = [0]

    def read(_, address, size, value):
        if size != 4 or address not in words:
            return 1
        value[0] = words[address]
        return 0

    def write(_, address, size, value):
        if size != 4 or address not in words:
            return 1
        words[address] = value
        if address == MARK and value:
            begin[0] = lib.iss_cycles(cpu)
        elif address == MARK:
            spans.append(lib.iss_cycles(cpu) - begin[0])
        return 0

    bus = Bus(None, READ(read), WRITE(write), ACK(lambda *_: -2))
    image = (FIRMWARE / "m68020" / "bench.bin").read_bytes()
    timing = Timing(cache, waits)
    cpu = lib.iss_create(BLOCK, image, len(image), bus, timing)
    try:
        for _ in range(10 * ticks + 10):
            if words[DONE]:
                break
            lib.iss_run(cpu, 100_000)
    finally:
        lib.iss_destroy(cpu)
    assert words[DONE] == 1, f"the image did not end: {words}"
    return words[BLOCK + 8], sum(spans) / len(spans), max(spans)


TABLE = [("all fetches cached", 0, 0), ("256 B cache, 0 waits", 1, 0),
         ("256 B cache, 1 wait", 1, 1), ("256 B cache, 2 waits", 1, 2)]  # fmt: skip


def table(ticks: int = 100) -> str:
    columns = [f"68020, {name}" for name, *_ in TABLE]
    lines = ["| six axes | " + " | ".join(columns) + " |", "|---|" + "---|" * len(columns)]
    for profile, name in enumerate(PROFILES):
        cells = []
        for _, cache, waits in TABLE:
            _, mean, worst = on_68020(profile, ticks, cache, waits)
            cells.append(f"{mean:.0f} = {mean / MHZ / 1000:.3f} ms (worst {worst})")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


PASS_PARTS = ("latency", "enter", "read", "compute", "write", "publish", "pass")


def passes(scenario: str, cache: int, waits: int):
    """What one servo pass of the compiled driver takes beside the RTL, and how it ended."""
    bytes_ = '"256 bytes"' if cache else '"ideal"'
    sets = ("duration=0.3", "interval_us=2000", "motion=[]", "expect=[]",
            f"host.wait_states={waits}", f"host.instruction_cache={bytes_}")  # fmt: skip
    setup = load(scenario, *sets)
    with machine(setup, host="m68020") as sim:
        Session(sim, setup).run(lambda *_: None)
        return sim.phases(), sim.stats()


def pass_table() -> str:
    lines = ["| | " + " | ".join((*PASS_PARTS, "longest")) + " |"]
    lines += ["|---|" + "---|" * (len(PASS_PARTS) + 1)]
    for scenario, axes in (("lab500", "2 axes"), ("puma560", "6 axes")):
        for name, *memory in TABLE:
            # slow enough for the slowest: what a pass takes does not depend on it
            phases, stats = passes(scenario, *memory)
            assert stats["overruns"] == 0, "a pass takes more than 2 ms"
            cells = [f"{phases[part][1]:.0f}" for part in PASS_PARTS]
            cells.append(f"{phases['pass'][2]:.0f}")
            lines.append(f"| {axes}, 68020, {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main(names: list[str]) -> None:
    """Rewrites the tables named, or both."""
    build()
    path = ROOT / "docs" / "simulator" / "processors.md"
    for name, make in {"cycles": table, "passes": pass_table}.items():
        if not names or name in names:
            committed(FOLDERS)
            command = f"make -f sim/hosts/Makefile table TABLES={name}"
            rewrite(path, name, make(), command, FOLDERS)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tables", nargs="*", help="cycles, passes; both without any")
    main(parser.parse_args().tables)
