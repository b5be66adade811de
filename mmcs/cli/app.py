# SPDX-License-Identifier: Apache-2.0
"""The command line. Heavy imports happen inside the commands: `mmcs list` answers at once."""

import errno
import os
import signal
import sys
import threading
from contextlib import contextmanager, suppress
from pathlib import Path

import click

from mmcs import __version__
from mmcs.cli.again import replay, trace
from mmcs.cli.campaign import campaign
from mmcs.cli.design import design
from mmcs.cli.device import exec_, serve
from mmcs.cli.export import export
from mmcs.cli.lab import lab
from mmcs.cli.sweep import sweep
from mmcs.cli.tool import tool
from mmcs.cli.view import compare, faults
from mmcs.errors import InputError, RunError, out_of_memory
from mmcs.place import BUILD, results
from mmcs.screen import echo

LONGEST = 200  # letters of a word in a message
GROUPS = {
    "Run": "run compile list show check faults replay",
    "Look": "tool trace compare",
    "Program": "serve exec",
    "Study": "design sweep campaign lab",
    "Export": "export",
}
EXAMPLES = {
    "run": "lab500 --set axis.0.b0=72", "list": "", "show": "puma560", "check": "my.toml",
    "faults": "encoder", "replay": "lab500", "tool": "lab500", "trace": "lab500 --at 0.05",
    "compare": "lab500 lab500_nocomp", "serve": "puma560 --realtime", "compile": "lab500",
    "exec": "--scenario lab500 -- ./bounce", "design": "--wn 80 --robot lab500 --toml",
    "sweep": "lab500 --grid axis.0.b0=60,64,68", "campaign": "arm_move --faults 100",
    "lab": "start 1", "export": "film puma560_reach",
}  # fmt: skip
SET_HELP = "Override a key of the scenario, e.g. host.cpu_us_per_axis=0."


class Group(click.Group):
    """Bad input of any kind ends in one line and status 2, a failed run in status 1."""

    def main(self, *args, **kwargs):
        try:
            with _ends_like_ctrl_c():
                return super().main(*args, **{**kwargs, "standalone_mode": False})
        except click.exceptions.NoArgsIsHelpError as error:
            echo(error.format_message())
            sys.exit(2)
        except click.ClickException as error:
            words = error.format_message().split()
            _fail(" ".join(w if len(w) <= LONGEST else w[:LONGEST] + "..." for w in words), 2)
        except InputError as error:
            _fail(str(error), 2)
        except RunError as error:
            _fail(str(error), 1)
        except (KeyboardInterrupt, click.Abort) as error:
            number = (error.__cause__ or error).args or (signal.SIGINT,)
            eval("0")  # else Python ends by SIGINT where it came within an exec() of a text
            _fail("stopped", 128 + number[0])
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # the reader has seen enough
            sys.exit(0)
        except (MemoryError, ImportError, OSError) as error:
            if out_of_memory(error):
                _fail("out of memory; ask for less at once", 1)
            if not isinstance(error, OSError):
                raise
            where = f"{error.filename}: " if error.filename else ""
            if error.errno in (errno.ENOSPC, errno.EDQUOT):
                _fail(f"{where}no room is left on the disk: free some and run it again", 1)
            _fail(f"{where}{error.strerror or error}", 1)  # a folder that went away

    def format_commands(self, ctx, formatter) -> None:
        """As click does it, in groups."""
        for title, names in GROUPS.items():
            rows = [
                (name, self.commands[name].get_short_help_str(LONGEST)) for name in names.split()
            ]
            with formatter.section(title):
                formatter.write_dl(rows)


