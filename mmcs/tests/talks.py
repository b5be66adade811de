# SPDX-License-Identifier: Apache-2.0
"""Talks with a server that the test steps, whole and the same each time: the messages, mmcs.Device,
the stop path, the page's designer (test_output.py)."""

import asyncio
import functools
import json
import math
import os
import re
import signal
import sys
import time
import urllib.error
import urllib.parse
import urllib.request
from contextlib import contextmanager

import pytest
from websockets.asyncio.client import connect as websocket
from websockets.exceptions import ConnectionClosed

from mmcs import mcdef
from mmcs.device import client, link
from mmcs.device.link import Link, Samples
from mmcs.device.sockets import connect
from mmcs.tests.device_bench import Bench, output_in_lockstep, running
from mmcs.tests.test_tool import PD
from mmcs.tool import advisor, launch


class Stepping:
    """A socket to the server: who waits for what it gets steps the server."""

    def __init__(self, sock, server):
        self._sock, self._server = sock, server

    def __getattr__(self, name):
        return getattr(self._sock, name)

    def recv(self, size):
        while True:
            try:
                return self._sock.recv(size)
            except BlockingIOError:
                self._server.step()


@contextmanager
def stepped(folder):
    """A bench; what Link and Device ask of it repeats."""
    with Bench(folder) as bench, pytest.MonkeyPatch.context() as patch:
        bench.server.about = {"scenario": str(folder / "device.toml"), "machine": {"robot": "two"}}
        for module in (client, link):
            patch.setattr(
                module, "connect", lambda path, *_: Stepping(connect(path, 0.0), bench.server)
            )
        patch.setattr(time, "sleep", lambda _: None)
        patch.setenv("MMCS_SOCKET", str(bench.server.path))
        before = signal.signal(signal.SIGUSR1, signal.SIG_IGN)
        yield bench
        signal.signal(signal.SIGUSR1, before)


def told(one):
    """A message, of samples the rows."""
    if isinstance(one, Samples):
        return one.lost, one.first, [one.row(n) for n in range(one.rows)]
    return one


ASKED = """hello; read {}; lease {"take": true}; name {"name": "a\\u0007"}; open {"mode": "r"};
lease {"take": true}; close; open {"mode": "rw"}; open {"mode": "r"}; open {"mode": "w"};
follow {"period_ms": 0}; call {"request": "MSETVERBOSITY", "value": 3};
call {"request": "MSETINTERVAL", "value": 1000}; call {"request": "MGETINTERVAL"};
call {"request": "MGETPARAM", "axis": 1}; call {"request": "MSETINTERVAL"};
call {"request": "MFLY"}; call {"request": "MC_INT"}; call {"request": "MD_POS"};
change {"axis": 0, "param": {"mode": 1, "a0": 5}}; change {"axis": 0, "param": {"a9": 1}};
change {"axis": 0, "param": {"b0": 0}}; change {"axis": 7, "param": {"b0": 1}};
change {"axis": 0, "param": []}; call {"request": "MENABLE"}; setpoint {"axis": 0, "value": 30};
setpoint {"axis": 0}; setpoint {"axis": 0, "value": 2147483648}; setpoint {"axis": 2, "value": 0};
write {"setpoints": [40, 0]}; write {"setpoints": [1.5]}; write {"setpoints": [2147483648]};
write {"setpoints": [0, 0, 0]}; write {}; read {"axes": 1}; read {"axes": 0}; read {"axes": true};
call {"request": "MDIAGMODE", "value": 2}; call {"request": "MDIAGMODE", "value": 0};
call {"request": "MDACMODE", "value": 1}; call {"request": "MSETNUMJOINTS", "value": 1}; hello;
change {"axis": 1, "param": {"ilimax": 7}}; call {"request": "MSETNUMJOINTS", "value": 2}; unfollow;
call {"request": "MGETSTATS"}; load {"offset": 1033}; load {"offset": 2048}; load {"offset": 1032};
store {"offset": 1033, "value": 3}; lease {}; lease {"take": true, "deadman_ms": 600000};
lease {"give": 77}; clients; enable; pace {"speed": 2}; pace {"speed": 0}; pace {"speed": "1,5"};
advance {"seconds": 1}; pace {"paused": true}; ring {"every_s": 0.05, "count": 3};
ring {"every_s": 0.001, "count": 1001}; snapshot;
follow {"samples": false, "events": true, "period_ms": 0}; advance {"seconds": 0.25};
unfollow; snapshots; input {"name": "motor_jam", "index": 1, "value": 1};
input {"name": "gravity", "value": 0}; input {"name": "cable", "value": 7};
input {"name": "axis_enable", "index": 2, "value": 0}; inputs; export {"snapshot": 1};
export {"snapshot": 12345}; rewind {"t": 0.1}; rewind {"snapshot": 12345}; drop {"snapshot": 1};
drop {"snapshot": 1}; follow {"samples": true, "every": 0};
follow {"samples": true, "every": 20, "past": 100, "period_ms": 0}; advance {"seconds": 0.1};
input {"name": "estop", "value": 1}; advance {"seconds": 0.05}; inputs;
input {"name": "estop", "value": 0}; input {"name": "card_absent", "value": 1};
call {"request": "MENABLE"}; input {"name": "card_absent", "value": 0};
call {"request": "MCLEARERROR"}; call {"request": "MENABLE"}; stop; write {"setpoints": [1]};
lease {"drop": true}; machine; sing; do_open; alive; close; hello"""


