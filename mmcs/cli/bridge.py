# SPDX-License-Identifier: Apache-2.0
"""`mmcs live`, `mmcs mcap`, `mmcs fmu`: samples and machines for tools that others wrote."""

from pathlib import Path

import click

from mmcs.errors import InputError
from mmcs.screen import echo


@click.command()
@click.option("--dev", "name", default="mc0", metavar="NAME", help="Name of the server.")
@click.option("--to", "where", default="127.0.0.1:9870", metavar="HOST:PORT", help="PlotJuggler.")
@click.option("--every", type=click.IntRange(1, 10000), default=1, help="Every n-th sample.")
def live(name: str, where: str, every: int) -> None:
    """Send what a served machine samples to PlotJuggler, as JSON by UDP. Ends with Ctrl-C."""
    from mmcs.bridge.live import send
    from mmcs.device.link import Link

    host, _, port = where.rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise InputError.one("--to", "", where, "must be HOST:PORT")
    with Link(name, timeout=None) as link:
        echo(f"mmcs: {link.hello['scenario']}, {link.hello['axes']} axes, to {where}", err=True)
        send(link, (host, int(port)), every)


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
