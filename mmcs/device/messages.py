# SPDX-License-Identifier: Apache-2.0
"""The server's end of the messages: see docs/use/protocol.md, whose words the names here are."""

import errno
import json
import os
import re
import select
import socket
import struct
import time

from mmcs import ROOT, mcdef
from mmcs.device.connection import Connection
from mmcs.device.machine import Machine
from mmcs.device.wire import EBUSY, EINVAL, EIO
from mmcs.inputs import INPUTS

PROTOCOL = 1
LIMIT = 65536
LENGTH = struct.Struct("<I")
HEAD = struct.Struct("<4sIIHHdd")
FIELDS = ("adcvai", "encnow", "inow", "error", "fbnow", "vel", "errcode",
          "setpoint", "demand", "current")  # fmt: skip
ROWS_AT_ONCE, EVENTS_AT_ONCE = 512, 256
TABLE = ROOT / "sim" / "service" / "messages.def"
REQUESTS = re.findall(r"\bOP\((\w+)\)", TABLE.read_text())
# Not served while somebody else's request waits: they let time pass, or do away with it.
WAITING = ("close", "snapshot", "rewind", "advance", "ring", "drop", "lease", "setpoint")


class Refused(Exception):
    """A request cannot be done: the driver's errno, and a sentence."""

    def __init__(self, number: int, text: str = ""):
        super().__init__(text)
        self.number, self.text = number, text


class Stream:
    """What a client follows: his place in both rings."""

    def __init__(self, machine: Machine, a: dict):
        self._sim = machine.sim
        self.samples, self.events = a["samples"], a["events"]
        self.every = a["every"]
        self.period = a["period_ms"] / 1000
        rows, events, self.row_bytes = self._sim.tap_head()
        self.row = max(0, rows - a["past"])
        self.event, self.lost, self.due = events, 0, 0.0

    def take_samples(self, axes: int, cards: int) -> bytes:
        """One message; empty when there is nothing new."""
        start = self.row
        rows, count, self.row, lost = self._sim.tap_rows(start, self.every, ROWS_AT_ONCE)
        self.lost += lost
        if not count:
            return b""
        first = self.row - count * self.every
        head = HEAD.pack(b"S1\0\0", count, self.row_bytes, axes, cards, self.lost, first)
        return head + rows

    def take_events(self) -> list[dict]:
        events, self.event, lost = self._sim.tap_events(self.event, EVENTS_AT_ONCE)
        told = [{"type": "lost", "events": lost}] if lost else []
        return told + [{"type": "event", **e} for e in events]


