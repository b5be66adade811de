# SPDX-License-Identifier: Apache-2.0
"""`mmcs mcap`, `mmcs fmu`: samples and machines for tools that others wrote."""

from pathlib import Path

import click

from mmcs.errors import InputError
from mmcs.screen import echo


@click.command()
@click.argument("run", metavar="RUN")
@click.option("--out", type=click.Path(path_type=Path), metavar="FILE.mcap", help="The file.")
def mcap(run: str, out: Path | None) -> None:
    """Write a run's log as MCAP, for Foxglove and PlotJuggler; RUN as in `mmcs compare`."""
    try:
        from mmcs.view.mcap_file import from_run
    except ImportError:
        raise InputError.one("mcap", "", None, "is not installed; pip install mmcs[tool]") from None
    from mmcs.files import short
    from mmcs.folder import check_file, whole_file
    from mmcs.view.runs import read_run

    seen = read_run(run)
    path = check_file(out or seen.folder / "log.mcap")
    with whole_file(path) as part:
        part.write_bytes(from_run(seen))
    echo(f"mmcs: {short(path)}")


@click.command()
@click.argument("scenario", default="lab500", metavar="SCENARIO")
@click.option("--out", type=click.Path(path_type=Path), metavar="FILE.fmu", help="The file.")
def fmu(scenario: str, out: Path | None) -> None:
    """Write a scenario's machine as a co-simulation unit, FMI 3.0, for this kind of computer."""
    from mmcs.bridge.fmu import write
    from mmcs.files import short
    from mmcs.folder import check_file, whole_file
    from mmcs.scenario.load import load

    setup = load(scenario, ())
    path = out or Path(f"{setup.name}.fmu")
    if path.suffix != ".fmu":
        raise InputError.one("--out", "", str(path), "must end in .fmu")
    check_file(path)
    with whole_file(path) as part:
        write(setup, part)
    echo(f"mmcs: {short(path)}")
