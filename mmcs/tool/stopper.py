# SPDX-License-Identifier: Apache-2.0
"""The stop button's own process, port and page: STOP, and the hand-held button.

The frame comes from another site than the page around it (localhost, not 127.0.0.1), so that a
browser gives it a process of its own: it lives while the page's scripts hang. Its WebSocket leads
to the machine's stop path, which shares nothing with the stream (docs/use/protocol.md).
"""

import asyncio
import contextlib
import json
import sys
import time
from pathlib import Path

from websockets.asyncio.server import ServerConnection, broadcast
from websockets.exceptions import ConnectionClosed

from mmcs.tool.pages import Site, listen

FRAME = frozenset({"stop.html", "stop.js", "stop.css", "look.css"})
ORDERS = frozenset({"stop", "press", "release"})
MAX_ORDER = 64  # bytes
WATCH_S = 0.1  # between looks at the machine's state
PATIENCE_S = 2.0  # without an answer the machine is told as not answering


class StopPath:
    """One connection to NAME.stop; lines are answered in order."""

    def __init__(self, path: Path):
        self.path, self.lock = path, asyncio.Lock()
        self.reader = self.writer = None

    async def ask(self, line: str) -> str:
        """The machine's answer; OSError or TimeoutError if there is none.

        A connection may be closed before the answer: the machine closes the oldest when too many
        come, and may have been started again. Then the line is sent on a new one."""
        async with self.lock:
            try:
                async with asyncio.timeout(PATIENCE_S):
                    while True:
                        if self.writer is None:
                            opening = asyncio.open_unix_connection(str(self.path))
                            self.reader, self.writer = await opening
                        with contextlib.suppress(OSError, ValueError):  # or garbage
                            return await self._say(line)
                        self.hang_up()
            except (OSError, TimeoutError):
                self.hang_up()  # a late answer would be taken for that of the next line
                raise

    async def _say(self, line: str) -> str:
        self.writer.write(line.encode() + b"\n")
        await self.writer.drain()
        answer = await self.reader.readline()
        if not answer.endswith(b"\n"):
            raise ConnectionResetError("the machine is gone")
        return answer.decode().strip()

    def hang_up(self) -> None:
        if self.writer is not None:
            self.writer.close()
        self.reader = self.writer = None


class Button:
    """Orders from frames, and what became of them, told to every frame and page."""

    def __init__(self, path: Path):
        # orders and looks have a connection each: an order waits for nobody
        self.orders, self.looks = StopPath(path), StopPath(path)
        self.clients: set[ServerConnection] = set()

    async def order(self, order: str, since: float) -> None:
        try:
            answer = await self.orders.ask(order)
            said = {"order": order, "answer": answer, "ms": (time.monotonic() - since) * 1e3}
        except (OSError, TimeoutError):
            said = {"order": order, "failed": "the machine does not answer"}
        broadcast(self.clients, json.dumps(said))

    async def watch(self) -> None:
        """The machine's state, to all clients, while there are any."""
        while True:
            await asyncio.sleep(WATCH_S)
            if not self.clients:
                continue
            try:
                words = (await self.looks.ask("state")).split()
                state = dict(zip(words[2::2], map(int, words[3::2]), strict=True))
                said = {"state": state | {"t": float(words[1])}}
            except (OSError, TimeoutError, ValueError, IndexError):
                said = {"state": None}
            broadcast(self.clients, json.dumps(said))

    async def serve(self, client: ServerConnection) -> None:
        self.clients.add(client)
        try:
            async for message in client:
                if message not in ORDERS:
                    break  # a flood of it would keep orders waiting
                await self.order(message, time.monotonic())
        finally:
            self.clients.discard(client)


async def main(config: dict) -> None:
    """config: token, socket (NAME.stop), port (0: any). Ends when standard input does.

    Its first line of output is the frame's address; the second line of input the page's origin."""
    button = Button(Path(config["socket"]))
    origins: list[str] = []
    policy = "default-src 'self'; frame-ancestors http://127.0.0.1:*"

    async def client(connection: ServerConnection) -> None:
        with contextlib.suppress(ConnectionClosed):
            await button.serve(connection)

    site = Site(config["token"], origins, policy, FRAME)

    async with listen(client, site, config.get("port", 0), MAX_ORDER) as server:
        port = server.sockets[0].getsockname()[1]
        origins.append(f"http://localhost:{port}")
        told = json.dumps({"address": f"{origins[0]}/{config['token']}/stop.html"})
        sys.stdout.write(told + "\n")  # for the program that started this one
        sys.stdout.flush()
        origins.append((await asyncio.to_thread(sys.stdin.readline)).strip())
        watching = asyncio.create_task(button.watch())
        await asyncio.to_thread(sys.stdin.read)
        watching.cancel()


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(main(json.loads(sys.stdin.readline())))
