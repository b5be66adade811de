# SPDX-License-Identifier: Apache-2.0
"""mctool without a browser: pages, stop process, designer, recordings."""

import asyncio
import io
import json
import socketserver
import sys
from pathlib import Path

import pytest
from websockets.asyncio.client import connect
from websockets.asyncio.connection import Connection
from websockets.exceptions import ConnectionClosed

from mmcs import ROOT
from mmcs.device.client import Device
from mmcs.device.sockets import socket_path
from mmcs.mcdef import M_VERBOSE
from mmcs.tests.device_bench import write_scenario
from mmcs.tool import gateway, launch, pages
from mmcs.tool.advisor import Advisor
from mmcs.tool.launch import _end, _serve
from mmcs.tool.stopper import Button
from tools.compiled import ran

PIPE = 65536  # bytes that a pipe holds


class Said(io.StringIO):
    def replies(self) -> list[dict]:
        return [json.loads(line) for line in self.getvalue().splitlines()]


def advise(*messages: dict | str) -> list[dict]:
    out, lines = Said(), (m if isinstance(m, str) else json.dumps(m) for m in messages)
    Advisor(Path("/nonexistent.sock"), out).run(f"{line}\n" for line in lines)
    return out.replies()


@pytest.mark.req("TOOL-1")
def test_a_mistake_of_ours_is_told_and_the_designer_goes_on(monkeypatch):
    def broken(self, message):
        raise RuntimeError("unknown file format")

    monkeypatch.setattr(Advisor, "do_waves", broken)
    first, second = advise({"id": 1, "op": "waves"}, {"id": 2, "op": "dance"})
    assert first == {"id": 1, "error": "waves: RuntimeError: unknown file format"}
    assert second["id"] == 2


ORIGIN = "http://127.0.0.1:1"
SITE = pages.Site("secret", (ORIGIN,), "")


def played(client, play, **options):
    """What play(page) gives, of a page of a site whose end of the connection is client(page)."""

    async def connected():
        async with pages.listen(client, SITE, 0, 64) as server:
            where = f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}/secret/x"
            async with connect(where, origin=ORIGIN, **options) as page:
                return await play(page)

    return asyncio.run(connected())


@pytest.mark.req("TOOL-1")
def test_a_page_is_told_when_its_designer_dies(monkeypatch):
    def designer(page):
        return gateway.advise(page, "designer", "mmcs.tool.advisor", "")

    async def play(page):
        with pytest.raises(ConnectionClosed):
            await asyncio.wait_for(page.recv(), 240)
        return page.close_code, page.close_reason

    monkeypatch.setattr(gateway.sys, "executable", "true")
    told = "the designer is gone; load the page again"
    assert played(designer, play) == (gateway.GONE, told) and not gateway._at_work


@pytest.mark.req("TOOL-1")
def test_no_address_leads_out_of_the_pages():
    site = pages.Site("secret", ("http://127.0.0.1:1",), "", frozenset({"stop.html"}))
    assert site.path("/secret/") == "index.html"
    assert site.path("/secret/a/b.js?x=1") == "a/b.js"
    for target in ("/", "/secre/index.html", "/secrets/index.html", "//secret/x", "/%73ecret"):
        assert site.path(target) in (None, "index.html" if target == "/%73ecret" else None)
    out = "../pyproject.toml", "lib/../main.js", "lib/uplot/../../x", "/etc/passwd", "", "lib/x/y"
    for path in out:
        assert pages._locate(path) is None, path
    assert pages._locate("index.html") == ROOT / "web" / "index.html"


@pytest.mark.req("TOOL-1")
def test_a_page_too_slow_to_answer_a_ping_is_not_hung_up_on(monkeypatch):
    """As if each had been late at once."""

    async def late(connection):
        connection.transport.abort()

    async def echo(page):
        async for message in page:
            await asyncio.sleep(0)
            await page.send(message)

    async def play(page):
        for n in range(3):
            await page.send(str(n))
            assert await page.recv() == str(n)

    monkeypatch.setattr(Connection, "keepalive", late)
    played(echo, play, ping_interval=None)


