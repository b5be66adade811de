# SPDX-License-Identifier: Apache-2.0
"""The served machine: who has it open, who has the lease, what is asked of it.

Programs at the wire and clients of the messages come to the same few methods. Requests answer with
a number as the driver does, negative for an errno.
"""

import errno
import os
import time
from dataclasses import dataclass

from mmcs import mcdef
from mmcs.device.history import History
from mmcs.device.wire import (
    BUS_ERROR,
    BUS_OK,
    BUS_TIMEOUT,
    EBADF,
    EBUSY,
    EINVAL,
    ENXIO,
    MSTATUS,
    STATUS,
)
from mmcs.errors import RunError
from mmcs.inputs import INPUTS

WINDOW_BASE, WINDOW_SIZE = 0x6000, 0x800
USER_AM = 0x29  # mapped accesses are non-privileged (§2.4)
BUS_TIMEOUT_S = 16e-6
O_ACCMODE, O_RDONLY, O_WRONLY = 3, 0, 1
KEPT_ROWS, KEPT_EVENTS = 8192, 4096


@dataclass(eq=False)
class Client:
    """Somebody who has the device open, or may open it."""

    number: int
    kind: str  # "device" or "message"
    name: str = ""
    pid: int = 0
    device: str = ""  # what is open: "", "/dev/mc0" or "/dev/vme16"
    driver: int = -1  # the driver's number of an open /dev/mc0
    flags: int = O_RDONLY
    deadman_s: float | None = None  # silence that ends the lease
    heard: float = 0.0
    said: str = ""  # the console during the last request that failed

    @property
    def writable(self) -> bool:
        return self.flags & O_ACCMODE != O_RDONLY

    def __str__(self) -> str:
        return f"client {self.number}" + (f" ({self.name})" if self.name else "")