class Messenger(Connection):
    """A client of the messages."""

    def __init__(self, sock: socket.socket, poll: select.epoll, address, server):
        super().__init__(sock, poll)
        self._server, self.machine = server, server.machine
        self.client = self.machine.enter("message", _pid(sock))
        self._stream: Stream | None = None
        self.tell(self._hello())

    def leave(self) -> None:
        self.machine.leave(self.client)

    # --- carrying ---

    def tell(self, message: dict) -> None:
        self._carry(json.dumps(message, separators=(",", ":")).encode())

    def _carry(self, message: bytes) -> None:
        self.send(LENGTH.pack(len(message)) + message)

    def receive(self) -> bool:
        heard = super().receive()
        if heard or self.has_request():
            self.client.heard = time.monotonic()
        return heard

    def has_request(self) -> bool:
        if len(self.data) < LENGTH.size or self.ended:
            return False
        (length,) = LENGTH.unpack_from(self.data)
        if not 0 < length <= LIMIT:
            self.end()
            return False
        return len(self.data) >= LENGTH.size + length

    def client_writes(self) -> bool:
        return self.client.writable

    def serve(self, nested: bool) -> bool:
        (length,) = LENGTH.unpack_from(self.data)
        try:
            message = json.loads(self.data[LENGTH.size : LENGTH.size + length])
        except (ValueError, RecursionError):
            message = None
        if type(message) is not dict:
            self.end()
            return True
        op = message.get("op")
        if nested and self._waits(op, message):
            return False
        del self.data[: LENGTH.size + length]
        if isinstance(message.get("id"), list | dict):
            self.answer(None, _refusal(Refused(EINVAL, "id: a number or a text")))
            return True
        self.busy = True
        reply = self._reply(op, message)
        if reply is not None:
            self.answer(message.get("id"), reply)
        return True

    def fail(self, why: str) -> None:
        self.answer(None, _refusal(Refused(EIO, why)))

    def answer(self, id_: object, reply: dict) -> None:
        self.busy = False
        self.tell({"type": "reply", "id": id_, **reply})

    def _waits(self, op: object, message: dict) -> bool:
        if op == "call":
            request = message.get("request")
            return type(request) is str and mcdef.constants().get(request) in self.machine.waits
        return op in WAITING

    def _reply(self, op: object, message: dict) -> dict | None:
        """None: it comes later. sim/service checks what is asked, and does what needs no more than
        the machine; the rest is here."""
        machine, client = self.machine, self.client
        try:
            done = machine.sim.request(message, client.driver, client.writable, self._held())
            if "errno" in done:
                raise Refused(done["errno"], done["text"])
            if op == "call":
                machine.called(client, mcdef.constants()[message["request"]])
            if more := getattr(self, f"do_{op}", None):
                done = more(done | {"id": message.get("id")})
            return None if done is None else {"ok": True, **done}
        except Refused as no:
            return _refusal(no)
        except OSError as error:  # a file: a full disk, a folder in its place
            what = f"{error.filename}: {error.strerror}" if error.filename else str(error)
            return _refusal(Refused(error.errno or EIO, what))

    def _held(self) -> str | None:
        """Why this client may change nothing now."""
        machine = self.machine
        return f"{machine.lease} has the lease" if machine.held_from(self.client) else None

    @staticmethod
    def _check(result: int) -> None:
        if result < 0:
            raise Refused(-result)

    # --- the stream ---

    def do_follow(self, a: dict) -> dict:
        self._stream = Stream(self.machine, a)
        return {}

    def do_unfollow(self, a: dict) -> dict:
        self._stream = None
        return {}

    def stream(self, now: float) -> None:
        """Sends what is due, as far as the client takes it: what he leaves stays in the ring."""
        s = self._stream
        if s is None or now < s.due or not self.idle():
            return
        s.due = now + s.period
        events = s.take_events() if s.events else []
        for event in events:
            self.tell(event)
        while s.samples and self.idle():
            samples = s.take_samples(2 * self.machine.cards, self.machine.cards)
            if not samples:
                break
            self._carry(samples)

    # --- the device ---

    def _hello(self) -> dict:
        server, machine = self._server, self.machine
        sample = {"fields": list(FIELDS), "row_bytes": machine.sim.tap_head()[2]}
        return {
            "type": "hello", "protocol": PROTOCOL, "you": self.client.number,
            "server": server.name.path.stem, "scenario": server.about.get("scenario"),
            "axes": 2 * machine.cards, "cards": machine.cards, "time": machine.sim.time,
            "speed": server.pace.speed, "paused": server.pace.paused,
            "lockstep": server.lockstep.on, "opens": machine.opens,
            "lease": machine.lease.number if machine.lease else None, "sample": sample,
            **machine.state(),
        }  # fmt: skip

    def do_hello(self, a: dict) -> dict:
        return {k: v for k, v in self._hello().items() if k != "type"}

    def do_name(self, a: dict) -> dict:
        self.client.name = "".join(c for c in a["name"][:64] if c.isprintable())
        return {}

    def do_open(self, a: dict) -> dict:
        flags = os.O_RDWR if a["mode"] == "rw" else os.O_RDONLY
        self._check(self.machine.open(self.client, "/dev/mc0", flags))
        return {}

    def do_close(self, a: dict) -> dict:
        if self.machine.lease is self.client:
            self.machine.set_lease(None)
        self._check(self.machine.close(self.client))
        return {}

    def do_stop(self, a: dict) -> dict:
        self._check(self.machine.stop(self.client.pid))
        return {"t": self.machine.sim.time}

    # --- who is there ---

    def do_lease(self, a: dict) -> dict:
        machine, client = self.machine, self.client
        if "give" in a:
            other = machine.clients.get(a["give"])
            if machine.lease is not client:
                raise Refused(EBUSY, "only the holder can pass the lease on")
            if other is None or not other.device or not other.writable:
                raise Refused(EINVAL, "give: no such client has the device open for writing")
            machine.set_lease(other)
        elif a.get("drop"):
            if machine.lease is client:
                machine.set_lease(None)
        elif held := self._held():
            raise Refused(EBUSY, held)
        else:
            ms = a.get("deadman_ms")
            self._check(machine.take_lease(client, ms and ms / 1000))
        return {"lease": machine.lease.number if machine.lease else None}

    def do_clients(self, a: dict) -> dict:
        machine = self.machine
        rows = [
            {"client": c.number, "name": c.name, "pid": c.pid, "kind": c.kind,
             "mode": ("rw" if c.writable else "r") if c.device else "",
             "lease": c is machine.lease}
            for c in machine.clients.values()
        ]  # fmt: skip
        return {"clients": rows}

    # --- inputs, time and the past ---

    def do_inputs(self, a: dict) -> dict:
        wrong = self.machine.wrong_values
        rows = [{"name": n, **known.told(), "values": wrong(n)} for n, known in INPUTS.items()]
        return {"inputs": rows}

    def do_pace(self, a: dict) -> dict:
        pace = self._server.pace
        speed, paused = a.get("speed", pace.speed), a.get("paused", pace.paused)
        pace.set(speed, paused)
        text = "paused" if paused else "as fast as it goes" if speed is None else f"speed {speed:g}"
        self.machine.sim.tap_note("pace", 0, text)
        return {"speed": speed, "paused": paused}

    def do_advance(self, a: dict) -> None:
        if not self._server.pace.paused:
            raise Refused(EBUSY, "time passes by itself; pause first")
        if self._server.advances:
            raise Refused(EBUSY, "another client has asked for time to pass already")
        self._server.advance(a["seconds"], self, a["id"])

    def do_machine(self, a: dict) -> dict:
        return dict(self._server.about.get("machine", {}))

    def do_export(self, a: dict) -> dict:
        """The past of a snapshot as a file beside the socket, for a machine of any build
        (mmcs/tool/moment.py)."""
        number, sim = a["snapshot"], self.machine.sim
        path = self._server.path.with_suffix(".past")
        snapshot, past = sim.snapshot_bytes(number), sim.history_bytes()
        path.write_bytes(len(snapshot).to_bytes(8, "little") + snapshot + past)
        return {"file": str(path)}

    def do_rewind(self, a: dict) -> dict:
        if self._server.advances:
            raise Refused(EBUSY, "another client has asked for time to pass; wait for its end")
        self.machine.history.rewind(a["snapshot"])
        self._server.pace.restart()
        return {"t": self.machine.sim.time, "snapshot": a["snapshot"]}


def _refusal(no: Refused) -> dict:
    name = errno.errorcode.get(no.number, str(no.number))
    text = no.text or os.strerror(no.number)
    return {"ok": False, "errno": no.number, "error": name, "text": text}


def _pid(sock: socket.socket) -> int:
    return struct.unpack("3i", sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))[0]
