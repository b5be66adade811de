# SPDX-License-Identifier: Apache-2.0
"""Runs an example of this folder: python run.py vme_ram [icarus|verilator]; 1: its test failed."""

import sys
from pathlib import Path

from cocotb_tools.runner import get_results, get_runner

HERE = Path(__file__).resolve().parent


def main() -> int:
    known = sorted(file.stem for file in HERE.glob("*.sv"))
    name, simulator = [*sys.argv[1:], "icarus", ""][:2]
    if name not in known or simulator not in ("icarus", "verilator"):
        print(f"run.py: an example ({', '.join(known)}), then icarus or verilator", file=sys.stderr)
        return 2
    runner, build = get_runner(simulator), Path("sim_build") / f"{name}-{simulator}"
    runner.build(
        sources=[HERE / f"{name}.sv"], hdl_toplevel=name, build_dir=build, timescale=("1ns", "1ps")
    )
    sys.path.insert(0, str(HERE))  # where the simulator looks for the test
    results = runner.test(
        hdl_toplevel=name, test_module=name, test_dir=build, hdl_toplevel_lang="verilog"
    )
    return 1 if get_results(results)[1] else 0


if __name__ == "__main__":
    raise SystemExit(main())
