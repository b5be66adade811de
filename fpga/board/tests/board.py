# SPDX-License-Identifier: Apache-2.0
"""Each board's top in the tests of cocotb_board.py: its RTL, or what was synthesised of it."""

from pathlib import Path

from cocotb_tests.lib import runner
from fpga.build import TARGETS, memory_file
from mmcs import ROOT
from tools.sources import core, sources

HERE = Path(__file__).parent
RTL = ("uart_host", "spi_converters", "mmcs_board")
TESTS = ("registers_over_the_serial_line", "a_disturbed_line", "converters_and_encoder",
         "the_stop_loop", "a_reset_takes_the_torque_away", "the_board_is_alive")  # fmt: skip


def bench(board: str) -> tuple[Path, ...]:
    """A board's top within its bench, and the cells that no vendor's file models."""
    return HERE / f"bench_{board}.sv", *sorted(HERE.glob("cells/*.sv"))


def simulate(board: str, netlist: tuple[Path, ...] = ()) -> dict[str, runner.Outcome]:
    """The outcome of each test; netlist: in place of the RTL, the vendor's cells last."""
    rtl = tuple(ROOT / f"fpga/board/{name}.sv" for name in (*RTL, board))
    job = runner.Job(
        "fpga.board.tests.cocotb_board", f"bench_{board}", "verilator",
        (), (*bench(board), *(() if netlist else rtl)), netlist=netlist,
        includes=(HERE.parent,),
    )  # fmt: skip
    return runner.run(job, list(TESTS), runner.DEFAULT_SEED)


SOC_TESTS = ("servo_pass_by_itself", "the_stop_loop_opens_it")
CPU = ("ibex_", "prim_lfsr", "prim_onehot_", "prim_secded_inv_")
SOC = ("uart_host", "spi_converters", "soc_console", "ulx3s_soc")


def simulate_soc(netlist: tuple[Path, ...] = ()) -> dict[str, runner.Outcome]:
    """The board that closes the loop by itself, with the program that its bitstream holds."""
    if netlist:
        return _soc(bench("ulx3s_soc"), netlist)
    image = memory_file(next(target for target in TARGETS if target.image))
    # a path that holds wherever the simulation runs
    top = image.with_name("bench_ulx3s_soc.sv")
    text = (HERE / top.name).read_text()
    top.write_text(text.replace("ulx3s_soc u_board", f'ulx3s_soc #(.InitFile("{image}")) u_board'))
    packages, libraries, includes = core()
    cpu = [f for d in libraries for f in sorted(d.glob("*.sv")) if f.stem.startswith(CPU)]
    files = [
        ROOT / "rtl/soc/core.vlt",
        *packages,
        *(f for f in cpu if f not in packages and "top" not in f.stem),
    ]
    files += [*sources("rtl"), *sources("soc"), *(ROOT / f"fpga/board/{n}.sv" for n in SOC)]
    return _soc((top, HERE / "cells/EHXPLLL.sv"), tuple(files), ROOT / "rtl", *includes)


def _soc(extra: tuple[Path, ...], files: tuple[Path, ...], *includes: Path):
    job = runner.Job(
        "fpga.board.tests.cocotb_soc", "bench_ulx3s_soc", "verilator",
        (), extra, netlist=files, includes=(HERE.parent, *includes),
    )  # fmt: skip
    return runner.run(job, list(SOC_TESTS), runner.DEFAULT_SEED)


PTY_TESTS = ("self_test_over_a_pty", "a_stop_loop_that_is_open", "wrong_and_cut_bytes",
             "a_board_that_is_in_reset", "a_pll_that_loses_its_lock")  # fmt: skip


def over_a_pty() -> dict[str, runner.Outcome]:
    """`mmcs board` against mmcs_board, at a clock and a heartbeat that simulate fast."""
    job = runner.Job(
        "fpga.board.tests.cocotb_pty", "mmcs_board", "verilator",
        (("ClkHz", 8_000_000), ("HeartbeatUs", 5_000)),
        tuple(ROOT / f"fpga/board/{name}.sv" for name in RTL), includes=(HERE.parent,),
    )  # fmt: skip
    return runner.run(job, list(PTY_TESTS), runner.DEFAULT_SEED)
