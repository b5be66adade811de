# SPDX-License-Identifier: Apache-2.0
"""`mmcs tool`: mctool (§3) in the browser."""

from pathlib import Path

import click

from mmcs.errors import InputError
from mmcs.place import need
from mmcs.screen import echo


@click.command()
@click.argument("scenario", metavar="[SCENARIO]", default="puma560")
@click.option("--attach", type=click.Path(path_type=Path), metavar="SOCKET",
              help="Watch a machine that others drive: socket or name of its server.")  # fmt: skip
@click.option("-t", "interval", type=float, metavar="MS", help="Set the sample interval first.")
@click.option("-u", "frozen", is_flag=True, help="Do not update encoder, A/D and motor current.")
@click.option("-z", "zero", is_flag=True, help="Zero all encoder registers first.")
@click.option("--theme", type=click.Choice(["1989"]), help="How it looked under SunView.")
@click.option("--deadman", type=click.IntRange(100, 10000), metavar="MS",
              help="Silence of a page in control that stops the machine; default 250.")  # fmt: skip
@click.option("--sheets", "own", type=click.Path(path_type=Path), metavar="DIR",
              help="Own lab sheets, as for `mmcs lab`.")  # fmt: skip
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Of the page; default: any.")
@click.option("--no-browser", is_flag=True, help="Only print the address.")
def tool(scenario, attach, interval, frozen, zero, theme, deadman, own, port, no_browser) -> None:
    """Tune and watch the machine: starts it in real time and opens one page.

    Writes nothing at the start unless -t or -z are given. Ends with Ctrl-C or SIGTERM.
    """
    need(("websockets",), "tool", "mmcs tool")
    from mmcs.labs import offered
    from mmcs.runs.machine import library_of
    from mmcs.scenario.load import load
    from mmcs.tool.launch import open_browser, start

    if interval is not None and not 0.1 <= interval <= 1e6:
        raise InputError.one("-t", "", interval, "must be 0.1 to 1000000 ms")
    options = {}
    if interval is not None:
        options["t"] = f"{interval:g}"
    if frozen:
        options["u"] = "1"
    if zero:
        options["z"] = "1"
    if deadman:
        options["deadman"] = str(deadman)
    if theme:
        options["theme"] = theme
    if own:
        own = own.resolve()
        offered("page").load()(own)  # what is wrong with the sheets is told here, in one line
    socket = _socket(attach)
    if socket is None:
        setup = load(scenario)  # its mistakes are told here, in one line
        library_of(setup)  # and that it has to be built
    with start(scenario, socket, options, port, own) as running:
        echo(running.address)
        if not no_browser and not open_browser(running.address):
            echo("open this address in a browser on this machine; Ctrl-C ends the tool")
        running.wait()


def _socket(attach: Path | None) -> Path | None:
    from mmcs.device.sockets import socket_path

    if attach is None:
        return None
    named = len(attach.parts) == 1 and not attach.suffix
    path = socket_path(str(attach)) if named else attach.with_suffix(".sock")
    if not path.is_socket():
        raise InputError.one("--attach", "", str(attach), "no server listens there")
    return path
