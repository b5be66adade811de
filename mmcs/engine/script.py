# SPDX-License-Identifier: Apache-2.0
"""What sim/abi/mmcs_service.h has for a Sim: scripts carried out, requests of the messages."""

import json
import re
import time
from collections.abc import Iterator

from mmcs import mcdef
from mmcs.errors import RunError

KINDS = {type(None): "n", bool: "b", int: "i", float: "d", str: "t", dict: "o", list: "l"}
CONTROL = re.compile(r"[\0-\x1f]")


def listed(kind: str, call, of) -> list:
    """The entries of an array of the C ABI, good until the machine goes on."""
    out = mcdef.make_ffi().new(f"const {kind} **")
    count = call(of, out)
    return [out[0][n] for n in range(count)]


def made_from(create, setup: bytes):
    """What mmcs_sim_create_from() or the like makes of a set-up; RunError."""
    ffi = mcdef.make_ffi()
    err = ffi.new("char[]", 300)
    made = create(ffi.from_buffer(setup), len(setup), ffi.NULL, err, 300)
    if made == ffi.NULL:
        text = ffi.string(err).decode(errors="replace")
        raise RunError(f"the machine cannot be made: {text or 'no reason given'}")
    return made


class Script:
    """What a set-up does with a machine. Other machines may go on with it (see act())."""

    def __init__(self, sim, setup: bytes):
        self.ffi, self.lib, self._what = sim.ffi, sim.lib, sim.ffi.new("char[]", 300)
        made = made_from(self.lib.mmcs_script_create_from, setup)
        self._script = self.ffi.gc(made, self.lib.mmcs_script_destroy)

    def begin(self, sim) -> tuple[int, str]:
        """Opens and configures the driver, starts the motion: 0, -errno, or the errno of a refusal
        that the scenario expects; and of what."""
        return self._told(self.lib.mmcs_script_begin(self._script, sim.handle, self._what, 300))

    @property
    def start(self) -> float:
        return self.lib.mmcs_script_start(self._script)

    @property
    def client(self) -> int:
        return self.lib.mmcs_script_client(self._script)

    def resume(self, client: int, start: float, t: float, at_it: bool) -> None:
        """Instead of begin(): what is due before t, or at it as well, has been done."""
        self.lib.mmcs_script_resume(self._script, client, start, t, at_it)

    def act(self, sim, until: float) -> tuple[int, str]:
        """Carries out what is due before this time of the motion: 0; 1 when an assertion failed;
        -errno, and of what."""
        args = (until, self._what, len(self._what))
        return self._told(self.lib.mmcs_script_act(self._script, sim.handle, *args))

    def _told(self, result: int) -> tuple[int, str]:
        return result, self.ffi.string(self._what).decode(errors="replace")

    def answers(self) -> list[tuple[str, int, int, int, int]]:
        """Of each call: request, axis (-1: none), result, and the A/D's code and count that MCALIB
        saw."""
        names = {request.code: name for name, request in mcdef.requests().items()}
        found = listed("mmcs_answer", self.lib.mmcs_script_answers, self._script)
        return [(names[a.request], a.axis, a.result, a.adcvai, a.encnow) for a in found]

    def told(self) -> list[tuple[int, int, float, float]]:
        """Of each process: acts, turns, shortest and longest time between two acts in us."""
        found = listed("mmcs_process_told", self.lib.mmcs_script_told, self._script)
        return [(p.acts, p.turns, p.shortest_us, p.longest_us) for p in found]


class Playing:
    """The part of a Sim that sim/service does."""

    def new_script(self, setup: bytes) -> Script:
        return Script(self, setup)

    def play(self, script: Script, until: float) -> tuple[int, str]:
        """Runs to a time of the motion and carries out what is due before it: as Script.act()."""
        result = script.act(self, until)
        return result if result[0] else (int(not self.run(script.start + until)), "")


class Serving:
    """The part of a server that sim/service does: clients, lease, requests, the stream."""

    def __init__(self, sim):
        self.sim, self._ffi, self._lib = sim, sim.ffi, sim.lib
        made = self._lib.mmcs_server_create(sim.handle)
        self.now = self._ffi.gc(made, self._lib.mmcs_server_destroy)  # fields of mmcs_server
        self._bytes = self._ffi.new("const uint8_t **")

    def enter(self, kind: str, pid: int, name: str = ""):
        """A client: fields of mmcs_client."""
        return self._lib.mmcs_server_enter(self.now, kind.encode(), name.encode(), pid)

    def leave(self, client) -> None:
        self._lib.mmcs_server_leave(self.now, client)

    def open(self, client, device: bytes, flags: int) -> int:
        return self._lib.mmcs_server_open(self.now, client, device, flags, -1)

    def held(self, client) -> str:
        why = self._lib.mmcs_server_held(self.now, client)
        return self._ffi.string(why).decode(errors="replace") if why else ""

    def said_since(self, event: int) -> str:
        """What the driver has said from this event of the tap on."""
        said = self._lib.mmcs_server_said(self.now, event)
        return self._ffi.string(said).decode(errors="replace")

    def server_ioctl(self, client, request: int, argument: bytes) -> tuple[int, bytes]:
        return self.sim.asked(request, argument, self._lib.mmcs_server_ioctl, self.now, client)

    def bus(self, client, address: int, size: int, data: bytes | None) -> tuple[int, bytes]:
        """A mapped access at an A16 address; data to write: as mmcs_server_bus()."""
        value, writes = self._ffi.new("uint32_t *"), data is not None
        value[0] = int.from_bytes(data or b"", "little")
        result = self._lib.mmcs_server_bus(self.now, client, address, size, writes, value)
        return result, b"" if result or writes else value[0].to_bytes(size, "little")

    def stop(self) -> int:
        """MSTOP of whoever has no client."""
        return self._lib.mmcs_server_stop(self.now, 0)

    def check(self, now: float) -> None:
        self._lib.mmcs_server_check(self.now, now)

    def stream(self, client, now: float) -> bytes:
        """The next message that is due to him, or nothing."""
        size = self._lib.mmcs_server_stream(self.now, client, now, self._bytes)
        return self._ffi.buffer(self._bytes[0], size)[:]

    def request(self, client, said: dict) -> dict:
        """A request of the messages, of nobody if client is None: as mmcs_server_request()."""
        asked = "".join(f"{line}\n" for line in _lines(said)).encode(errors="replace")
        now, none = time.monotonic(), self._ffi.NULL
        args = (client or none, now, asked, 0, none)
        reply = self._lib.mmcs_server_request(self.now, *args)
        return json.loads(self._ffi.string(reply).decode(errors="replace"))


def _lines(values: dict | list, path: str = "") -> Iterator[str]:
    """As mmcs_server_request() takes them."""
    for key, value in values.items() if isinstance(values, dict) else enumerate(values):
        at, kind = path + CONTROL.sub("?", str(key)) + "\t", KINDS[type(value)]
        if kind not in "ol":
            yield at + kind + CONTROL.sub("?", str(int(value) if kind == "b" else value))
        elif path:
            yield at + "x"
        else:
            yield at + kind
            yield from _lines(value, at)
