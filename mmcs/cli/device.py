# SPDX-License-Identifier: Apache-2.0
"""`mmcs serve` and `mmcs exec`: the machine for other programs."""

from __future__ import annotations

import signal
import sys

import click

from mmcs.errors import InputError
from mmcs.screen import echo

_speed = click.option("--speed", type=float, metavar="X", help="Simulated seconds per second.")
_realtime = click.option("--realtime", is_flag=True, help="The same as --speed 1.")


def _pace(realtime: bool, speed: float | None) -> float | None:
    if speed is not None and not speed > 0:
        raise InputError.one("--speed", "", speed, "must be a positive number")
    if realtime and speed is not None:
        raise InputError.one("--speed", "", speed, "not together with --realtime")
    return 1.0 if realtime else speed


def _machine(scenario: str):
    """The powered machine of a scenario, and what is told of it; nothing is configured, that is the
    program's job."""
    from mmcs.engine.build import ensure_library
    from mmcs.engine.sim import Sim
    from mmcs.scenario.load import load

    setup = load(scenario, ())
    s = setup.scenario
    library = ensure_library(s.cards, "speed", s.clk_hz)
    config, motors, links = setup.config(), setup.motors(), setup.links()
    machine = {"gravity": config["gravity"], "motors": motors, "links": setup.robot.links()}
    return Sim(library, config, motors, links), {"scenario": scenario, "machine": machine}


@click.command()
@click.argument("scenario", metavar="SCENARIO")
@_realtime
@_speed
@click.option("--dev", "name", default="mc0", metavar="NAME", help="Name of the server.")
def serve(scenario: str, realtime: bool, speed: float | None, name: str) -> None:
    """Offer /dev/mc0 and /dev/vme16 of a scenario's machine to other processes.

    Time passes while a program holds a device open. What the driver says comes on stderr. Ends with
    Ctrl-C or SIGTERM.
    """
    from mmcs.device.execute import say
    from mmcs.device.server import Server
    from mmcs.device.sockets import socket_path

    pace = _pace(realtime, speed)
    if not name.replace("-", "").replace("_", "").isalnum():
        raise InputError.one("--dev", "", name, "must be letters, digits, - and _")
    sim, about = _machine(scenario)
    with sim:
        server = Server(sim, socket_path(name), pace, about, console=say)

        def stop(*_):
            server.stopping = True

        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) != signal.SIG_IGN:  # as under nohup
                signal.signal(number, stop)
        echo(f"serving {scenario} as {name}; run programs with: mmcs exec -- PROGRAM")
        try:
            server.run()
        finally:
            server.close()


@click.command("exec", context_settings={"ignore_unknown_options": True})
@click.option("--scenario", metavar="S", help="Run a machine of one's own, not a server's.")
@_realtime
@_speed
@click.option("--dev", "name", default="mc0", metavar="NAME", help="Name of the server to use.")
@click.option("--cflags", "show_flags", is_flag=True, help="Print the flags for gcc and end.")
@click.option("--modern", is_flag=True, help="With --cflags: C of today (gnu17), warnings on.")
@click.argument("command", nargs=-1, type=click.UNPROCESSED, metavar="-- PROGRAM [ARGS...]")
def exec_(scenario, realtime, speed, name, show_flags, modern, command) -> None:
    """Run an unmodified program that opens /dev/mc0 or /dev/vme16."""
    from mmcs.device.execute import cflags, run_program

    if show_flags:
        echo(" ".join(cflags(modern)))
        return
    pace = _pace(realtime, speed)
    if not command:
        raise InputError.one("mmcs exec", "", None, "name the program to run after --")
    if scenario is None:
        if pace is not None:
            raise InputError.one("mmcs exec", "", None, "the pace is the server's; give --scenario")
        sys.exit(run_program(list(command), name=name))
    sim, _ = _machine(scenario)
    with sim:
        status = run_program(list(command), sim, pace)
    sys.exit(status)
