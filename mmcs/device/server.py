# SPDX-License-Identifier: Apache-2.0
"""The simulator as a server: offers /dev/mcN and /dev/vme16 to other processes (§2.3, §2.4).

The client's end is the preload library in sim/device; sim/device/wire.h describes the wire.
"""

from __future__ import annotations

import contextlib
import os
import selectors
import signal
import socket
import struct
import time
from dataclasses import dataclass, field
from pathlib import Path

from mmcs.errors import InputError

MAGIC = 0x31434D4D
REQUEST = struct.Struct("<II16sQQIi")
REPLY = struct.Struct("<iI")
OPEN, IOCTL, READ, WRITE, LOAD, STORE, HOLD = range(1, 8)
BUS_OK, BUS_TIMEOUT, BUS_ERROR = range(3)
MAX_DATA = 65536
O_ACCMODE = 3

ENXIO, EBADF, EINVAL, ENOTTY = 6, 9, 22, 25
WINDOW_BASE, WINDOW_SIZE = 0x6000, 0x800
USER_AM = 0x29  # mapped accesses are non-privileged (§2.4)
# Simulated time between looks at the sockets: short while somebody talks or has been signalled, so
# that a free-running machine does not run away from its programs; it doubles up to the longest.
CHUNK_MIN_S, CHUNK_MAX_S = 50e-6, 2e-3


def socket_path(name: str) -> Path:
    """Where the server called `name` listens: per user, nobody else may enter."""
    base = Path(os.environ.get("XDG_RUNTIME_DIR") or "/tmp")
    return base / f"mmcs-{os.getuid()}" / f"{name}.sock"


def listen(path: Path) -> socket.socket:
    """A listening socket of mode 0600; takes over a stale one, refuses a living one."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    status = path.parent.stat()
    if status.st_uid != os.getuid() or status.st_mode & 0o077:
        raise InputError.one(path.parent, "", None, "not yours alone; remove it and try again")
    if path.exists():
        probe = socket.socket(socket.AF_UNIX)
        try:
            probe.connect(str(path))
        except OSError:
            path.unlink()  # its server is dead
        else:
            raise InputError.one(
                "--dev", "", path.stem, "a server of this name is running; stop it or use another"
            )
        finally:
            probe.close()
    server = socket.socket(socket.AF_UNIX)
    old = os.umask(0o177)
    try:
        server.bind(str(path))
    finally:
        os.umask(old)
    server.listen(64)
    server.setblocking(False)
    return server


@dataclass
class OpenFile:
    """One open file description of a client: closes when its last descriptor does."""

    device: str
    client: int  # the driver's number; -1 for /dev/vme16
    writable: bool
    inode: int  # of the client's end
    holders: dict[int, int] = field(default_factory=dict)  # pid -> pidfd

    def hold(self, pid: int) -> None:
        if pid not in self.holders:
            with contextlib.suppress(OSError):
                self.holders[pid] = os.pidfd_open(pid)

    def drop(self, pid: int) -> None:
        if pid in self.holders:
            os.close(self.holders.pop(pid))

    def signal(self) -> None:
        """SIGUSR1 to every process that has the file open at this moment."""
        for pid, pidfd in list(self.holders.items()):
            try:
                if self._is_open_in(pid):
                    signal.pidfd_send_signal(pidfd, signal.SIGUSR1)
                else:
                    self.drop(pid)
            except ProcessLookupError:
                self.drop(pid)

    def _is_open_in(self, pid: int) -> bool:
        """The kernel knows what dup2, exec and close have left of a process's descriptors."""
        if not self.inode:
            return True
        target = f"socket:[{self.inode}]"
        try:
            for entry in os.scandir(f"/proc/{pid}/fd"):
                with contextlib.suppress(OSError):
                    if os.readlink(entry.path) == target:
                        return True
        except OSError:
            return False
        return False

    def release(self) -> None:
        for pid in list(self.holders):
            self.drop(pid)


class Connection:
    """One accepted socket with what has arrived on it so far."""

    def __init__(self, sock: socket.socket, name: str):
        self.sock, self.name, self.data = sock, name, bytearray()
        self.is_file = False


