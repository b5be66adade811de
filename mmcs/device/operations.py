# SPDX-License-Identifier: Apache-2.0
"""What a client of the messages does to the machine from outside: lease, inputs, pace, the past."""

from __future__ import annotations

from mmcs.device.arguments import Arguments, Refused
from mmcs.device.wire import EBUSY, EINVAL
from mmcs.errors import RunError
from mmcs.inputs import INPUTS

MOST_SNAPSHOTS = 100  # that are kept until dropped


class Operations:
    def __init__(self, server, messenger):
        self._server, self._of = server, messenger
        self._machine, self._client = server.machine, messenger.client

    def must_control(self) -> None:
        if self._machine.held_from(self._client):
            raise Refused(EBUSY, f"{self._machine.lease} has the lease")

    # --- lease ---

    def do_lease(self, a: Arguments) -> dict:
        machine, client = self._machine, self._client
        if "give" in a:
            other = machine.clients.get(a["give"])
            if machine.lease is not client:
                raise Refused(EBUSY, "only the holder can pass the lease on")
            if other is None or not other.device or not other.writable:
                raise Refused(EINVAL, "give: no such client has the device open for writing")
            machine.set_lease(other)
        elif "drop" in a:
            if machine.lease is client:
                machine.set_lease(None)
        else:
            a["take"]
            deadman = a["deadman_ms"] / 1000 if "deadman_ms" in a else None
            self._of.check(machine.take_lease(client, deadman))
        return {"lease": machine.lease.number if machine.lease else None}

    def do_alive(self, a: Arguments) -> dict:
        return {}

    def do_clients(self, a: Arguments) -> dict:
        machine = self._machine
        rows = [
            {"client": c.number, "name": c.name, "pid": c.pid, "kind": c.kind,
             "mode": ("rw" if c.writable else "r") if c.device else "",
             "lease": c is machine.lease}
            for c in machine.clients.values()
        ]  # fmt: skip
        return {"clients": rows}

    # --- inputs ---

    def do_inputs(self, a: Arguments) -> dict:
        wrong = self._machine.wrong_values
        rows = [{"name": n, **known.told(), "values": wrong(n)} for n, known in INPUTS.items()]
        return {"inputs": rows}

    def do_input(self, a: Arguments) -> dict:
        name = a["name"]
        if name not in INPUTS:
            raise Refused(EINVAL, f"name: there is no input {name!r}")
        known = INPUTS[name]
        value = a.number("value", known.low, known.high)
        index = a.integer("index", 0, self._machine.places(name) - 1, 0)
        if (name, value) != ("estop", 1):
            self.must_control()
        if self._machine.set_input(name, index, value) < 0:
            raise Refused(EINVAL, "index: nothing is connected there")
        return {"t": self._machine.sim.time}

    # --- time ---

    def do_pace(self, a: Arguments) -> dict:
        self.must_control()
        pace = self._server.pace
        speed = pace.speed
        if "speed" in a:
            speed = None if a.is_null("speed") else a["speed"]
        paused = a.flag("paused", pace.paused)
        pace.set(speed, paused)
        text = "paused" if paused else "as fast as it goes" if speed is None else f"speed {speed:g}"
        self._machine.sim.tap_note("pace", 0, text)
        return {"speed": speed, "paused": paused}

    def do_advance(self, a: Arguments) -> None:
        self.must_control()
        if not self._server.pace.paused:
            raise Refused(EBUSY, "time passes by itself; pause first")
        if self._server.advances:
            raise Refused(EBUSY, "another client has asked for time to pass already")
        self._server.advance(a["seconds"], self._of, a.id)

    # --- the past ---

    def do_machine(self, a: Arguments) -> dict:
        return dict(self._server.about.get("machine", {}))

    def do_ring(self, a: Arguments) -> dict:
        self.must_control()
        self._machine.history.ring(a["every_s"], a["count"])
        return {}

    def do_snapshot(self, a: Arguments) -> dict:
        if sum(s["kept"] for s in self._machine.history.list()) >= MOST_SNAPSHOTS:
            raise Refused(EBUSY, f"{MOST_SNAPSHOTS} snapshots are kept already; drop one")
        return {"snapshot": self._machine.history.take()}

    def do_snapshots(self, a: Arguments) -> dict:
        return {"snapshots": self._machine.history.list()}

    def do_export(self, a: Arguments) -> dict:
        """The past of a snapshot as a file beside the socket, for a machine of any build
        (mmcs/tool/moment.py)."""
        number = a["snapshot"]
        sim = self._machine.sim
        if number not in [s["id"] for s in sim.snapshots()]:
            raise Refused(EINVAL, "snapshot: there is none of this number")
        path = self._server.path.with_suffix(".past")
        snapshot, past = sim.snapshot_bytes(number), sim.history_bytes()
        path.write_bytes(len(snapshot).to_bytes(8, "little") + snapshot + past)
        return {"file": str(path)}

    def do_drop(self, a: Arguments) -> dict:
        self.must_control()
        try:
            self._machine.sim.drop(a["snapshot"])
        except RunError:
            raise Refused(EINVAL, "snapshot: there is none of this number") from None
        return {}

    def do_rewind(self, a: Arguments) -> dict:
        self.must_control()
        if self._server.advances:
            raise Refused(EBUSY, "another client has asked for time to pass; wait for its end")
        history = self._machine.history
        number = history.last_before(a["t"]) if "t" in a else a["snapshot"]
        if number is None or not history.rewind(number):
            raise Refused(EINVAL, "snapshot: there is none of this number or time")
        self._server.pace.restart()
        return {"t": self._machine.sim.time, "snapshot": number}
