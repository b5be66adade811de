# SPDX-License-Identifier: Apache-2.0
"""`mmcs export film|fmu|mcap`: runs and machines for tools that others wrote."""

from pathlib import Path

import click

from mmcs.errors import InputError
from mmcs.files import short
from mmcs.place import installs, need
from mmcs.screen import echo


def _out(suffix: str):
    def checked(_context, _option, path: Path | None) -> Path | None:
        if path is not None and path.suffix != suffix:
            raise InputError.one("--out", "", str(path), f"must end in {suffix}")
        return path

    return click.option("--out", type=click.Path(path_type=Path), metavar=f"FILE{suffix}",
                        callback=checked, help="The file.")  # fmt: skip


@click.group()
def export() -> None:
    """Write a run or a machine for other tools."""


@export.command()
@click.argument("run", metavar="RUN")
@click.option("--slower", type=click.FloatRange(0.1, 100), default=2.0, help="Times, in the GIF.")
def film(run: str, slower: float) -> None:
    """Draw the arm of a run: film.gif, in the run's folder."""
    from mmcs.folder import whole_file
    from mmcs.view.film import write_gif
    from mmcs.view.runs import read_run

    need(("matplotlib", "PIL"), "film", "film")
    seen = read_run(run)
    with whole_file(seen.folder / "film.gif") as part:
        frames = write_gif(seen, part, slower)
    echo(f"{short(seen.folder / 'film.gif')} ({frames} frames)")


@export.command()
@click.argument("run", metavar="RUN")
@_out(".mcap")
def mcap(run: str, out: Path | None) -> None:
    """Write a run's log as MCAP, for Foxglove and PlotJuggler; RUN as in `mmcs compare`."""
    try:
        from mmcs.view.mcap_file import from_run
    except ImportError:
        raise InputError.one("mcap", "", None, f"is not installed: {installs('tool')}") from None
    from mmcs.folder import check_file, whole_file
    from mmcs.view.runs import read_run

    seen = read_run(run)
    path = check_file(out or seen.folder / "log.mcap")
    with whole_file(path) as part:
        part.write_bytes(from_run(seen))
    echo(f"mmcs: {short(path)}")


@export.command()
@click.argument("scenario", default="lab500", metavar="SCENARIO")
@_out(".fmu")
@click.option("--motions", is_flag=True, help="The unit does what the scenario says, by itself.")
def fmu(scenario: str, out: Path | None, motions: bool) -> None:
    """Write a scenario's machine as a co-simulation unit, FMI 3.0, for this kind of computer."""
    from mmcs.bridge.fmu import write
    from mmcs.folder import check_file, whole_file
    from mmcs.scenario.load import load

    setup = load(scenario, ())
    path = check_file(out or Path(f"{setup.name}.fmu"))
    with whole_file(path) as part:
        write(setup, part, motions)
    echo(f"mmcs: {short(path)}")
