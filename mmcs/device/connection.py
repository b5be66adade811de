# SPDX-License-Identifier: Apache-2.0
"""An accepted socket: an open device, a channel, a client of the messages, one of the stop path."""

import contextlib
import select

PART = 1 << 17  # read at once; a request at the wire is one packet, and smaller
IN, OUT, GONE = select.EPOLLIN, select.EPOLLOUT, select.EPOLLHUP | select.EPOLLERR


class Connection:
    """Knows bytes only; those who derive from it know requests. They have receive(), which takes
    what has come unless a request waits already, and serve(nested), which does one; nested: another
    client's request waits meanwhile, and what would wait is asked again later."""

    def __init__(self, sock, server):
        sock.setblocking(False)  # nobody who does not read his replies can hold us up
        self.sock, self.server, self.machine = sock, server, server.machine
        self.ended = False  # nothing more will come
        self.busy = False  # a request of it is under way
        self.paused_at: float | None = None  # when its request met a pause, whose end it waits for
        self._mask = IN
        server.poll.register(sock, IN)

    # --- for those who derive ---

    def has_request(self) -> bool:
        """A whole request is there. What cannot become one ends the connection."""
        return False

    def fail(self, why: str) -> None:
        """The request that was being served could not be."""

    def leave(self) -> None:
        """It is gone."""

    # --- bytes ---

    def take(self) -> bytes:
        """What has come; b"": nothing has, or the end."""
        try:
            data = self.sock.recv(PART)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self.end()
        return data

    def end(self) -> None:
        self.ended = True
        self.watch(0)

    def watch(self, mask: int) -> None:
        if mask != self._mask:
            self._mask = mask
            self.server.poll.modify(self.sock, mask)

    def close(self) -> None:
        with contextlib.suppress(OSError, ValueError):
            self.server.poll.unregister(self.sock)
        self.sock.close()
