# SPDX-License-Identifier: Apache-2.0
"""`mmcs compare` and `mmcs faults`."""

from pathlib import Path

import click

from mmcs.errors import InputError
from mmcs.screen import echo


@click.command()
@click.argument("a", metavar="A")
@click.argument("b", metavar="B")
@click.option("--out", type=click.Path(path_type=Path), metavar="FILE.svg", help="The picture.")
def compare(a: str, b: str, out: Path | None) -> None:
    """Draw two runs over each other; A and B are folders, or names of scenarios that were run."""
    from mmcs.files import short
    from mmcs.folder import check_file, whole_file
    from mmcs.view.compare import print_comparison, write_comparison
    from mmcs.view.runs import read_run

    first, second = read_run(a), read_run(b)
    path = check_file(out or second.folder / "compare.svg")
    if path.suffix != ".svg":
        raise InputError.one("--out", "", str(out), "must end in .svg")
    with whole_file(path) as part:
        differences = write_comparison(first, second, part)
    print_comparison(first, second, differences)
    same = first.report["hash"] == second.report["hash"]
    echo(f"{'the same run to the bit' if same else 'different runs'}; {short(path)}")


@click.command()
@click.argument("pattern", default="")
@click.option("--cards", default=3, type=click.IntRange(1, 16), help="Of the machine.")
def faults(pattern: str, cards: int) -> None:
    """Every fault and upset that an event of a scenario can name.

    With PATTERN, those whose name holds it. seu.NAME flips bits of the register NAME.
    """
    from mmcs.engine.build import ensure_library
    from mmcs.engine.sim import library_registers
    from mmcs.inputs import INPUTS, UPSET

    registers = library_registers(ensure_library(cards, "speed"))
    lines = {
        name: f"{name:18} {i.scope:8} {i.low:g} to {i.high:g}, healthy {i.healthy:g}: {i.meaning}"
        for name, i in INPUTS.items()
    }
    for name, width in registers.items():
        lines[UPSET + name] = f"{UPSET}{name}  {width} bit{'s' if width > 1 else ''}"
    found = [line for name, line in lines.items() if pattern in name]
    if not found:
        raise InputError.one("PATTERN", "", pattern, "no input or register has it in its name")
    for line in found:
        echo(line)
