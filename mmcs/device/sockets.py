# SPDX-License-Identifier: Apache-2.0
"""Where a server listens, and how one makes sure who is at the other end.

A server has a folder that is the user's alone, its name as long as it lives, and sockets of mode
0600. Both ends ask the kernel for the other one's user: paths are not proof.
"""

import contextlib
import errno
import os
import socket
import stat
import struct
from pathlib import Path

from mmcs.errors import InputError

BACKLOG = 64


def socket_path(name: str) -> Path:
    """Where the server called `name` listens: per user, nobody else may enter."""
    base = Path(os.environ.get("XDG_RUNTIME_DIR") or "/tmp")
    return base / f"mmcs-{os.getuid()}" / f"{name}.sock"


def check_folder(folder: Path) -> None:
    """A folder, no link to one, that belongs to us and lets nobody else in."""
    try:
        status = folder.lstat()
    except OSError as error:
        raise InputError.one(folder, "", None, error.strerror) from None
    if not stat.S_ISDIR(status.st_mode):
        raise InputError.one(folder, "", None, "not a folder; remove it and try again")
    if status.st_uid != os.getuid() or status.st_mode & 0o077:
        raise InputError.one(folder, "", None, "not yours alone; remove it and try again")


def make_folder(folder: Path) -> None:
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except FileExistsError:
        pass  # check_folder tells what it is
    except OSError as error:
        raise InputError.one(folder, "", None, error.strerror) from None
    check_folder(folder)


def _kind(path: Path) -> socket.SocketKind:
    """Requests at the wire and their replies are packets."""
    return socket.SOCK_SEQPACKET if path.suffix == ".sock" else socket.SOCK_STREAM


def peer(sock: socket.socket) -> tuple[int, int]:
    """Process and user at the other end, as the kernel knows them."""
    size = struct.calcsize("3i")
    return struct.unpack("3i", sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, size))[:2]


class Name:
    """The name of a server, taken as long as this lives, and the sockets under it."""

    def __init__(self, path: Path):
        self.path = path
        make_folder(path.parent)
        self._lock = socket.socket(socket.AF_UNIX)
        try:
            self._lock.bind(f"\0{path}")  # a name that the kernel takes away with its process
        except OSError as error:
            self._lock.close()
            if error.errno != errno.EADDRINUSE:
                raise _unusable(path, error) from None
            allowed = "a server of this name is running; stop it or use another"
            raise InputError.one("--dev", "", path.stem, allowed) from None
        self._made: list[tuple[Path, socket.socket]] = []

    def listen(self, suffix: str) -> socket.socket:
        """A listening socket of mode 0600. What a dead server left in its place is taken over."""
        path = self.path.with_suffix(suffix)
        with contextlib.suppress(FileNotFoundError):
            if not stat.S_ISSOCK(path.lstat().st_mode):
                raise InputError.one(path, "", None, "is not a socket; move it away and try again")
            path.unlink()
        server = socket.socket(socket.AF_UNIX, _kind(path))
        try:
            server.bind(str(path))
            path.chmod(0o600)
        except OSError as error:
            server.close()
            raise _unusable(path, error) from None
        self._made.append((path, server))
        server.listen(BACKLOG)
        server.setblocking(False)
        return server

    def release(self) -> None:
        for path, server in self._made:
            path.unlink(missing_ok=True)
            server.close()
        self._lock.close()


def _unusable(path: Path, error: OSError) -> InputError:
    why = error.strerror or "too long for a socket; set XDG_RUNTIME_DIR to a shorter folder"
    return InputError.one(path, "", None, why)


def connect(path: Path, timeout: float | None = None) -> socket.socket:
    """A connection to a server of our own; OSError with a sentence otherwise."""
    sock = socket.socket(socket.AF_UNIX, _kind(path))
    try:
        sock.settimeout(timeout)
        sock.connect(str(path))
    except OSError:
        sock.close()
        text = "no simulator is serving; start `mmcs serve SCENARIO`"
        raise OSError(errno.ENXIO, text, "/dev/mc0") from None
    _, uid = peer(sock)
    if uid != os.geteuid():
        sock.close()
        raise OSError(errno.ENXIO, f"user {uid} serves this socket, not you: not used", str(path))
    return sock
