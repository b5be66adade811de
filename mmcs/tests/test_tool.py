# SPDX-License-Identifier: Apache-2.0
"""mctool without a browser: pages, stop process, designer, identification, recordings."""

from __future__ import annotations

import asyncio
import base64
import io
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from websockets.asyncio.client import connect
from websockets.asyncio.connection import Connection
from websockets.exceptions import ConnectionClosed

from mmcs import ROOT
from mmcs.design.identify import IdentifyError, frequency, identify
from mmcs.design.synthesis import discretize, margins
from mmcs.device.client import Device
from mmcs.device.sockets import socket_path
from mmcs.mcdef import M_VERBOSE
from mmcs.tests.device_bench import write_scenario
from mmcs.tool import gateway, moment, pages, tune
from mmcs.tool.advisor import Advisor
from mmcs.tool.launch import _end, _serve
from mmcs.tool.stopper import Button, StopPath

PIPE = 65536  # bytes that a pipe holds


def recording(g=150.0, lag=3.0, pos=300.0, neg=350.0, seconds=4.0, dt=1e-3, sign=1):
    """A motor driven back and forth in torque mode, integrated finely; counts as an encoder has."""
    t, y, u, at, v, current, sub = [], [], [], 0.0, 0.0, 0.0, 20
    for n in range(int(seconds / dt)):
        t.append(n * dt)
        y.append(int(np.floor(sign * at)))
        current = (500, 800, 1200)[n // 300 % 3] * (1 if n // 150 % 2 else -1)
        u.append(current)
        for _ in range(sub):
            drag = pos if v > 0 else -neg if v < 0 else float(np.clip(current, -neg, pos))
            after = v + (g * (current - drag) - lag * v) * dt / sub
            v = 0.0 if v * after < 0 else after
            at += v * dt / sub
    return np.array(t), np.array(y), np.array(u)


@pytest.mark.req("TOOL-1", "SYN-1")
@pytest.mark.parametrize(
    "g,lag,pos,neg", [(150, 3, 300, 350), (760, 2, 70, 106), (1450, 0.3, 105, 105)]
)
def test_the_motor_is_found_in_its_motion(g, lag, pos, neg):
    motor = identify(*recording(g, lag, pos, neg))
    assert motor.g == pytest.approx(g, rel=0.02)
    assert motor.lag == pytest.approx(lag, abs=1.0)
    assert motor.tc_pos == pytest.approx(pos, abs=12)
    assert motor.tc_neg == pytest.approx(neg, abs=12)


@pytest.mark.req("TOOL-1")
def test_what_a_recording_does_not_tell_is_said():
    t, y, u = recording()
    with pytest.raises(IdentifyError, match="too few"):
        identify(t[:50], y[:50], u[:50])
    with pytest.raises(IdentifyError, match="hardly moves"):
        identify(t, y * 0, u)
    with pytest.raises(IdentifyError, match="one way"):
        identify(t, np.cumsum(np.arange(len(t))) // 50, u)
    with pytest.raises(IdentifyError, match="does not follow"):
        rng = np.random.default_rng(1)
        walk = np.cumsum(np.cumsum(rng.integers(-40, 41, len(t))))
        identify(t, walk, u)
    reversed_ = identify(*recording(sign=-1))
    assert reversed_.g < 0


@pytest.mark.req("TOOL-1")
def test_a_measured_frequency_response_is_that_of_the_system():
    t = np.arange(20000) * 1e-3
    w = 100 * np.sin(2 * np.pi * np.cumsum(1 + 1.5 * t) * 1e-3)
    y, a = np.zeros_like(w), 0.9
    for n in range(1, len(w)):
        y[n] = a * y[n - 1] + (1 - a) * w[n]
    made = frequency(t, w, y, 2, 25)
    z = np.exp(2j * np.pi * made.hz * 1e-3)
    truth = (1 - a) / (1 - a / z)
    assert len(made.hz) > 20
    assert np.max(np.abs(made.gain_db - 20 * np.log10(abs(truth)))) < 0.3
    assert np.max(np.abs(made.phase_deg - np.degrees(np.angle(truth)))) < 3


@pytest.mark.req("TOOL-1", "SYN-1")
def test_tuned_gains_keep_a_count_quiet_and_the_loop_stable():
    motor = identify(*recording())
    controller, made = tune.gains(motor, 50.0, 1.0, 1e-3)
    assert abs(made.a[0] / made.b[0]) < tune.D_PER_COUNT + controller.p + 1
    assert controller.tau > 0
    assert margins(made.discrete(), motor.plant, 1e-3).stable
    assert discretize(controller, "backward", 1e-3).poles().real.min() > -0.9


class Said(io.StringIO):
    def replies(self) -> list[dict]:
        return [json.loads(line) for line in self.getvalue().splitlines()]


def advise(*messages: dict) -> list[dict]:
    out = Said()
    Advisor(Path("/nonexistent.sock"), out).run(json.dumps(m) + "\n" for m in messages)
    return out.replies()


@pytest.mark.req("TOOL-1")
def test_the_designer_answers_in_order_and_survives_nonsense():
    replies = advise(
        {"id": 1, "op": "design", "p": 4, "d": 0.1, "interval_s": 0.001},
        {"id": 2, "op": "dance"},
        {"id": 3, "op": "design", "p": "much"},
        {"id": 4, "op": "design", "p": 1e300, "d": 1e300, "interval_s": 1e-300},
        {"id": 5, "op": "design", "p": 0, "interval_s": 0.001},
        {"id": 6, "op": "mcap", "csv": "nonsense"},
    )
    assert [reply["id"] for reply in replies] == [1, 2, 3, 4, 5, 6]
    c = replies[0]["coefficients"]
    assert ((c["a0"] + c["a1"]) / c["b0"], -c["a1"] / c["b0"]) == (4, 100)
    assert all("error" in reply for reply in (*replies[1:4], replies[5]))
    assert replies[4]["coefficients"]["a0"] == 0


@pytest.mark.req("TOOL-1")
def test_a_mistake_of_ours_is_told_and_the_designer_goes_on(monkeypatch):
    def broken(self, message):
        raise RuntimeError("unknown file format")

    monkeypatch.setattr(Advisor, "do_trace", broken)
    first, second = advise({"id": 1, "op": "trace"}, {"id": 2, "op": "dance"})
    assert first == {"id": 1, "error": "trace: RuntimeError: unknown file format"}
    assert second["id"] == 2


@pytest.mark.req("TOOL-1")
def test_no_file_is_made_of_a_moment_before_which_nothing_is_known(monkeypatch):
    """Gone back to the first snapshot, and nothing after it has happened yet."""
    monkeypatch.setattr(moment, "find", lambda *_: moment.Moment(None, b"", b"", 0.3, 0.3))
    *_, reply = advise({"id": 1, "op": "trace", "t": 0.3, "ms": 2})
    assert "nothing has happened yet around 0.300000 s" in reply["error"]


@pytest.mark.req("TOOL-1")
def test_a_page_is_told_when_its_designer_dies(monkeypatch):
    async def play():
        origin = "http://127.0.0.1:1"
        site = pages.Site("secret", (origin,), "")
        async with pages.listen(lambda page: gateway.advise(page, Path()), site, 0, 64) as server:
            port = server.sockets[0].getsockname()[1]
            async with connect(f"ws://127.0.0.1:{port}/secret/x", origin=origin) as page:
                with pytest.raises(ConnectionClosed):
                    await asyncio.wait_for(page.recv(), 240)
                return page.close_code, page.close_reason

    monkeypatch.setattr(gateway.sys, "executable", "true")
    assert asyncio.run(play()) == (gateway.GONE, "the designer is gone; load the page again")


@pytest.mark.req("TOOL-1")
def test_a_predicted_step_ends_at_its_size():
    param = {"a0": 104, "a1": -100, "a2": 0, "b0": 1, "b1": 0, "b2": 0}
    (made,) = advise({"id": 1, "op": "predict", "param": param, "interval_s": 0.001, "step": 200,
                      "motor": {"g": 1450.0, "lag": 0.3}, "seconds": 1.0})  # fmt: skip
    assert made["stable"]
    assert made["y"][-1] == pytest.approx(200, abs=1)
    assert made["bode_db"][0] == pytest.approx(0, abs=0.2)


@pytest.mark.req("TOOL-1")
def test_a_recording_becomes_mcap_that_readers_read():
    from mcap.reader import make_reader

    head = "t_s,lines,encnow_0,error_0,encnow_1,error_1"
    text = f"{head}\n0.001000000,6,5,1,7,-2\n0.002000000,6,6,1,8,-2\n"
    (made,) = advise({"id": 1, "op": "mcap", "csv": text})
    reader = make_reader(io.BytesIO(base64.b64decode(made["base64"])))
    found = [(c.topic, m.log_time, json.loads(m.data)) for _, c, m in reader.iter_messages()]
    assert ("/axis/1", 2_000_000, {"encnow": 8, "error": -2}) in found
    assert len(found) == 6
    (back,) = advise({"id": 2, "op": "csv", "base64": made["base64"]})
    assert back["csv"] == text


@pytest.mark.req("TOOL-1")
def test_what_is_no_mcap_of_ours_is_told():
    from mcap.writer import Writer

    strange = io.BytesIO()
    writer = Writer(strange)
    writer.start()
    schema = writer.register_schema(name="x", encoding="jsonschema", data=b"{}")
    channel = writer.register_channel(topic="/else", message_encoding="json", schema_id=schema)
    writer.add_message(channel, log_time=1, publish_time=1, data=b'{"a": 1}')
    writer.finish()
    for data in (b"", b"t_s,lines\n", strange.getvalue(), strange.getvalue()[:60]):
        (made,) = advise({"id": 1, "op": "csv", "base64": base64.b64encode(data).decode()})
        assert "MCAP" in made["error"]


@pytest.mark.req("TOOL-1")
def test_no_address_leads_out_of_the_pages():
    site = pages.Site("secret", ("http://127.0.0.1:1",), "", frozenset({"stop.html"}))
    assert site.path("/secret/") == "index.html"
    assert site.path("/secret/a/b.js?x=1") == "a/b.js"
    for target in ("/", "/secre/index.html", "/secrets/index.html", "//secret/x", "/%73ecret"):
        assert site.path(target) in (None, "index.html" if target == "/%73ecret" else None)
    for path in (
        "../pyproject.toml",
        "lib/../main.js",
        "lib/uplot/../../x",
        "/etc/passwd",
        "",
        "lib/x/y",
    ):
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

    async def play():
        origin = "http://127.0.0.1:1"
        async with pages.listen(echo, pages.Site("secret", (origin,), ""), 0, 64) as server:
            port = server.sockets[0].getsockname()[1]
            async with connect(
                f"ws://127.0.0.1:{port}/secret/x", origin=origin, ping_interval=None
            ) as page:
                for n in range(3):
                    await page.send(str(n))
                    assert await page.recv() == str(n)

    monkeypatch.setattr(Connection, "keepalive", late)
    asyncio.run(play())


async def fake_stop_path(folder: Path, answers: dict[str, str], pause: float = 0.0):
    async def serve(reader, writer):
        while line := await reader.readline():
            await asyncio.sleep(pause)
            writer.write((answers[line.decode().strip()] + "\n").encode())

    return await asyncio.start_unix_server(serve, str(folder / "x.stop"))


@pytest.mark.req("TOOL-1")
def test_the_stop_path_is_asked_in_order_and_found_again(tmp_path):
    async def play():
        path = StopPath(tmp_path / "x.stop")
        with pytest.raises(OSError):
            await path.ask("stop")
        async with await fake_stop_path(tmp_path, {"stop": "stopped 1.5", "state": "state 2 a 1"}):
            assert await asyncio.gather(path.ask("stop"), path.ask("state")) == [
                "stopped 1.5",
                "state 2 a 1",
            ]
            path.hang_up()
            assert await path.ask("stop") == "stopped 1.5"
            path.hang_up()

    asyncio.run(play())


@pytest.mark.req("TOOL-1")
def test_a_machine_that_does_not_answer_is_told(tmp_path):
    async def play():
        button = Button(tmp_path / "nowhere.stop")
        said = []
        button.clients = {object()}
        from mmcs.tool import stopper

        original, stopper.broadcast = (
            stopper.broadcast,
            lambda _, text: said.append(json.loads(text)),
        )
        try:
            await button.order("stop", 0.0)
        finally:
            stopper.broadcast = original
        assert said == [{"order": "stop", "failed": "the machine does not answer"}]

    asyncio.run(play())


@pytest.mark.req("TOOL-1")
def test_a_machine_waits_for_nobody_to_hear_the_driver(tmp_path, monkeypatch):
    """It said so much that a pipe that nobody reads is full: not even STOP would come through."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
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
@pytest.mark.parametrize("arguments,word", [
    (["no_such_scenario"], "no_such_scenario"),
    (["--attach", "nobody"], "--attach"),
    (["-t", "-5"], "-t"),
    (["--theme", "2089"], "2089"),
])  # fmt: skip
def test_bad_arguments_are_one_line(arguments, word):
    command = [sys.executable, "-m", "mmcs", "tool", "--no-browser", *arguments]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    assert ended.stderr.startswith("mmcs: ") and ended.stderr.count("\n") == 1
    assert word in ended.stderr


@pytest.mark.req("TOOL-1")
@pytest.mark.parametrize("name", ["logic", "waves"])
def test_the_pages_logic(name):
    node = Path(sys.executable).with_name("node")
    script = ROOT / "web" / "tests" / f"{name}.test.mjs"
    ended = subprocess.run([node, "--test", script], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout
