# SPDX-License-Identifier: Apache-2.0
"""When what happens in a trace: the first whole servo pass, from SCLOCK to the last D/A write."""

from pathlib import Path
from typing import NamedTuple

LEAST_MS = 0.001  # of a trace: one of no clock at all is no file that a viewer reads


class Pass(NamedTuple):
    """Times in units of the trace."""

    sclock: int
    acknowledge: int
    first_read: int
    last_write: int


def first_pass(trace: Path, machine: str) -> Pass | None:
    """The first servo pass in the trace from its SCLOCK to the next one; None: there is none."""
    import pywellen

    found = {var.full_name: var for var in pywellen.Waveform(str(trace)).all_vars()}

    def edges(path: str, to: int) -> list[int]:
        changes = [(time, int(value)) for time, value in found[f"{machine}.{path}"].tv]
        pairs = zip(changes, changes[1:], strict=False)
        return [time for (_, before), (time, after) in pairs if before != after == to]

    clocks = edges("sclock_o", 1)
    acks = edges("u_adaptor.vme_iackin_ni", 0)
    reads, writes = edges("pcx_ior_no", 0), edges("pcx_iow_no", 1)
    for begin, end in zip(clocks, clocks[1:], strict=False):
        ack = next((t for t in acks if begin <= t < end), None)
        if ack is None:
            continue
        read = next((t for t in reads if ack <= t < end), None)
        last = next((t for t in reversed(writes) if ack <= t < end), None)
        if read is not None and last is not None and read < last:
            return Pass(begin, ack, read, last)
    return None
