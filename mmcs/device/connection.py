# SPDX-License-Identifier: Apache-2.0
"""One accepted socket: what has come in and what waits to go out, both bounded."""

import contextlib
import select
import socket

PART = 65536  # read at once
OUT_LIMIT = 1 << 20  # bytes that nobody fetches: then he is hung up
IN, OUT, GONE = select.EPOLLIN, select.EPOLLOUT, select.EPOLLHUP | select.EPOLLERR


class Connection:
    """Knows bytes only; those who derive from it know requests."""

    def __init__(self, sock: socket.socket, poll: select.epoll):
        sock.setblocking(False)  # nobody who does not read his replies can hold us up
        self.sock, self._poll = sock, poll
        self.data, self._out = bytearray(), bytearray()
        self.ended = False  # nothing more will come
        self.busy = False  # a request of it is under way
        self.held = False  # its request waits for the end of a pause
        self._mask = IN
        poll.register(sock, IN)

    # --- requests: for those who derive ---

    def has_request(self) -> bool:
        """A whole request is there. What cannot become one ends the connection."""
        raise NotImplementedError

    def serve(self, nested: bool) -> bool:
        """Serves one. nested: another client's request waits meanwhile; then False is an answer,
        and this one is asked again later."""
        raise NotImplementedError

    def client_writes(self) -> bool:
        """It belongs to somebody who may move the machine: time goes slowly while he talks."""
        return True

    def fail(self, why: str) -> None:
        """The request that was being served could not be."""

    def leave(self) -> None:
        """It is gone."""

    # --- bytes ---

    def receive(self) -> bool:
        """Takes what is there, unless a request waits already; True: there was something."""
        if self.ended or self.has_request():
            return False
        try:
            data = self.sock.recv(PART)
        except BlockingIOError:
            return False
        except OSError:
            data = b""
        self.data += data
        if not data:
            self.end()
        return bool(data)

    def end(self) -> None:
        self.ended = True
        self.watch(0)

    def send(self, data: bytes) -> None:
        self._out += data
        self.flush()

    def idle(self) -> bool:
        """Everything sent has gone out."""
        return not self._out

    def flush(self) -> None:
        if self._out and not self.ended:
            try:
                del self._out[: self.sock.send(self._out)]
            except BlockingIOError:
                pass
            except OSError:
                self.end()
        if len(self._out) > OUT_LIMIT:
            self.end()
        if not self.ended:
            self.watch(self._mask | OUT if self._out else self._mask & ~OUT)

    def watch(self, mask: int) -> None:
        if mask != self._mask:
            self._mask = mask
            self._poll.modify(self.sock, mask)

    def close(self) -> None:
        with contextlib.suppress(OSError, ValueError):
            self._poll.unregister(self.sock)
        self.sock.close()
