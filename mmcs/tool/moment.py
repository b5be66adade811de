# SPDX-License-Identifier: Apache-2.0
"""Waveforms from a moment of the past of a served machine.

The machine goes on meanwhile: one of its trace build is made beside it, put into the snapshot's
state and run for some milliseconds. It is the same machine to the bit, but nobody writes to it.
"""

from __future__ import annotations

from pathlib import Path

from mmcs.device.link import Link
from mmcs.place import BUILD

MOST_MS = 20.0


def waves(socket: Path, snapshot: int, ms: float) -> dict:
    """The trace and its view; opened in gtkwave where there is a display. Raises ValueError."""
    if not 0 < ms <= MOST_MS:
        raise ValueError(f"waveforms: take up to {MOST_MS:g} ms, not {ms:g}")
    with Link(path=socket) as link:
        scenario = link.hello["scenario"]
        data = Path(link.request("export", snapshot=snapshot)["file"]).read_bytes()
    size = int.from_bytes(data[:8], "little")
    return trace(scenario, data[8 : 8 + size], data[8 + size :], ms)


def trace(scenario: str, snapshot: bytes, past: bytes, ms: float) -> dict:
    from mmcs.scenario.load import load
    from mmcs.session.machine import machine
    from mmcs.view.waves import start_viewer, write_views

    setup = load(scenario, ())
    folder = BUILD / "tool"
    folder.mkdir(parents=True, exist_ok=True)
    with machine(setup, "trace") as sim:
        sim.restore_bytes(snapshot, past)
        began = sim.time
        path = folder / f"{setup.name}_{began:.6f}.fst"
        sim.trace(path)
        sim.run(began + ms / 1000)
    view, _ = write_views(path)
    return {"file": str(path), "view": str(view), "t": began, "opened": start_viewer(path)}
