# SPDX-License-Identifier: Apache-2.0
"""Waveforms around a moment of the past of a served machine.

The machine goes on meanwhile: another is made beside it, put into the state of the last snapshot
before and run through those milliseconds. It is the same machine to the bit, but nobody writes to
it: what programs have done since the snapshot, at most 0.1 s before, is missing.
"""

from pathlib import Path
from typing import NamedTuple

from mmcs.device.link import Link
from mmcs.scenario.setup import Setup

MOST_MS = 20.0
BUSY_S = 0.001  # a servo pass is over by then
ROUNDED_S = 1e-6  # the page tells times in whole microseconds, rounded up or down


class Moment(NamedTuple):
    """A stretch of time, and the machine of the last snapshot before it."""

    setup: Setup
    snapshot: bytes
    past: bytes
    from_s: float
    to_s: float


def find(socket: Path, t: float, ms: float) -> Moment:
    """Raises ValueError with one sentence."""
    from mmcs.scenario.load import load

    if not 0 < ms <= MOST_MS:
        raise ValueError(f"waveforms: take up to {MOST_MS:g} ms, not {ms:g}")
    with Link(path=socket) as link:
        kept = link.request("snapshots")["snapshots"]
        now = link.request("hello")["time"]
        first = kept[0]["t"] if kept else now
        if not first - ROUNDED_S <= t <= now + ROUNDED_S:
            raise ValueError(
                f"waveforms: take a moment that is still known, {first:.3f} to {now:.3f} s"
            )
        t = min(max(t, first), now)
        begin = max(first, t - ms / 2000)
        before = [s for s in kept if s["t"] <= begin - BUSY_S] or kept[:1]
        scenario = link.hello["scenario"]
        data = Path(link.request("export", snapshot=before[-1]["id"])["file"]).read_bytes()
    size = int.from_bytes(data[:8], "little")
    state, past = data[8 : 8 + size], data[8 + size :]
    return Moment(load(scenario), state, past, begin, min(now, t + ms / 2000))


def waves(socket: Path, t: float, ms: float) -> dict:
    """What the nets of the prepared view do, as web/wave_data.js has it."""
    from mmcs.engine.own_card import registers
    from mmcs.runs.machine import card_of, machine
    from mmcs.view.watched import changes, groups, nets

    moment = find(socket, t, ms)
    card = card_of(moment.setup)
    own = [name for name in registers(card) if name[-1] != "]"] if card else []
    with machine(moment.setup, skip=False) as sim:
        sim.restore_bytes(moment.snapshot, moment.past)
        sim.run(moment.from_s - BUSY_S)
        own = sim.watch(nets(), own)
        begun, hz = sim.clock, sim.build()["clk_hz"]
        sim.run(moment.to_s)
        begin, end = max(begun, round(moment.from_s * hz)), round(moment.to_s * hz)
        found = changes(sim.changes(), begin, end, len(own))
    return {"clk_hz": hz, "from": begin, "to": end, "groups": groups(own), "nets": found}
