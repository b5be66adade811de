# SPDX-License-Identifier: Apache-2.0
"""The server's end of the messages: see docs/use/protocol.md, whose words the names here are."""

import errno
import json
import os
import re
import struct
import time
from math import isfinite

from mmcs import ROOT, mcdef
from mmcs.device.connection import IN, OUT, Connection
from mmcs.device.sockets import peer
from mmcs.device.wire import EINVAL, EIO
from mmcs.folder import whole_file

LIMIT = 65536
OUT_LIMIT = 1 << 20  # bytes that nobody fetches: then he is hung up
LENGTH = struct.Struct("<I")
TABLE = ROOT / "sim" / "service" / "messages.def"
REQUESTS = re.findall(r"\bOP\((\w+)\)", TABLE.read_text())
# Not served while somebody else's request waits: they let time pass, or do away with it.
WAITING = ("close", "snapshot", "rewind", "advance", "ring", "drop", "lease", "setpoint")


class Messenger(Connection):
    """A client of the messages."""

    def __init__(self, sock, server):
        super().__init__(sock, server)
        self._data, self._out = bytearray(), bytearray()
        self.client = self.machine.enter("message", peer(sock)[0])
        hello = self.machine.request(self.client, {"op": "hello"})
        self.tell({"type": "hello", **self.do_hello(hello)})

    def leave(self) -> None:
        self.machine.leave(self.client)

    # --- carrying ---

    def tell(self, message: dict) -> None:
        self._carry(json.dumps(message, separators=(",", ":")).encode())

    def _carry(self, message: bytes) -> None:
        self._out += LENGTH.pack(len(message)) + message
        self.flush()

    def flush(self) -> None:
        try:
            del self._out[: self.sock.send(self._out)]
        except BlockingIOError:
            pass
        except OSError:
            self.end()
        if len(self._out) > OUT_LIMIT:
            self.end()
        if not self.ended:
            self.watch(IN | OUT if self._out else IN)

    def receive(self) -> None:
        if not self.has_request() and not self.ended:
            self._data += self.take()
        if not self.ended:
            self.client.heard = time.monotonic()

    def has_request(self) -> bool:
        if len(self._data) < LENGTH.size or self.ended:
            return False
        (length,) = LENGTH.unpack_from(self._data)
        if not 0 < length <= LIMIT:
            self.end()
            return False
        return len(self._data) >= LENGTH.size + length

    def serve(self, nested: bool) -> None:
        (length,) = LENGTH.unpack_from(self._data)
        try:
            message = json.loads(self._data[LENGTH.size : LENGTH.size + length])
        except (ValueError, RecursionError):
            message = None
        if type(message) is not dict:
            self.end()
            return
        op = message.get("op")
        if nested and self._waits(op, message):
            return
        del self._data[: LENGTH.size + length]
        name = message.get("id")
        if isinstance(name, list | dict) or (isinstance(name, float) and not isfinite(name)):
            self.answer(None, _refusal(EINVAL, "id: a number or a text"))
            return
        self.busy = True
        reply = self._reply(op, message)
        if reply is not None:
            self.answer(message.get("id"), reply)

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
        while not self._out and (message := self.machine.stream(self.client, now)):
            if message[:1] == b"{":  # a text was cut in the middle of a character, perhaps
                message = message.decode(errors="replace").encode()
            self._carry(message)

    # --- what needs more than the machine ---

    def do_hello(self, done: dict) -> dict:
        server = self.server
        return {**done, "server": server.name.path.stem, "scenario": server.about.get("scenario"),
                "lockstep": server.lockstep.on}  # fmt: skip

    def do_pace(self, done: dict) -> dict:
        self.server.restart()
        return done

    do_rewind = do_pace

    def do_advance(self, done: dict) -> None:
        self.server.advances = self, done["id"]

    def do_machine(self, a: dict) -> dict:
        return dict(self.server.about.get("machine", {}))

    def do_export(self, a: dict) -> dict:
        """The past of a snapshot as a file beside the socket, for a machine of any build
        (mmcs/tool/moment.py)."""
        number, sim = a["snapshot"], self.machine.sim
        path = self.server.path.with_suffix(".past")
        snapshot, past = sim.snapshot_bytes(number), sim.history_bytes()
        with whole_file(path) as part:
            part.write_bytes(len(snapshot).to_bytes(8, "little") + snapshot + past)
        return {"file": str(path)}


def _refusal(number: int, text: str) -> dict:
    name = errno.errorcode.get(number, str(number))
    return {"ok": False, "errno": number, "error": name, "text": text or os.strerror(number)}