def messages(folder):
    """Every request, right and wrong, its answer, and what is told meanwhile."""
    with stepped(folder) as bench:
        heard = []
        bench.server.machine.console = heard.append
        other, mine = Link(path=bench.server.path), Link(path=bench.server.path)
        other.request("open", mode="rw")
        dev = client.Device()
        for row in re.split(r";\s", ASKED):
            op, _, given = row.partition(" ")
            try:
                ask = dev.enable if op == "enable" else functools.partial(mine.request, op)
                answer = ask(**json.loads(given or "{}"))
            except OSError as error:
                answer = error.args
            heard.append((row, answer, [told(one) for one in mine.kept()]))
        return mine.hello, heard, [told(one) for one in other.kept()]


CALLS = """num_cards(); interval(); set_interval(1000); interval(); read(); read(1); read(0);
get_param(1); change_param(0, mode=1, a0=5, b0=2); set_param(1, {"mode": 2}); set_param(1, PARAM);
status(); set_encoder(1, -2); set_encoder(0, 65535); read(); set_dac(1, 0x900); set_leds(0, 1);
set_dac_mode(True); set_diag_mode(2); read(); set_diag_mode(0); set_dac_mode(False); calibrate(0);
set_verbosity(2); verbosity(); enable(); wait(); wait(); write([30, 40]); write_axis(1, 60); wait();
status(); read(); end_calibration(0); end_calibration(1); set_num_joints(1); write([1, 2]); read();
stats(); zero_stats(); stats(); take_lease(); drop_lease(); stop(); status(); write([1]); read();
write_axis(0, 1); clear_error(); set_encoder(9, 1); calibrate(9); set_num_joints(9); get_param(9);
set_dac(0, 5000); set_dac(256, 0); set_dac(-1, 0); set_encoder(256, 0); set_encoder(0, 65536);
set_encoder(0, 1.5); write([1.5]); write(["1"]); write([1 << 31]); write([0] * 40); read(33);
set_leds(300, 1); calibrate(-1); set_num_joints(None); read(-1); set_interval(-5); set_interval(1);
set_num_joints(3); set_interval(50); set_param(0, {**PARAM, "clkdivisor": 60}); set_leds(2, 1);
set_param(0, {**PARAM, "ipole": 1024}); set_param(1, {**PARAM, "ilim": -1}); set_diag_mode(8);
ioctl(0x4D99); write_axis(2, 5); ioctl(mc.MSETVERBOSITY, bytes(4)); ioctl(mc.MGETVERBOSITY);
end_calibration(3); set_dac(0, 5); write_axis(0, 1); write([1]);
get_param("0"); set_param(0, {"a7": 1}); set_param(0, {"a0": 1e9}); change_param(0, which=1);
change_param(0, b0=0); write([0] * 100_000); ioctl(7); ioctl(1 << 32); ioctl("MSTOP"); close();
stop()"""
PARAM = PD | {"clkdivisor": 1}
OPENS = [("mc0", os.O_RDWR), ("mc0", os.O_RDONLY), ("mc1", os.O_RDWR), ("vme16", os.O_RDWR),
         ("mc0", os.O_WRONLY), ("mc0", 3), ("mc0", None), ("mc0", 1 << 32)]  # fmt: skip