class Server:
    """Serves one machine. step() does a little work; run() goes on until told to stop."""

    def __init__(self, sim, path: Path, speed: float | None):
        """speed: simulated seconds per second; None runs as fast as it goes."""
        self.sim, self.path, self.speed = sim, path, speed
        self.listener = listen(path)
        self.selector = selectors.DefaultSelector()
        self.selector.register(self.listener, selectors.EVENT_READ)
        self.files: dict[str, OpenFile] = {}
        self.started = (time.monotonic(), sim.time)
        self.chunk = CHUNK_MIN_S
        self.stopping = False

    def close(self) -> None:
        for key in list(self.selector.get_map().values()):
            if key.data is not None:
                self._hang_up(key.data)
        self.listener.close()
        self.selector.close()
        self.path.unlink(missing_ok=True)

    def run(self) -> None:
        while not self.stopping:
            self.step()

    # --- time ---

    def step(self) -> None:
        """Advances the machine by one chunk if it is due, and answers what has come in."""
        wait = self._wait()
        for key, _ in self.selector.select(wait):
            if key.data is None:
                self._accept()
            else:
                self.chunk = CHUNK_MIN_S
                self._receive(key.data)
        if self.files and self._wait() == 0:
            self.sim.run(self.sim.time + self.chunk)
            self.chunk = CHUNK_MIN_S if self._signals() else min(2 * self.chunk, CHUNK_MAX_S)

    def _wait(self) -> float:
        """Seconds until the next chunk is due. Without an open file time stands still."""
        if not self.files:
            self.started = (time.monotonic(), self.sim.time)
            return 0.1
        if self.speed is None:
            return 0.0
        wall, simulated = self.started
        due = wall + (self.sim.time - simulated) / self.speed
        if time.monotonic() - due > 1.0:  # cannot keep up: do not run after the lost time
            self.started = (time.monotonic(), self.sim.time)
        return max(0.0, due - time.monotonic())

    def _signals(self) -> bool:
        sent = False
        for file in self.files.values():
            if file.client >= 0 and self.sim.signals(file.client) and file.writable:
                file.signal()
                sent = True
        return sent

    # --- connections ---

    def _accept(self) -> None:
        with contextlib.suppress(BlockingIOError):
            sock, address = self.listener.accept()
            sock.setblocking(False)  # nobody who does not read his replies can hold us up
            name = bytes(address).strip(b"\0").decode(errors="replace") if address else ""
            self.selector.register(sock, selectors.EVENT_READ, Connection(sock, name))

    def _hang_up(self, connection: Connection) -> None:
        self.selector.unregister(connection.sock)
        connection.sock.close()
        file = self.files.pop(connection.name, None) if connection.is_file else None
        if file:
            if file.client >= 0:
                self.sim.close(file.client)
            file.release()
            self._signals()

    def _receive(self, connection: Connection) -> None:
        try:
            data = connection.sock.recv(MAX_DATA)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._hang_up(connection)
            return
        connection.data += data
        while len(connection.data) >= REQUEST.size:
            magic, op, name, a, b, length, pid = REQUEST.unpack_from(connection.data)
            if magic != MAGIC or length > MAX_DATA:
                self._hang_up(connection)
                return
            end = REQUEST.size + length
            if len(connection.data) < end:
                return
            payload = bytes(connection.data[REQUEST.size : end])
            del connection.data[:end]
            label = name.rstrip(b"\0").decode(errors="replace")
            result, out = self._call(connection, op, label, a, b, payload, pid)
            try:
                connection.sock.sendall(REPLY.pack(result, len(out)) + out)
                if op == OPEN and result >= 0:
                    connection.sock.sendall(b".")  # read() never blocks: poll() shall say so
            except OSError:
                self._hang_up(connection)
                return
            self._signals()

    # --- calls ---

    def _call(self, connection, op, name, a, b, payload, pid) -> tuple[int, bytes]:
        if op == OPEN:
            return self._open(connection, payload.decode(errors="replace"), a, b, pid), b""
        file = self.files.get(name)
        if file is None:
            return -EBADF, b""
        file.hold(pid)
        if op == HOLD:
            return 0, b""
        if op in (LOAD, STORE):
            if file.client >= 0:
                return -EINVAL, b""
            if op == STORE and not file.writable:
                return BUS_TIMEOUT, b""
            return self._bus(op, a, b, payload)
        if file.client < 0:
            return (-ENOTTY if op == IOCTL else -EINVAL), b""
        if op == IOCTL:
            return self.sim.ioctl_bytes(file.client, a & 0xFFFFFFFF, payload)
        if op == READ:
            return self.sim.read_bytes(file.client, min(a, MAX_DATA))
        if op == WRITE:
            return self.sim.write_bytes(file.client, payload), b""
        return -EINVAL, b""

    def _open(self, connection, device: str, flags: int, inode: int, pid: int) -> int:
        mode = flags & O_ACCMODE
        client = -1
        if device == "/dev/mc0":
            client = self.sim.open(mode)
            if client < 0:
                return client
        elif device != "/dev/vme16":
            return -ENXIO
        connection.is_file = True
        file = self.files[connection.name] = OpenFile(device, client, mode != os.O_RDONLY, inode)
        file.hold(pid)
        return 0

    def _bus(self, op: int, address: int, size: int, payload: bytes) -> tuple[int, bytes]:
        """A mapped access at an A16 address; outside our window nobody answers."""
        offset = address - WINDOW_BASE
        if not 0 <= offset < WINDOW_SIZE or size not in (1, 2):
            self.sim.run(self.sim.time + 16e-6)
            return BUS_TIMEOUT, b""
        try:
            if op == LOAD:
                value = self.sim.bus_read(offset, USER_AM, size)
                return BUS_OK, value.to_bytes(size, "little")
            self.sim.bus_write(offset, int.from_bytes(payload, "little"), USER_AM, size)
        except TimeoutError:
            return BUS_TIMEOUT, b""
        except OSError:
            return BUS_ERROR, b""
        return BUS_OK, b""
