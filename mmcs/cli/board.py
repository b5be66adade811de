# SPDX-License-Identifier: Apache-2.0
"""`mmcs board`: a card on a board, over its serial line."""

import math
from contextlib import contextmanager

import click

from mmcs.errors import InputError
from mmcs.screen import echo

_port = click.option(
    "--port", default="/dev/ttyUSB0", metavar="PORT", help="The board's serial port; /dev/ttyUSB0."
)
_wait = click.option(
    "--wait", type=float, default=0.1, metavar="S", help="How long an answer may take; 0.1 s."
)


@contextmanager
def _line(port: str, wait: float):
    from mmcs.device.board_line import Line, open_port

    if not 0 < wait < math.inf:
        raise InputError.one("--wait", "", wait, "must be a positive number of seconds")
    with open_port(port, wait) as opened:
        line = Line(opened, port)
        yield line
        if line.repeats:
            echo(f"caution: {line.repeats} requests had to be sent again: check cable and ground")


@click.group()
def board() -> None:
    """A card on a board, over its serial line: registers and a self-test (docs: bringup)."""


@board.command()
@click.argument("addr", metavar="ADDR")
@_port
@_wait
def read(addr: str, port: str, wait: float) -> None:
    """Read the register at ADDR: an odd offset of the VME window, or its name, such as PCCSR."""
    from mmcs.device.board_line import check_offset

    offset = check_offset(addr)
    with _line(port, wait) as line:
        echo(f"0x{line.read(offset):02X}")


@board.command()
@click.argument("addr", metavar="ADDR")
@click.argument("value", metavar="VALUE")
@_port
@_wait
def write(addr: str, value: str, port: str, wait: float) -> None:
    """Write a byte to the register at ADDR."""
    from mmcs.device.board_line import check_offset, check_value

    offset, byte = check_offset(addr), check_value(value)
    with _line(port, wait) as line:
        line.write(offset, byte)


@board.command()
@click.option("--brakes", is_flag=True, help="Also what releases brakes: the load is secured.")
@click.option(
    "--heartbeat-ms", type=float, default=50.0, metavar="MS", help="Of the bitstream; 50 ms."
)
@_port
@_wait
def test(brakes: bool, heartbeat_ms: float, port: str, wait: float) -> None:
    """Test adaptor, cards, registers and counters; with --brakes loop back, heartbeats and PANIC.

    The drives stay isolated. Ends at the first error: status 1, and one sentence with its remedy.
    """
    from mmcs.device.board_test import SelfTest

    if not 1 <= heartbeat_ms <= 100:
        raise InputError.one("--heartbeat-ms", "", heartbeat_ms, "must be 1 to 100 ms")
    with _line(port, wait) as line:
        for sentence in SelfTest(line, heartbeat_ms).run(brakes):
            echo(sentence)
    echo("self-test: good")
