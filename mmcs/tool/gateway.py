# SPDX-License-Identifier: Apache-2.0
"""The page's server: files, and a WebSocket for each page to the machine's messages.

Passes messages on unread (docs/use/protocol.md); a page that reads too slowly stops being read for,
and the machine's ring counts what it then loses. A process of its own: STOP does not depend on it.
"""

import asyncio
import contextlib
import errno
import json
import os
import struct
import sys
from pathlib import Path

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from mmcs.errors import InputError
from mmcs.labs import offered
from mmcs.tool.pages import LOOPBACK, Site, listen

LENGTH = struct.Struct("<I")
MAX_MESSAGE = 1 << 26  # from the machine: samples of the whole ring
MAX_RECORDING = 1 << 27  # from the page: a recording to be made an MCAP file
GONE = 4001  # close code of a WebSocket: the machine is gone
MOST_WORKERS = 8  # at once, of all pages: each is a process of some 30 MB
LEAVE_S = 5.0  # for a worker to end by itself once its page is gone
_at_work: set[ServerConnection] = set()


async def to_page(reader: asyncio.StreamReader, page: ServerConnection) -> None:
    """Texts as text frames, samples as binary ones."""
    while True:
        (length,) = LENGTH.unpack(await reader.readexactly(LENGTH.size))
        if length > MAX_MESSAGE:
            return
        data = await reader.readexactly(length)
        await page.send(data.decode() if data[:1] == b"{" else data)


async def to_machine(page: ServerConnection, writer: asyncio.StreamWriter) -> None:
    async for message in page:
        if not isinstance(message, str):
            return
        data = message.encode()
        writer.write(LENGTH.pack(len(data)) + data)
        await writer.drain()


async def carry(page: ServerConnection, path: Path) -> None:
    """One page, one connection to the machine, until either hangs up."""
    try:
        reader, writer = await asyncio.open_unix_connection(str(path))
    except OSError:
        await page.close(GONE, "the machine is gone; start it again")
        return
    both = [
        asyncio.create_task(to_page(reader, page)),
        asyncio.create_task(to_machine(page, writer)),
    ]
    await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
    for task in both:
        task.cancel()
    ends = await asyncio.gather(*both, return_exceptions=True)
    writer.close()
    lost = any(isinstance(end, EOFError | ConnectionError) for end in ends)  # of the machine's end
    with contextlib.suppress(ConnectionClosed):
        await page.close(GONE if lost else 1000, "the machine is gone" if lost else "")


async def advise(page: ServerConnection, what: str, module: str, *given: str) -> None:
    """A worker for one page (mmcs/tool/worker.py): a process of its own, one line a message.

    It ends with the page, and stops what it had begun; should it end before, the page is told."""
    if len(_at_work) >= MOST_WORKERS:
        await page.close(GONE, f"{MOST_WORKERS} designers and graders are open: close a page")
        return
    _at_work.add(page)
    try:
        await _work(page, what, module, *given)
    finally:
        _at_work.discard(page)


async def _work(page: ServerConnection, what: str, module: str, *given: str) -> None:
    worker = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", module, *given),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        limit=MAX_MESSAGE,
    )

    async def back() -> None:
        with contextlib.suppress(ConnectionClosed, ValueError):  # too long a line
            async for line in worker.stdout:
                await page.send(line.decode())
            await page.close(GONE, f"the {what} is gone; load the page again")

    answers = asyncio.create_task(back())
    with contextlib.suppress(ConnectionClosed, BrokenPipeError, ConnectionResetError):
        async for message in page:
            if not isinstance(message, str):
                break
            worker.stdin.write(message.encode().replace(b"\n", b" ") + b"\n")
            await worker.stdin.drain()
    worker.stdin.close()
    with contextlib.suppress(TimeoutError):
        await asyncio.wait_for(worker.wait(), LEAVE_S)
    if worker.returncode is None:
        worker.kill()
        await worker.wait()
    answers.cancel()


async def main(config: dict) -> None:
    """config: token, socket, stop (address of the stop button's frame), sheets (folder of own
    lab sheets, or null), port (0: any).

    Says its address on standard output in one line and serves until standard input ends."""
    stop = config["stop"]
    stop_origin = stop.rsplit("/", 2)[0]
    policy = (
        "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
        f"frame-src {stop_origin}; connect-src 'self' {stop_origin.replace('http', 'ws')}; "
        "frame-ancestors 'none'"
    )
    origins: list[str] = []  # known once the port is
    path = Path(config["socket"])
    workers = {
        "advice": ("designer", "mmcs.tool.advisor", config["socket"]),
    }
    with contextlib.suppress(InputError):  # no lab sheets are installed
        given = [config["sheets"]] if config["sheets"] else []
        workers["labs"] = ("grader", offered("page").module, *given)

    site = Site(config["token"], origins, policy)

    async def page(connection: ServerConnection) -> None:
        where = site.path(connection.request.path)
        with contextlib.suppress(ConnectionClosed):
            if where == "machine":
                await carry(connection, path)
            elif where in workers:
                await advise(connection, *workers[where])

    try:
        listening = await listen(page, site, config.get("port", 0), MAX_RECORDING)
    except OSError as error:
        used = "is in use by another program; 0 takes a free one"
        words = used if error.errno == errno.EADDRINUSE else os.strerror(error.errno)
        print(json.dumps({"error": words}), flush=True)
        return
    async with listening as server:
        port = server.sockets[0].getsockname()[1]
        origins.append(f"http://{LOOPBACK}:{port}")
        address = f"{origins[0]}/{config['token']}/?stop={stop}"
        print(json.dumps({"address": address}), flush=True)
        await asyncio.to_thread(sys.stdin.read)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(main(json.loads(sys.stdin.readline())))
