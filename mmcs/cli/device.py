# SPDX-License-Identifier: Apache-2.0
"""`mmcs serve` and `mmcs exec`: the machine for other programs."""

import signal
import sys
from pathlib import Path

import click

from mmcs.errors import InputError
from mmcs.screen import echo

OWN = ("axis", "servo", "motion", "call", "process", "program")  # what a program does itself
_speed = click.option("--speed", type=float, metavar="X", help="Simulated seconds per second.")
_realtime = click.option("--realtime", is_flag=True, help="The same as --speed 1.")
_lockstep = click.option(
    "--lockstep", is_flag=True, help="Time passes only while every program waits: runs repeat."
)


def _pace(realtime: bool, speed: float | None, lockstep: bool) -> float | None:
    if speed is not None and not speed > 0:
        raise InputError.one("--speed", "", speed, "must be a positive number")
    if realtime and speed is not None:
        raise InputError.one("--speed", "", speed, "not together with --realtime")
    if lockstep and (realtime or speed is not None):
        raise InputError.one("--lockstep", "", None, "not together with --speed or --realtime")
    return 1.0 if realtime else speed


def _with_results(scenario: str, sets: tuple[str, ...], command: list[str], out: Path) -> int:
    from mmcs.device.execute import check_program
    from mmcs.runs import runner
    from mmcs.scenario.load import load

    check_program(command[0])
    return runner.run_program(load(scenario, sets), command, out)


def _machine(scenario: str, sets: tuple[str, ...] = ()):
    """The powered machine of a scenario, and what is told of it; nothing is configured, that is the
    program's job."""
    from mmcs import setup_file
    from mmcs.engine.build import ensure_library
    from mmcs.engine.sim import Sim

    told, setup = setup_file.kept(scenario, sets, lambda: _compiled(scenario, sets))
    return Sim(ensure_library(*told["library"]), setup), told["about"]


def _compiled(scenario: str, sets: tuple[str, ...]) -> tuple[dict, bytes]:
    from mmcs.runs.machine import compiled
    from mmcs.scenario.load import load

    setup = load(scenario, sets)
    about, its = {"scenario": scenario, "machine": setup.about()}, setup.scenario
    library = its.cards, "speed", its.clk_hz, its.heartbeat_us
    return {"library": library, "about": about}, compiled(setup)


@click.command()
@click.argument("scenario", metavar="SCENARIO")
@_realtime
@_speed
@_lockstep
@click.option("--dev", "name", default="mc0", metavar="NAME", help="Name of the server.")
def serve(scenario: str, realtime: bool, speed: float | None, lockstep: bool, name: str) -> None:
    """Offer /dev/mc0 and /dev/vme16 of a scenario's machine to other processes.

    Time passes while a program holds a device open. What the driver says comes on stderr. Ends with
    Ctrl-C or SIGTERM.
    """
    from mmcs.device.execute import say
    from mmcs.device.server import Server
    from mmcs.device.sockets import socket_path

    pace = _pace(realtime, speed, lockstep)
    if not name.replace("-", "").replace("_", "").isalnum():
        raise InputError.one("--dev", "", name, "must be letters, digits, - and _")
    sim, about = _machine(scenario)
    with sim:
        server = Server(sim, socket_path(name), pace, about, console=say, lockstep=lockstep)

        def stop(*_):
            server.stopping = True

        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) != signal.SIG_IGN:  # as under nohup
                signal.signal(number, stop)
        dev = "" if name == "mc0" else f"--dev {name} "
        echo(f"serving {scenario} as {name}; run programs with: mmcs exec {dev}-- PROGRAM")
        try:
            server.run()
        finally:
            server.close()


@click.command("exec", context_settings={"ignore_unknown_options": True})
@click.option("--scenario", metavar="S", help="Run a machine of one's own, not a server's.")
@_realtime
@_speed
@_lockstep
@click.option("--dev", "name", default="mc0", metavar="NAME", help="Name of the server to use.")
@click.option("--out", type=click.Path(path_type=Path), metavar="DIR", help="Results, as of a run.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help="Override a key.")
@click.option("--cflags", "show_flags", is_flag=True, help="Print the flags for gcc and end.")
@click.option("--modern", is_flag=True, help="With --cflags: C or C++ of today, warnings on.")
@click.option("--robot", metavar="R", help="Print a robot's joints as a C header and end.")
@click.option("--interval", default=1000, metavar="US", help="With --robot: servo period.")
@click.argument("command", nargs=-1, type=click.UNPROCESSED, metavar="-- PROGRAM [ARGS...]")
def exec_(scenario, realtime, speed, lockstep, name, out, sets, show_flags, modern, robot,
          interval, command):  # fmt: skip
    """Run an unmodified program that opens /dev/mc0 or /dev/vme16."""
    from mmcs.device.execute import cflags, run_program

    if robot is not None:
        from mmcs.scenario.robot_header import header

        echo(header(robot, interval).rstrip())
        return
    if show_flags:
        echo(" ".join(cflags(modern)))
        return
    pace = _pace(realtime, speed, lockstep)
    if not command:
        raise InputError.one("mmcs exec", "", None, "name the program to run after --")
    for text in sets:
        if text.partition("=")[0].partition(".")[0] in OWN:
            raise InputError.one("--set", "", text, "is the program's own job, and no use here")
    if scenario is None:
        if pace is not None or lockstep:
            raise InputError.one("mmcs exec", "", None, "the pace is the server's; give --scenario")
        if out or sets:
            allowed = "--out and --set go with --scenario"
            raise InputError.one("mmcs exec", "", None, allowed)
        sys.exit(run_program(list(command), name=name))
    if out is not None:
        if pace is not None:
            raise InputError.one("--out", "", str(out), "a run with results is in lock-step")
        sys.exit(_with_results(scenario, sets, list(command), out))
    sim, _ = _machine(scenario, sets)
    with sim:
        status = run_program(list(command), sim, pace, lockstep=lockstep)
    sys.exit(status)
