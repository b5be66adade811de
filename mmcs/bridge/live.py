# SPDX-License-Identifier: Apache-2.0
"""A served machine live into PlotJuggler: one JSON object a sample, by UDP, time under "timestamp".

PlotJuggler: Streaming, UDP Server, port 9870, protocol JSON, "use field as timestamp" on.
"""

import json
import socket

from mmcs.device.link import Link, Samples

LINES = ("panic", "brakes_released", "enabled", "stopped", "irq")


def message(row: dict, fields: list[str]) -> bytes:
    """A row as Samples.row() has it, of the fields that the server's hello tells."""
    axes = [dict(zip(fields, values, strict=True)) for values in row["axes"]]
    named = {f"axis{n}": axis for n, axis in enumerate(axes)}
    lines = {name: row["lines"] >> bit & 1 for bit, name in enumerate(LINES)}
    return json.dumps({"timestamp": row["t"], "mmcs": named | {"lines": lines}}).encode()


def send(link: Link, address: tuple[str, int], every: int = 1, samples: int | None = None) -> int:
    """Every n-th sample from now on, until the machine is gone or so many are sent; how many."""
    sent = 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        link.request("follow", every=every, events=False)
        while samples is None or sent < samples:
            got = link.receive()
            if not isinstance(got, Samples):
                continue
            for n in range(got.rows if samples is None else min(got.rows, samples - sent)):
                out.sendto(message(got.row(n), link.hello["sample"]["fields"]), address)
                sent += 1
    return sent