class Machine:
    """One simulated machine and its clients."""

    def __init__(self, sim, console=lambda text: None):
        """console(text) gets every line that the driver says."""
        self.sim, self.console = sim, console
        self.cards = sim.build()["cards"]
        sim.tap(KEPT_ROWS, KEPT_EVENTS)
        self.clients: dict[int, Client] = {}
        self.lease: Client | None = None
        self._stopper = 0  # process behind the last stop
        self.history = History(self)
        self._numbers = 0
        self._told = 0  # events that the console has seen
        self._at_panic = ""  # pins that were at fault when PANIC came, which no register tells
        self._panicked = False  # it has come since MENABLE; our own stop raises it as well
        self._untold = ""  # the same, until the console has it
        self._input_numbers = {name: n for n, name in enumerate(sim.input_names())}
        requests = mcdef.requests().values()
        self._reads = {request.code for request in requests if not request.changes}
        self.waits = {request.code for request in requests if request.waits}

    # --- clients ---

    def enter(self, kind: str, pid: int = 0) -> Client:
        self._numbers += 1
        client = self.clients[self._numbers] = Client(self._numbers, kind, "", pid)
        return client

    def leave(self, client: Client) -> None:
        """Gone: what it had is closed and free. Nobody is left in control by a dead man."""
        if self.lease is client:
            if client.deadman_s is not None:
                self.stop()
            self.set_lease(None)
        self.close(client)
        del self.clients[client.number]

    @property
    def opens(self) -> int:
        return sum(1 for c in self.clients.values() if c.device)

    def open(self, client: Client, device: str, flags: int) -> int:
        if client.device:
            return -EBUSY
        if flags & os.O_DIRECTORY:
            return -errno.ENOTDIR
        if flags & os.O_EXCL and flags & os.O_CREAT:
            return -errno.EEXIST
        mode = flags & O_ACCMODE
        if device == "/dev/mc0":
            driver = self.sim.open(mode)
            if driver < 0:
                return driver
            client.driver = driver
        elif device != "/dev/vme16":
            return -ENXIO
        client.device, client.flags = device, flags
        self.history.clients_changed()
        how = "for reading" if mode == O_RDONLY else "for writing"
        self.sim.tap_note("client", client.number, f"{client} has {device} open {how}")
        return 0

    def close(self, client: Client) -> int:
        if not client.device:
            return -EBADF
        if client.driver >= 0:
            self.sim.close(client.driver)
        self.sim.tap_note("client", client.number, f"{client} has closed {client.device}")
        client.device, client.driver = "", -1
        self.history.clients_changed()
        return 0

    # --- the lease ---

    def set_lease(self, client: Client | None, deadman_s: float | None = None) -> None:
        if self.lease is not None:
            self.lease.deadman_s = None
        self.lease = client
        if client is not None:
            client.deadman_s, client.heard = deadman_s, time.monotonic()
        text = f"{client} has the lease" if client else "nobody has the lease"
        self.sim.tap_note("lease", client.number if client else -1, text)

    def take_lease(self, client: Client, deadman_s: float | None = None) -> int:
        if self.lease not in (None, client):
            return -EBUSY
        if not client.device or not client.writable:
            return -EBADF
        self.set_lease(client, deadman_s)
        return 0

    def held_from(self, client: Client) -> bool:
        """Somebody else has the lease."""
        return self.lease is not None and self.lease is not client

    def check_deadman(self, now: float) -> None:
        """now: up to when everything that came in has been read."""
        holder = self.lease
        if holder is None or holder.deadman_s is None:
            return
        if now - holder.heard > holder.deadman_s:
            self.sim.tap_note("log", 0, f"{holder} is silent: stopped")
            self.stop()
            self.set_lease(None)

    def state(self) -> dict:
        stats = self.sim.stats()
        now = {k: bool(stats[k]) for k in ("enabled", "stopped", "double_buffer")}
        now |= {k: stats[k] for k in ("interval_us", "diag")}
        return now | {"panic": bool(stats["panic_level"]), "button": self.is_pressed()}

    # --- stop: everybody's right ---

    def stop(self, pid: int = 0) -> int:
        self._stopper = pid
        return self.sim.stop()

    def knows(self) -> str:
        """What the simulator, but no register, knows of what shut the machine down, or of a PANIC
        that stood before MENABLE armed its latch."""
        self.tell_console()
        stats = self.sim.stats()
        if stats["enabled"] and stats["panic_level"]:
            return self._wrong_pins()
        return self._at_panic if stats["cause"] else ""

    def status(self) -> bytes:
        """struct mmcs_status of <sys/mmcs.h>; asking takes no time."""
        sim, stats = self.sim, self.sim.stats()
        stopped_by = self._stopper if stats["stopped"] else 0
        time_ns = sim.clock * 10**9 // sim.build()["clk_hz"]
        return STATUS.pack(time_ns, sim.samples & 0xFFFFFFFF, stats["enabled"], stats["stopped"],
                           stopped_by, stats["cause"], stats["cause_of"])  # fmt: skip

    def press(self, pressed: bool) -> None:
        self.set_input("estop", 0, float(pressed))

    def is_pressed(self) -> bool:
        return bool(self.wrong_values("estop"))

    # --- requests of one who has the device open ---

    def ioctl(self, client: Client, request: int, argument: bytes) -> tuple[int, bytes]:
        if request == MSTATUS:
            return 0, self.status()
        if request == mcdef.MSTOP and not client.writable:
            return self.stop(client.pid), b""
        if request not in self._reads and request != mcdef.MSTOP and self.held_from(client):
            return -EBUSY, b""
        before = self.sim.tap_head()[1]
        result, out = self.sim.ioctl_bytes(client.driver, request, argument)
        client.said = "" if result >= 0 else self.said_since(before)
        if result >= 0:
            self.called(client, request)
        return result, out

    def called(self, client: Client, request: int) -> None:
        """A request was not refused."""
        if request == mcdef.MSTOP:
            self._stopper = client.pid
        if request == mcdef.MENABLE and (known := self.knows()):
            self.sim.tap_note("log", 0, f"{known}: PANIC stands, and the brakes stay on")

    def joints(self, client: Client) -> int:
        """Those that the servo controls now; asking takes no time."""
        for axis in range(2 * self.cards):
            param = bytes(mcdef.make_ffi().buffer(mcdef.new_param(axis)))
            if self.sim.ioctl_bytes(client.driver, mcdef.MGETPARAM, param)[0] < 0:
                return axis
        return 2 * self.cards

    def read(self, client: Client, size: int) -> tuple[int, bytes]:
        return self.sim.read_bytes(client.driver, size)

    def write(self, client: Client, data: bytes) -> int:
        if self.held_from(client):
            return -EBUSY
        before = self.sim.tap_head()[1]
        result = self.sim.write_bytes(client.driver, data)
        client.said = "" if result >= 0 else self.said_since(before)
        return result

    def change(self, client: Client, axis: int, values: dict[str, int]) -> tuple[int, bytes]:
        """Some parameters of an axis; the others stay what they are at this moment."""
        ffi, param = mcdef.make_ffi(), mcdef.new_param(axis)
        result, now = self.ioctl(client, mcdef.MGETPARAM, bytes(ffi.buffer(param)))
        if result < 0:
            return result, b""
        ffi.buffer(param)[:] = now
        for name, value in values.items():
            setattr(param, name, value)
        made = bytes(ffi.buffer(param))
        result, _ = self.ioctl(client, mcdef.MSETPARAM, made)
        return result, made if result >= 0 else b""

    def bus(self, client: Client, address: int, size: int, data: bytes | None) -> tuple[int, bytes]:
        """A mapped access at an A16 address; data to write. Outside our window nobody answers."""
        if data is not None and not client.writable:
            return BUS_TIMEOUT, b""
        if data is not None and self.held_from(client):
            return BUS_ERROR, b""
        offset = address - WINDOW_BASE
        if not 0 <= offset < WINDOW_SIZE:
            self.pass_time(BUS_TIMEOUT_S)
            return BUS_TIMEOUT, b""
        try:
            if data is None:
                return BUS_OK, self.sim.bus_read(offset, USER_AM, size).to_bytes(size, "little")
            self.sim.bus_write(offset, int.from_bytes(data, "little"), USER_AM, size)
        except TimeoutError:
            return BUS_TIMEOUT, b""
        except OSError:
            return BUS_ERROR, b""
        return BUS_OK, b""

    # --- what happens ---

    def places(self, name: str) -> int:
        """So many of an input there are."""
        return {"machine": 1, "card": self.cards, "axis": 2 * self.cards}[INPUTS[name].scope]

    def wrong_values(self, name: str, t: float | None = None) -> dict[int, float]:
        """Of an input, what differs from healthy at a time, or now, by index."""
        number, healthy = self._input_numbers[name], INPUTS[name].healthy
        t = self.sim.time if t is None else t
        values = {n: self.sim.input_value(number, n, t) for n in range(self.places(name))}
        return {n: value for n, value in values.items() if value != healthy}

    def set_input(self, name: str, index: int, value: float) -> int:
        """An input of the machine or the plant takes a value now."""
        try:
            self.sim.add_event(self.sim.time, self._input_numbers[name], index, value)
        except RunError:
            return -EINVAL
        self.pass_time(0.0)
        return 0

    def pass_time(self, seconds: float) -> None:
        """At least one clock, in which what is due happens; within a waiting request that does."""
        self.sim.run(self.sim.time + max(seconds, 1 / self.sim.build()["clk_hz"]))

    def said_since(self, event: int) -> str:
        """What the console said from this event on."""
        events, _, _ = self.sim.tap_events(event, KEPT_EVENTS)
        return "; ".join(e["text"].removeprefix("mc: ") for e in events if e["kind"] == "log")

    def tell_console(self) -> None:
        while self._told < self.sim.tap_head()[1]:
            events, self._told, lost = self.sim.tap_events(self._told, KEPT_EVENTS)
            if lost:
                self.console(f"{lost} lines or events before this are lost")
            for event in events:
                if event["kind"] == "log":
                    self._log(event["text"])
                elif event["kind"] == "panic" and event["value"] and not self._panicked:
                    self._at_panic = self._untold = self._wrong_pins(event["t"])
                    self._panicked = True
                elif event["kind"] == "enabled" and event["value"]:
                    self._at_panic, self._panicked = "", False

    def _log(self, text: str) -> None:
        self.console(text)
        if self._untold and text.startswith("mc: PANIC: "):
            self.sim.tap_note("log", 0, self._untold)
            self._untold = ""

    def _wrong_pins(self, t: float | None = None) -> str:
        wrong = []
        for name, pin in INPUTS.items():
            at_fault = pin.made_by == "PIN" or name.startswith("encoder")
            for index, value in self.wrong_values(name, t).items() if at_fault else ():
                where = "" if pin.scope == "machine" else f"{pin.scope} {index}: "
                meaning = pin.meaning.removeprefix(f"{value:g}: ")
                wrong.append(where + (meaning if meaning != pin.meaning else f"{name} {value:g}"))
        return "the simulator knows: " + ", ".join(wrong) if wrong else ""