def calls(heard):
    """Every call of mmcs.Device, by one who may write, by a monitor, at what is no /dev/mc0."""
    for name, flags in OPENS:
        dev = answered(heard, client.Device, f"/dev/{name}", flags)
        for call in CALLS.replace("\n", " ").split("; ") if dev else ():
            answered(heard, eval, f"dev.{call}", {"dev": dev, "PARAM": PARAM, "mc": mcdef})
    return heard


def device(folder):
    with stepped(folder) as bench:
        bench.server.machine.console = (heard := []).append
        return calls(heard)


def device_in_lockstep(folder):
    """The same calls, which then go through the library; time passes in those that wait alone."""
    text = "from mmcs.tests import talks; print(*talks.calls([]), sep='\\n')"
    out, status, _ = output_in_lockstep(folder, sys.executable, "-c", text)
    return status, re.sub(r"(stopped_by)=[1-9]\d*", r"\1", out).splitlines()


def answered(heard, call, *given):
    """What a call gives, or why it was refused, is heard."""
    try:
        made = call(*given)
    except OSError as error:
        return heard.append((given[0], error.args))
    heard.append(made if not isinstance(made, client.Device) else given)
    return made


class Lender:
    """Reads what the designer says: lends it the machine, as the page does."""

    def __init__(self, page):
        self.page, self.said = page, []

    def write(self, text):
        self.said.append(message := json.loads(text))
        if "lend" in message and self.page:
            self.page.request("lease", give=message.pop("lend"))

    def flush(self):
        pass


CSV = "t_s,lines,encnow_0,error_0\n0.001,6,5,1\n"
MOTOR = {"g": 1450.0, "lag": 0.3, "tc_pos": 100.0, "tc_neg": 105.0, "fit": 0.99}
LAW = {"a0": 4526, "a1": -4416, "a2": 0, "b0": 64, "b1": 0, "b2": 0}
STEP = {"t": [0, 0.01, 0.02, 0.03], "y": [0, 90, 190, 200], "u": [300, 200, 100, 0], "size": 200}
MESSAGES = [
    {"op": "design", "p": 4, "i": 9, "d": 0.1, "interval_s": 0.001},
    {"op": "predict", "motor": {"g": -100, "lag": 0.3}, "param": LAW, "interval_s": 0.001},
    {"op": "predict", "motor": MOTOR, "param": PD, "interval_s": 0.002, "step": 200, "away": 140,
     "seconds": 0.1},
    *({"op": "predict", "motor": MOTOR, "param": LAW, "interval_s": 0.001} | bad for bad in (
        {"interval_s": 0}, {"interval_s": -1}, {"interval_s": 1e-9}, {"interval_s": 1e300},
        {"interval_s": math.nan}, {"motor": {"g": math.nan, "lag": 0}}, {"step": math.inf},
        {"param": LAW | {"b0": 1e300}}, {"param": LAW | {"b0": 0}})),
    {"op": "judge", **STEP}, {"op": "judge", **STEP, "motor": MOTOR, "param": PD, "wn": 60,
                              "zeta": 1, "interval_s": 0.01},
    {"op": "mcap", "csv": CSV}, {"op": "mcap", "csv": "", "first": True},
    {"op": "mcap", "csv": CSV, "first": True}, {"op": "mcap", "csv": "0.002,6,5,2\n", "last": True},
    {"op": "mcap", "csv": "0.003,6,5,2\n"},
    {"op": "tune", "axis": 0, "wn": 200, "half": 2000},
    {"op": "chirp", "axis": 0, "amplitude": 30, "low": 1, "high": 20, "seconds": 3},
    {"op": "chirp", "axis": 0, "amplitude": 30, "low": 20, "high": 1},
    {"op": "tune", "axis": 1, "wn": 60, "half": 99}, {"op": "tune", "axis": 1, "wn": 60},
    {"op": "waves", "t": 0.5, "ms": 1}, {"op": "waves", "t": 1e3},
    {"op": "waves", "t": 0, "ms": 21}, {"op": "alive"}, {"op": []}, {"op": "predict"},
    {"op": "tune", "axis": 1, "wn": 60, "half": 150},
    {"op": "tune", "axis": 0, "wn": 60, "half": 2000},
]  # fmt: skip


