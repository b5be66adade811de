# SPDX-License-Identifier: Apache-2.0
"""When what happens in a trace: the first whole servo pass, from SCLOCK to the last D/A write,
the first SCLOCK that was missed, and the first PANIC."""

from bisect import bisect
from pathlib import Path
from typing import NamedTuple

LEAST_MS = 0.001  # of a trace: one of no clock at all is no file that a viewer reads


class Pass(NamedTuple):
    """Times in units of the trace."""

    sclock: int
    acknowledge: int
    first_read: int
    last_write: int


def variables(trace: Path) -> dict:
    """What is in a trace, by path."""
    import pywellen

    return {var.full_name: var for var in pywellen.Waveform(str(trace)).all_vars()}


def _nets(found: dict, machine: str):
    """A function that gives a net's times and values, of the machine's nets by their paths."""
    return lambda path: [(time, int(value)) for time, value in found[f"{machine}.{path}"].tv]


def _edges(changes: list[tuple[int, int]], to: int) -> list[int]:
    """When a net comes to a level."""
    pairs = zip(changes, changes[1:], strict=False)
    return [time for (_, before), (time, after) in pairs if before != after == to]


def first_missed(found: dict, machine: str) -> int | None:
    """The first SCLOCK edge in the trace at which its latch is still set; None: there is none."""
    net = _nets(found, machine)
    latch = net("u_adaptor.u_core.u_pccsr.sclock_latch_q")
    times = [time for time, _ in latch]
    for clock in _edges(net("sclock_o"), 1):
        before = bisect(times, clock)
        if before and latch[before - 1][1]:
            return clock
    return None


def first_panic(found: dict, machine: str) -> int | None:
    """The first rise of PANIC in the trace; None: there is none."""
    rises = _edges(_nets(found, machine)("u_adaptor.panic_o"), 1)
    return next(iter(rises), None)


def first_pass(found: dict, machine: str) -> Pass | None:
    """The first servo pass in the trace from its SCLOCK to the next one; None: there is none."""
    net = _nets(found, machine)
    clocks = _edges(net("sclock_o"), 1)
    acks = _edges(net("u_adaptor.vme_iackin_ni"), 0)
    reads, writes = _edges(net("pcx_ior_no"), 0), _edges(net("pcx_iow_no"), 1)
    for begin, end in zip(clocks, clocks[1:], strict=False):
        ack = next((t for t in acks if begin <= t < end), None)
        if ack is None:
            continue
        read = next((t for t in reads if ack <= t < end), None)
        last = next((t for t in reversed(writes) if ack <= t < end), None)
        if read is not None and last is not None and read < last:
            return Pass(begin, ack, read, last)
    return None
