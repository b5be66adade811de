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
from math import isfinite

from mmcs import ROOT, mcdef
from mmcs.device.connection import Connection
from mmcs.device.sockets import peer
from mmcs.device.wire import EINVAL, EIO
from mmcs.folder import whole_file

LIMIT = 65536
LENGTH = struct.Struct("<I")
TABLE = ROOT / "sim" / "service" / "messages.def"
REQUESTS = re.findall(r"\bOP\((\w+)\)", TABLE.read_text())
# Not served while somebody else's request waits: they let time pass, or do away with it.
WAITING = ("close", "snapshot", "rewind", "advance", "ring", "drop", "lease", "setpoint")


class Messenger(Connection):
    """A client of the messages."""

    def __init__(self, sock: socket.socket, poll: select.epoll, address, server):
        super().__init__(sock, poll)
        self._server, self.machine = server, server.machine
        self.client = self.machine.enter("message", peer(sock)[0])
        hello = self.machine.request(self.client, {"op": "hello"})
        self.tell({"type": "hello", **self.do_hello(hello)})

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
        return bool(self.client.writes)

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
        name = message.get("id")
        if isinstance(name, list | dict) or (isinstance(name, float) and not isfinite(name)):
            self.answer(None, _refusal(EINVAL, "id: a number or a text"))
            return True
        self.busy = True
        reply = self._reply(op, message)
        if reply is not None:
            self.answer(message.get("id"), reply)
        return True

    def fail(self, why: str) -> None:
        self.answer(None, _refusal(EIO, why))

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
            if op == "name" and type(message.get("name")) is str:
                message["name"] = "".join(c for c in message["name"][:64] if c.isprintable())
            done = machine.request(client, message)
            if "errno" in done:
                return _refusal(done["errno"], done["text"])
            if op == "call":
                machine.called(mcdef.constants()[message["request"]])
            if more := getattr(self, f"do_{op}", None):
                done = more(done | {"id": message.get("id")})
            return None if done is None else {"ok": True, **done}
        except OSError as error:  # a file: a full disk, a folder in its place
            what = f"{error.filename}: {error.strerror}" if error.filename else str(error)
            return _refusal(error.errno or EIO, what)

    def stream(self, now: float) -> None:
        """Sends what is due, as far as the client takes it: what he leaves stays in the ring."""
        while self.idle() and (message := self.machine.stream(self.client, now)):
            if message[:1] == b"{":  # a text was cut in the middle of a character, perhaps
                message = message.decode(errors="replace").encode()
            self._carry(message)

    # --- what needs more than the machine ---

    def do_hello(self, done: dict) -> dict:
        server = self._server
        return {**done, "server": server.name.path.stem, "scenario": server.about.get("scenario"),
                "lockstep": server.lockstep.on}  # fmt: skip

    def do_pace(self, done: dict) -> dict:
        self._server.pace.restart()
        return done

    do_rewind = do_pace

    def do_advance(self, done: dict) -> None:
        self._server.advances = self, done["id"]

    def do_machine(self, a: dict) -> dict:
        return dict(self._server.about.get("machine", {}))

    def do_export(self, a: dict) -> dict:
        """The past of a snapshot as a file beside the socket, for a machine of any build
        (mmcs/tool/moment.py)."""
        number, sim = a["snapshot"], self.machine.sim
        path = self._server.path.with_suffix(".past")
        snapshot, past = sim.snapshot_bytes(number), sim.history_bytes()
        with whole_file(path) as part:
            part.write_bytes(len(snapshot).to_bytes(8, "little") + snapshot + past)
        return {"file": str(path)}


def _refusal(number: int, text: str) -> dict:
    name = errno.errorcode.get(number, str(number))
    return {"ok": False, "errno": number, "error": name, "text": text or os.strerror(number)}