def designer(folder):
    """What the page asks of it, and what it says meanwhile; in the end the machine is stopped."""
    with stepped(folder) as bench:
        page = Link(path=bench.server.path)
        page.request("open", mode="rw")
        page.request("call", request="MSETINTERVAL", value=1000)
        page.request("call", request="MENABLE")
        lender, heard = Lender(page), []
        its = advisor.Advisor(bench.server.path, lender)
        for message in MESSAGES:
            if message["op"] in ("tune", "chirp"):
                page.request("lease", take=True, deadman_ms=600_000)
            more = {"deadman_ms": 1e9, "lender": page.hello["you"]}
            heard.append((message["op"], its.answer({**more, **message}), lender.said))
            lender.said = []
        return heard, page.request("hello")


def stop_path(folder):
    with stepped(folder) as bench:
        lines, answers = connect(bench.server.path.with_suffix(".stop"), 0.0), []
        for line in ("state", "stop", "press", "state", " release ", "go", "", "state", "x" * 65):
            lines.sendall(line.encode() + b"\n")
            answers.append(Stepping(lines, bench.server).recv(100).decode())
        return answers


HEADERS = ("Date", "Content-Length", "ETag")
PATHS = ("", "main.js", "look.css", "stop.html", "lib/x", "lib/uplot/../../main.js", "%00")


def fetched(address, path, data=None, known=""):
    """Status and headers, and the tag of what came."""
    asked = urllib.request.Request(address + path, data, {"If-None-Match": known})
    try:
        got = urllib.request.urlopen(asked)
    except urllib.error.HTTPError as error:
        got = error
    heads = {key: value for key, value in got.headers.items() if key not in HEADERS}
    return got.headers["ETag"], (
        path,
        got.status,
        heads,
        int(got.headers["Content-Length"] or 0) > 0,
    )


async def said(address, page, *texts):
    """What comes of each text on a socket of the page's, and how it is closed at last."""
    told, origin = [], page.rsplit("/", 2)[0]
    async with websocket(address.replace("http", "ws"), origin=origin) as socket:
        try:
            for text in texts:
                await socket.send(text)
                while "state" in (answer := json.loads(await socket.recv())):
                    pass
                told.append({key: one for key, one in answer.items() if key not in ("ms", "time")})
            await socket.close()
        except ConnectionClosed:
            told.append((socket.close_code, socket.close_reason))
    return told


def tool(folder):
    """The pages of `mmcs tool` and the stop button's, and their sockets."""
    with Bench(folder) as bench, pytest.MonkeyPatch.context() as patch:
        patch.setattr(launch, "check_libraries", lambda: None)
        with running(bench.server), launch.start("", bench.server.path, {"t": "2"}) as made:
            page, _, given = made.address.partition("?")
            stop = urllib.parse.parse_qs(given)["stop"][0].removesuffix("stop.html")
            heard = [fetched(where, path)[1] for where in (page, stop) for path in PATHS]
            heard += [os.getsid(one.pid) == one.pid for one in made.processes.values()]
            heard += [fetched(page, "", b"")[1], fetched(page, "", known=fetched(page, "")[0])[1]]
            for address, texts in (
                (f"{page}machine", ('{"id": 1, "op": "alive"}', "[", "{}")),
                (f"{page}advice", ('{"op": "design", "p": 4,\n"interval_s": 0.001}', "?", b"x")),
                (f"{page}labs", ('{"op": "sing"}',)), (f"{page}x", ("a",)),
                (f"{stop}x", ("press", "release", "stop", "state")),
            ):  # fmt: skip
                heard.append(asyncio.run(said(address, page, *texts)))
            bench.server.path.with_suffix(".msg").unlink()
            heard.append(asyncio.run(said(f"{page}machine", page, "a")))
            text = json.dumps(heard)
            for own in re.findall(r"://[^:]+:(\d+)/([^/]+)/", urllib.parse.unquote(made.address)):
                text = text.replace(own[0], "PORT").replace(own[1], "TOKEN")
            return json.loads(text)


TALKS = {"messages": messages, "device": device, "designer": designer, "stop path": stop_path,
         "device in lock-step": device_in_lockstep, "tool": tool}  # fmt: skip