@pytest.mark.req("TOOL-1")
def test_a_machine_waits_for_nobody_to_hear_the_driver(mc0, tmp_path):
    """It said so much that a pipe that nobody reads is full: not even STOP would come through."""
    socket = socket_path("talking")
    machine = _serve(str(write_scenario(tmp_path)), "talking", socket)
    try:
        with Device(server="talking") as dev:
            dev.set_verbosity(M_VERBOSE)
            for _ in range(PIPE // len("mc: stopped")):
                dev.stop()
        assert machine.poll() is None
    finally:
        _end(machine)


@pytest.mark.req("TOOL-1")
def test_the_pages_logic():
    node = Path(sys.executable).with_name("node")
    ended = ran(node, "--test", *sorted((ROOT / "web" / "tests").glob("*.test.mjs")))
    assert ended.returncode == 0, ended.stdout


@pytest.mark.req("TOOL-1")
def test_a_port_in_use_is_one_line(mmcs, mc0, tmp_path, monkeypatch):
    monkeypatch.setattr(launch, "check_libraries", lambda: None)  # `make tool` installs them
    with socketserver.TCPServer(("127.0.0.1", 0), None) as other:
        port = str(other.server_address[1])
        scenario = write_scenario(tmp_path)
        status, _, stderr = mmcs("tool", "--no-browser", "--port", port, scenario)
    assert status == 2
    assert stderr.strip().splitlines()[-1].startswith(f"mmcs: --port = {port}: is in use")
    assert "Traceback" not in stderr


PD = {"a0": 4526, "a1": -4416, "a2": 0, "b0": 64, "b1": 0, "b2": 0, "ic_pos": 0, "ic_neg": 0,
      "ilim": 1024, "mode": 1}  # fmt: skip


TOOK = {"rise_ms": 50.0, "overshoot_pct": 1.0, "settle_ms": 100.0, "steady_error_counts": 1.0}


def shake(*requests: str, client=None) -> list[bytes]:
    """The first lines of what a site answers."""

    async def play():
        async with pages.listen(client, SITE, 0, 64) as server:
            port, answers = server.sockets[0].getsockname()[1], []
            for request in requests:
                reader, writer = await asyncio.open_connection("127.0.0.1", port)
                writer.write(f"{request}\r\n\r\n".encode())
                answers.append((await reader.readline()).strip())
                writer.close()
            return answers

    return asyncio.run(play())


@pytest.mark.req("TOOL-1")
def test_a_request_that_is_none_is_refused_and_not_logged(caplog):
    """By whoever reaches the port, with the token or without it."""
    other = "GET /secret/x HTTP/1.1\r\nUpgrade: websocket\r\nX: "
    socket = f"{other}\r\nOrigin: {ORIGIN}\r\n"
    answers = shake(
        "GET http://[::1/secret/ HTTP/1.1", "GET //[ HTTP/1.1",
        f"GET /secret/{'a' * 3000} HTTP/1.1", f"GET /secret/{'aa/' * 2000} HTTP/1.1",
        f"{socket}Origin: http://evil", other, f"{other}\r\nOrigin: http://evil",
        f"{other}\r\nOrigin: {ORIGIN}0", f"{socket}Upgrade: websocket",
    )  # fmt: skip
    assert [answer.split()[1] for answer in answers] == 4 * [b"404"] + 4 * [b"403"] + [b"426"]
    assert not caplog.records


@pytest.mark.req("TOOL-1")
@pytest.mark.parametrize("end", ["designer", "hung designer", "button"])
def test_what_no_page_of_ours_sends_ends_its_connection_alone(tmp_path, monkeypatch, caplog, end):
    """And its designer, which is killed if it hangs."""
    worker, heard = tmp_path / "worker", tmp_path / "heard"
    more = "exec sleep 1000" if end == "hung designer" else ""
    worker.write_text(f"#!/bin/sh\necho $$\ncat > {heard}\n{more}\n")
    worker.chmod(0o755)
    monkeypatch.setattr(gateway.sys, "executable", str(worker))
    monkeypatch.setattr(gateway, "LEAVE_S", 0.1 if more else 240)
    button, ended = Button(tmp_path / "nowhere.stop"), asyncio.Event()

    async def client(page):
        await (button.serve(page) if end == "button" else gateway.advise(page, end, "", ""))
        ended.set()

    async def play(page):
        pid = 0 if end == "button" else int(await page.recv())
        for text in ("state", "stop") if end == "button" else ("a\nb", "c", b"stop"):
            await page.send(text)
        with pytest.raises(ConnectionClosed):
            await page.recv()
        await ended.wait()
        assert not pid or not Path(f"/proc/{pid}").exists()

    played(client, play)
    assert end == "button" or heard.read_text() == "a b\nc\n"
    assert not caplog.records and not button.clients and not gateway._at_work