@contextmanager
def _ends_like_ctrl_c():
    """So do SIGTERM and SIGHUP: what is half done is cleared away, what is done is kept."""

    def end(number, _frame):
        raise KeyboardInterrupt(number)

    before = {}
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) == signal.SIG_DFL:  # not as under nohup
                before[number] = signal.signal(number, end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _fail(text: str, status: int):
    with suppress(OSError):  # nobody hears it
        echo(f"mmcs: {text}", err=True)
    sys.exit(status)


@click.group(cls=Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mmcs")
def main() -> None:
    """MMCS, the Modular Motor Control System, complete in simulation."""


_scenario = click.argument("scenario", metavar="SCENARIO")
_host = click.option("--host", metavar="native|m68020", help="What runs the firmware.")


@main.command("list")
def list_() -> None:
    """List the scenarios."""
    from mmcs.scenario.files import description, named

    found = named()
    width = max((len(name) for name in found), default=0)
    for name, path in found.items():
        echo(f"{name:{width}}  {description(path)}")


@main.command()
@_scenario
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
def show(scenario: str, sets: tuple[str, ...]) -> None:
    """Show what a scenario contains, robot and defaults included."""
    from mmcs.scenario.describe import show_setup
    from mmcs.scenario.load import load

    show_setup(load(scenario, sets))


@main.command()
@_scenario
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
def check(scenario: str, sets: tuple[str, ...]) -> None:
    """Explain every mistake in a scenario and its robot file, or in a robot file alone."""
    from mmcs.runs.machine import compiled
    from mmcs.scenario.describe import cautions
    from mmcs.scenario.files import is_robot
    from mmcs.scenario.load import load

    if is_robot(scenario):
        _check_robot(scenario, sets)
        return

    with _every_mistake():
        setup = load(scenario, sets)
        if setup.scenario.card:
            compiled(setup)  # mistakes of cards, and upsets of their registers
    for text in cautions(setup):
        echo(f"caution: {text}")
    echo(f"{setup.path}: good; axes {setup.axes}, motions {len(setup.segments)}")


@contextmanager
def _every_mistake():
    try:
        yield
    except InputError as error:
        for mistake in error.mistakes:
            echo(f"mmcs: {mistake}", err=True)
        sys.exit(2)


def _check_robot(name: str, sets: tuple[str, ...]) -> None:
    from mmcs.scenario.describe import robot_cautions
    from mmcs.scenario.load import load_robot

    if sets:
        raise InputError.one("--set", "", None, "overrides keys of scenarios, not of robot files")
    with _every_mistake():
        path, robot = load_robot(name)
    for text in robot_cautions(robot):
        echo(f"caution: {text}")
    number, arm = robot.axes(), "an arm" if robot.link else "each on its own"
    echo(f"{path}: good; robot of {number} {'axis' if number == 1 else f'axes, {arm}'}")


@main.command()
@_scenario
@click.option("--duration", type=float, metavar="S", help="Seconds of motion.")
@click.option("--out", type=click.Path(path_type=Path), metavar="DIR", help="Where results go.")
@_host
@click.option("--trace", type=click.Path(path_type=Path), metavar="FILE.fst", help="Record waves.")
@click.option("--realtime", is_flag=True, help="Not faster than the clock on the wall.")
@click.option("--seed", type=int, metavar="N", help="Seed of the random numbers.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
@click.option("--card", "cards", multiple=True, metavar="FILE.sv", help="Add a card of one's own.")
@click.option("--bus", is_flag=True, help="Write bus.csv, the cycles of the VME bus.")
def run(scenario, duration, out, host, trace, realtime, seed, sets, cards, bus) -> None:
    """Run a scenario and judge it: status 0 done, 1 an expectation failed, 2 bad input."""
    from mmcs.engine import hosts

    hosts.check(host or "native")
    if trace is not None and trace.suffix != ".fst":
        raise InputError.one("--trace", "", str(trace), "must be a file name ending in .fst")
    from functools import partial

    from mmcs.runs.runner import run_scenario, simulate
    from mmcs.scenario.load import load

    added = [_card(name) for name in cards] or None
    setup = load(scenario, sets, duration=duration, seed=seed, card=added)
    host = host or setup.host
    name = setup.name if host == "native" else f"{setup.name}-{host}"
    folder = out or results("runs", setup.path) / name
    carry_out = partial(simulate, trace=trace, realtime=realtime, host=host, bus=bus)
    good = run_scenario(setup, folder, trace=trace, host=host, carry_out=carry_out)
    sys.exit(0 if good else 1)


def _card(name: str) -> dict:
    from mmcs.files import MAX_TOML, read_text

    try:
        read_text(Path(name), MAX_TOML)
    except ValueError as error:
        raise InputError.one("--card", "", name, str(error)) from None
    return {"file": str(Path(name).absolute())}


@main.command("compile")
@_scenario
@click.option("-o", "--out", type=click.Path(path_type=Path), metavar="FILE", help="Where to.")
@click.option("--set", "sets", multiple=True, metavar="KEY=VALUE", help=SET_HELP)
@_host
@click.option("--cflags", is_flag=True, help="Print flags for gcc: a C program with this machine.")
@click.option("--libs", is_flag=True, help="Print what it is linked with.")
def compile_(scenario, out, sets, host, cflags, libs) -> None:
    """Compile a scenario into a set-up file, for `mmcs run FILE`, `make dpi` and C programs."""
    from mmcs.engine import hosts
    from mmcs.files import short
    from mmcs.folder import check_file
    from mmcs.runs.machine import library_of, linked, write_setup
    from mmcs.scenario.load import load

    host, setup = hosts.check(host or "native"), load(scenario, sets)
    if out is None:
        (BUILD / "setups").mkdir(parents=True, exist_ok=True)
    path = check_file(out or BUILD / "setups" / f"{setup.name}.bin")
    write_setup(setup, path, host)
    if not cflags and not libs:
        echo(f"mmcs: {short(path)}")
        return
    from mmcs.device import execute

    words = execute.cflags(modern=True) if cflags else []
    words += linked(path.absolute(), library_of(setup), cflags, libs)
    echo(" ".join(words))


for _command in (campaign, compare, design, exec_, export, faults, lab, replay, serve, sweep,
                 tool, trace):  # fmt: skip
    main.add_command(_command)
for _name, _example in EXAMPLES.items():
    main.commands[_name].epilog = f"Example: mmcs {_name} {_example}".rstrip()
