# SPDX-License-Identifier: Apache-2.0
"""The tool's end of the stop path: an order comes through, or it is told that none does."""

import asyncio
import functools
import json
from pathlib import Path

import pytest

from mmcs.tool import stopper
from mmcs.tool.stopper import Button, StopPath

pytestmark = pytest.mark.req("TOOL-1")


def in_a_loop(test):
    """The test, which is a coroutine, as a function."""
    return functools.wraps(test)(lambda *given, **named: asyncio.run(test(*given, **named)))


async def fake_stop_path(folder: Path, answers: dict[str, str]):
    async def serve(reader, writer):
        while line := await reader.readline():
            writer.write((answers[line.decode().strip()] + "\n").encode())

    return await asyncio.start_unix_server(serve, str(folder / "x.stop"))


@in_a_loop
async def test_the_stop_path_is_asked_in_order_and_found_again(tmp_path):
    path = StopPath(tmp_path / "x.stop")
    with pytest.raises(OSError):
        await path.ask("stop")
    async with await fake_stop_path(tmp_path, {"stop": "stopped 1.5", "state": "state 2 a 1"}):
        answers = await asyncio.gather(path.ask("stop"), path.ask("state"))
        assert answers == ["stopped 1.5", "state 2 a 1"]
        path.hang_up()
        assert await path.ask("stop") == "stopped 1.5"
        path.hang_up()


@in_a_loop
async def test_an_answer_that_is_none_is_told_as_no_answer(tmp_path, monkeypatch):
    """Of another program's socket, too: the button stays connected to its page."""
    monkeypatch.setattr(stopper, "PATIENCE_S", 0.1)
    async with await fake_stop_path(tmp_path, {"stop": 70_000 * "x"}):
        path = StopPath(tmp_path / "x.stop")
        with pytest.raises(OSError):
            await path.ask("stop")


@in_a_loop
async def test_a_stop_comes_through_when_others_have_taken_its_place(serving):
    """The stop path keeps 64 connections; the oldest is hung up on."""
    where = serving.server.path.with_suffix(".stop")
    path = StopPath(where)
    assert (await path.ask("stop")).startswith("stopped")
    others = [await asyncio.open_unix_connection(str(where)) for _ in range(70)]
    while not path.reader.at_eof():
        await asyncio.sleep(0.001)
    assert (await path.ask("stop")).startswith("stopped")
    path.hang_up()
    for _, writer in others:
        writer.close()


@in_a_loop
async def test_a_stop_comes_through_however_often_its_connection_is_closed(tmp_path):
    """Others may come so fast that a new connection is closed before its answer, too."""
    left = 5

    async def serve(reader, writer):
        nonlocal left
        await reader.readline()
        left -= 1
        if left < 0:
            writer.write(b"stopped 1.5\n")
        writer.close()

    async with await asyncio.start_unix_server(serve, str(tmp_path / "x.stop")):
        path = StopPath(tmp_path / "x.stop")
        assert await path.ask("stop") == "stopped 1.5"
        path.hang_up()


@in_a_loop
async def test_a_stop_comes_through_after_the_machine_was_started_again(tmp_path):
    path = StopPath(tmp_path / "x.stop")
    for _ in range(2):
        async with await fake_stop_path(tmp_path, {"stop": "stopped 1.5"}):
            assert await path.ask("stop") == "stopped 1.5"
            path.writer.transport.abort()  # as the end of the machine does
    with pytest.raises(OSError):
        await path.ask("stop")


@in_a_loop
async def test_a_machine_that_does_not_answer_is_told(tmp_path, monkeypatch):
    button = Button(tmp_path / "nowhere.stop")
    button.clients, said = {object()}, []
    monkeypatch.setattr(stopper, "broadcast", lambda _, text: said.append(json.loads(text)))
    await button.order("stop", 0.0)
    watching = asyncio.create_task(button.watch())
    while len(said) < 2:
        await asyncio.sleep(0.001)
    watching.cancel()
    assert said == [{"order": "stop", "failed": "the machine does not answer"}, {"state": None}]
