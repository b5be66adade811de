# SPDX-License-Identifier: Apache-2.0
"""The server's end of the messages: see docs/use/protocol.md, whose words the names here are."""

from __future__ import annotations

import errno
import json
import os
import select
import socket
import struct
import time

from mmcs import mcdef
from mmcs.device.arguments import Arguments, Refused
from mmcs.device.connection import Connection
from mmcs.device.machine import Machine
from mmcs.device.operations import Operations
from mmcs.device.wire import EBADF, EBUSY, EINVAL

PROTOCOL = 1
LIMIT = 65536
LENGTH = struct.Struct("<I")
HEAD = struct.Struct("<4sIIHHdd")
FIELDS = ("adcvai", "encnow", "inow", "error", "fbnow", "vel", "errcode",
          "setpoint", "demand", "current")  # fmt: skip
MC_STATE = struct.Struct("<7i")
ROWS_AT_ONCE, EVENTS_AT_ONCE = 512, 256
ENOSYS, EIO, ENOTTY = 38, 5, 25
# Not served while somebody else's request waits: they let time pass, or do away with it.
WAITING = ("close", "snapshot", "rewind", "advance", "ring", "drop", "lease", "setpoint")


class Stream:
    """What a client follows: his place in both rings."""

    def __init__(self, machine: Machine, a: Arguments):
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
        self._operations = Operations(server, self)
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
        """None: it comes later."""
        self.client.said = ""
        try:
            asked = Arguments(message, 2 * self.machine.cards)
            name = f"do_{asked.op}"
            serve = getattr(self, name, None) or getattr(self._operations, name, None)
            if serve is None:
                raise Refused(ENOSYS, f"op: there is no {op!r}")
            done = serve(asked)
            return None if done is None else {"ok": True, **done}
        except Refused as no:
            return _refusal(no)
        except OSError as error:  # a file: a full disk, a folder in its place
            what = f"{error.filename}: {error.strerror}" if error.filename else str(error)
            return _refusal(Refused(error.errno or EIO, what))

    def check(self, result: int) -> int:
        """The driver's answer, or Refused with what it said."""
        if result >= 0:
            return result
        machine = self.machine
        if result == -EBUSY and machine.held_from(self.client):
            raise Refused(EBUSY, f"{machine.lease} has the lease")
        raise Refused(-result, self.client.said)

    # --- the stream ---

    def do_follow(self, a: Arguments) -> dict:
        self._stream = Stream(self.machine, a)
        return {}

    def do_unfollow(self, a: Arguments) -> dict:
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

    def do_hello(self, a: Arguments) -> dict:
        return {k: v for k, v in self._hello().items() if k != "type"}

    def do_name(self, a: Arguments) -> dict:
        self.client.name = "".join(c for c in a["name"][:64] if c.isprintable())
        return {}

    def do_open(self, a: Arguments) -> dict:
        flags = os.O_RDWR if a["mode"] == "rw" else os.O_RDONLY
        self.check(self.machine.open(self.client, "/dev/mc0", flags))
        return {}

    def do_close(self, a: Arguments) -> dict:
        if self.machine.lease is self.client:
            self.machine.set_lease(None)
        self.check(self.machine.close(self.client))
        return {}

    def _must_be_open(self, writing: bool = False) -> None:
        if self.client.driver < 0 or (writing and not self.client.writable):
            raise Refused(EBADF, "the device is not open" + (" for writing" if writing else ""))

    def do_read(self, a: Arguments) -> dict:
        self._must_be_open()
        size = MC_STATE.size * a["axes"]
        result, data = self.machine.read(self.client, size)
        self.check(result)
        return {"states": [list(row) for row in MC_STATE.iter_unpack(data)]}

    def do_write(self, a: Arguments) -> dict:
        self._must_be_open(writing=True)
        values = a["setpoints"]
        self.check(self.machine.write(self.client, struct.pack(f"<{len(values)}i", *values)))
        return {}

    def do_setpoint(self, a: Arguments) -> dict:
        self._must_be_open(writing=True)
        self.check(self.machine.setpoint(self.client, a["axis"], a["value"]))
        return {"t": self.machine.sim.time}

    def do_call(self, a: Arguments) -> dict:
        self._must_be_open()
        name = a["request"]
        request = mcdef.constants().get(name, 0)
        if request & 0xFF00 != mcdef.MC_GROUP or name.startswith("MC_"):
            raise Refused(ENOTTY, f"request: there is no {name}")
        result, out = self.machine.ioctl(self.client, request, self._argument(request, a))
        self.check(result)
        return _unpacked(request, out)

    def _argument(self, request: int, a: Arguments) -> bytes:
        if not request & mcdef.MC_ARG_IN:
            return b""
        if request & 0x1FFF0000 == mcdef.MC_INT:
            return struct.pack("<I", a["value"] & 0xFFFFFFFF)
        param = mcdef.new_param(a["axis"])
        if request == mcdef.MSETPARAM:
            for name, value in a["param"].items():
                setattr(param, name, value)
        return bytes(mcdef.make_ffi().buffer(param))

    def do_change(self, a: Arguments) -> dict:
        self._must_be_open(writing=True)
        result, out = self.machine.change(self.client, a["axis"], a["param"])
        self.check(result)
        return _unpacked(mcdef.MGETPARAM, out)

    def do_load(self, a: Arguments) -> dict:
        return self._bus(a["offset"], None)

    def do_store(self, a: Arguments) -> dict:
        self._operations.must_control()
        return self._bus(a["offset"], a["value"])

    def _bus(self, offset: int, value: int | None) -> dict:
        sim = self.machine.sim
        try:
            if value is None:
                return {"value": sim.bus_read(offset, 0x29, 1)}
            sim.bus_write(offset, value, 0x29, 1)
        except TimeoutError:
            raise Refused(EIO, "bus time-out") from None
        except OSError:
            raise Refused(EIO, "bus error") from None
        return {}

    def do_stop(self, a: Arguments) -> dict:
        self.check(self.machine.stop(self.client.pid))
        return {"t": self.machine.sim.time}


def _refusal(no: Refused) -> dict:
    name = errno.errorcode.get(no.number, str(no.number))
    text = no.text or os.strerror(no.number)
    return {"ok": False, "errno": no.number, "error": name, "text": text}


def _unpacked(request: int, out: bytes) -> dict:
    """What a request gave, under the name of its kind."""
    if not out:
        return {}
    if len(out) == 4:
        return {"value": struct.unpack("<i", out)[0]}
    name = "stats" if request == mcdef.MGETSTATS else "param"
    ffi = mcdef.make_ffi()
    made = ffi.new(f"struct mc_{name} *")
    ffi.buffer(made)[:] = out
    return {name: {n: getattr(made, n) for n, _ in ffi.typeof(f"struct mc_{name}").fields}}


def _pid(sock: socket.socket) -> int:
    return struct.unpack("3i", sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))[0]
