# SPDX-License-Identifier: Apache-2.0
"""Files and WebSockets for one browser on this machine: what gateway and stop process share.

Everything stands below the token: http://127.0.0.1:PORT/TOKEN/... Without it there is nothing, so
that another user of the machine, who can reach the port, finds neither page nor socket. A
WebSocket must come from an origin that the server was told; pages of other sites are turned away.
"""

import hashlib
import hmac
import http
import mimetypes
import os
import sys
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from mmcs import ROOT

PAGES = ROOT / "web"
LOOPBACK = "127.0.0.1"
# What an address below lib/ means; packages of npm, fetched by `make tool`, never committed.
LIBRARIES = {"preact": "preact/dist", "uplot": "uplot/dist"}


def library_folder() -> Path:
    """Of tools/libraries.py: inside the Python environment; in a wheel, beside the pages."""
    packed = PAGES / "lib"
    return packed if packed.is_dir() else Path(sys.prefix) / "share" / "mmcs" / "node_modules"


@dataclass(frozen=True)
class Site:
    """What one process shows: its token, the origins that may connect, and its policy."""

    token: str
    origins: Sequence[str]
    policy: str  # the value of Content-Security-Policy
    pages: frozenset[str] | None = None  # files that may be seen; None: all

    def path(self, target: str) -> str | None:
        """What is asked for below the token; None for somebody without it."""
        first, _, rest = unquote(target.partition("?")[0]).removeprefix("/").partition("/")
        same = hmac.compare_digest(first.encode(), self.token.encode())
        return (rest or "index.html") if same else None

    def answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """A file, a refusal, or None: a WebSocket may be opened."""
        path = self.path(request.path)
        if request.method != "GET":
            return connection.respond(http.HTTPStatus.METHOD_NOT_ALLOWED, "GET alone\n")
        if path is None or "\0" in path:
            return connection.respond(http.HTTPStatus.NOT_FOUND, "not here\n")
        if any(value.lower() == "websocket" for value in request.headers.get_all("Upgrade")):
            origins = request.headers.get_all("Origin")  # of a request that is none, several
            if len(origins) == 1 and origins[0] in self.origins:
                return None
            return connection.respond(http.HTTPStatus.FORBIDDEN, "not from that page\n")
        if self.pages is not None and path not in self.pages:
            return connection.respond(http.HTTPStatus.NOT_FOUND, "not here\n")
        return self._file(connection, path, request.headers.get("If-None-Match"))

    def _file(self, connection: ServerConnection, path: str, known: str | None) -> Response:
        """known: the ETag of what the browser has already."""
        file = _locate(path)
        if file is None:
            return connection.respond(http.HTTPStatus.NOT_FOUND, f"no such page: {path}\n")
        kind = mimetypes.guess_type(file.name)[0] or "application/octet-stream"
        if kind.startswith("text/") or kind.endswith("javascript"):
            kind += "; charset=utf-8"
        body = file.read_bytes()
        tag = f'"{hashlib.sha256(body).hexdigest()[:32]}"'
        headers = Headers(
            {
                "Content-Type": kind,
                "Content-Length": str(len(body)),
                "Content-Security-Policy": self.policy,
                "Referrer-Policy": "no-referrer",
                "X-Content-Type-Options": "nosniff",
                "Cache-Control": "no-cache",
                "ETag": tag,
                "Connection": "close",
            }
        )
        if known == tag:
            del headers["Content-Length"]
            return Response(304, "Not Modified", headers, b"")
        return Response(200, "OK", headers, body)


def listen(
    client: Callable[[ServerConnection], Awaitable[None]], site: Site, port: int, max_size: int
) -> serve:
    """Serves a site on this computer alone; `client` has each WebSocket, messages up to max_size
    bytes.

    Nobody is hung up on for a late pong: that of a page that is starved, or stopped in a debugger,
    waits behind samples unread. A page that is gone has closed its connection, and one that is
    silent while it controls is the dead man's business."""
    return serve(
        client,
        LOOPBACK,
        port,
        process_request=site.answer,
        max_size=max_size,
        compression=None,
        server_header=None,
        ping_interval=None,
    )


def _locate(path: str) -> Path | None:
    """The file of an address; None if there is none, or it lies outside its folder."""
    base, rest = PAGES, path
    if path.startswith("lib/"):
        package, _, rest = path.removeprefix("lib/").partition("/")
        if package not in LIBRARIES:
            return None
        base = library_folder() / LIBRARIES[package]
    file = (base / rest).resolve()
    inside = file.is_relative_to(base.resolve())
    return file if inside and os.path.isfile(file) else None  # no name is too long to ask about
