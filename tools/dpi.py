# SPDX-License-Identifier: Apache-2.0
"""A scenario through DPI: builds the testbench for its machine by Verilator, and carries its set-up
file out there."""

import argparse
import resource
import sys
from pathlib import Path

from mmcs import ROOT, InputError, RunError, load, make_env, write_setup
from mmcs.files import short
from mmcs.place import results
from tools.compiled import ran

BUILT = ROOT / "build" / "sim" / "dpi"


def bench(cards: int, clk_hz: int = 8_000_000, trace: bool = False, **other: str) -> Path:
    """The testbench's program; other: variables of sim/dpi/Makefile (SOURCES, with a NAME)."""
    variables = {"CARDS": cards, "CLK_HZ": clk_hz, "TRACE": "1" if trace else "", **other}
    command = ["make", "-s", "-f", "sim/dpi/Makefile", *(f"{k}={v}" for k, v in variables.items())]
    done = ran(*command, env=make_env())
    if done.returncode:
        said = (done.stderr + done.stdout).strip().splitlines() or ["no output"]
        telling = [line for line in said if "rror" in line]
        raise RunError(f"the testbench does not build; {(telling or said)[0].strip()[:300]}")
    clk = "" if clk_hz == 8_000_000 else f"_clk{clk_hz}"
    name = other.get("NAME", f"c{cards}{clk}{'_trace' if trace else ''}")
    return BUILT / name / "mmcs_tb"


def run(program: Path, setup: Path, folder: Path, trace: Path | None = None, **how):
    """Carries a set-up file out on it, log.csv and bus.csv into the folder; as subprocess.run()."""
    command = [program, f"+setup={setup}", f"+out={folder}", "+verilator+quiet"]
    if trace:
        command.append(f"+trace={trace}")
    # $fatal, the word for a bad end, is an abort in Verilator: no core is wanted of it.
    no_core = lambda: resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # noqa: E731
    return ran(*command, preexec_fn=no_core, **{"capture_output": False} | how)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario")
    parser.add_argument("--trace", action="store_true", help="waveforms beside the results")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    options = parser.parse_args()
    try:
        setup = load(options.scenario, *options.set)
        folder = (results("runs", setup.path) / f"{setup.name}-dpi").absolute()
        folder.mkdir(parents=True, exist_ok=True)
        trace = folder / f"{setup.name}.vcd" if options.trace else None
        program = bench(setup.scenario.cards, setup.scenario.clk_hz, options.trace)
        write_setup(setup, folder / "setup.bin")
    except (InputError, RunError) as error:
        print(f"mmcs: {error}", file=sys.stderr)
        return 2
    done = run(program, folder / "setup.bin", folder, trace)
    if done.returncode == 0:
        print(f"results in {short(folder)}" + (f", trace {short(trace)}" if trace else ""))
    return 1 if done.returncode else 0


if __name__ == "__main__":
    raise SystemExit(main())
