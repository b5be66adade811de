# SPDX-License-Identifier: Apache-2.0
"""The messages over both carriers: a socket's server and a page's give the same replies."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from mmcs import BUILD, load, machine
from mmcs.device.messages import REQUESTS
from mmcs.device.server import Server
from mmcs.tests.raw import Asker

SITE = BUILD / "web"

ASKED = [
    {"op": "sing"}, {"op": 5}, {}, {"op": "alive", "id": [1]}, {"op": "read"}, {"op": "close"},
    {"op": "setpoint", "axis": 0, "value": 1}, {"op": "lease", "take": True},
    {"op": "open"}, {"op": "open", "mode": "w"}, {"op": "open", "mode": "rw"},
    {"op": "open", "mode": "r"}, {"op": "name", "name": 5}, {"op": "name", "name": "me"},
    {"op": "call", "request": "MGETNUMCARDS"}, {"op": "call", "request": "MFLY"},
    {"op": "call", "request": "MC_INT"}, {"op": "call", "request": "MSETINTERVAL"},
    {"op": "call", "request": "MSETINTERVAL", "value": 5},
    {"op": "call", "request": "MSETINTERVAL", "value": 1000},
    {"op": "call", "request": "MGETINTERVAL"}, {"op": "call", "request": "MGETPARAM"},
    {"op": "call", "request": "MGETPARAM", "axis": 0},
    {"op": "call", "request": "MGETPARAM", "axis": 200},
    {"op": "call", "request": "MSETPARAM", "axis": 0, "param": {"a0": 5}},
    {"op": "call", "request": "MSETPARAM", "axis": 0, "param": {"b0": 5, "clkdivisor": 1}},
    {"op": "call", "request": "MSETENC", "value": 256}, {"op": "call", "request": "MZEROSTATS"},
    {"op": "change", "axis": 0, "param": {"a0": 5, "mode": 1, "b0": 1, "ilim": 100}},
    {"op": "change", "axis": 0, "param": {"a9": 5}}, {"op": "change", "axis": 0, "param": []},
    {"op": "change", "axis": 0, "param": {"b0": 0}}, {"op": "change", "axis": 0, "param": {}},
    {"op": "change", "axis": 256, "param": {"b0": 1}}, {"op": "write", "setpoints": [1]},
    {"op": "call", "request": "MENABLE"}, {"op": "write", "setpoints": [1]},
    {"op": "write", "setpoints": [1, 2, 3]}, {"op": "write", "setpoints": [1 << 31]},
    {"op": "write"}, {"op": "setpoint", "axis": 0, "value": 7},
    {"op": "setpoint", "axis": 2, "value": 7}, {"op": "setpoint", "axis": 0, "value": 2**31},
    {"op": "read"}, {"op": "read", "axes": 1}, {"op": "read", "axes": 0},
    {"op": "call", "request": "MGETSTATS"}, {"op": "load", "offset": 0x409},
    {"op": "load", "offset": 0x408}, {"op": "load", "offset": 0x800}, {"op": "load"},
    {"op": "store", "offset": 1, "value": 256}, {"op": "store", "offset": 0x409, "value": 3},
    {"op": "input", "name": "gravity", "value": 0}, {"op": "input", "name": "cable", "value": 7},
    {"op": "input", "name": "axis_enable", "index": 2, "value": 0},
    {"op": "input", "name": "axis_enable", "index": 1, "value": 0},
    {"op": "input", "name": "estop", "value": 1}, {"op": "write", "setpoints": [1]},
    {"op": "input", "name": "estop", "value": 0}, {"op": "call", "request": "MENABLE"},
    {"op": "pace", "speed": 0}, {"op": "pace", "speed": "1,5"}, {"op": "pace", "paused": 1},
    {"op": "pace", "speed": 0.5}, {"op": "pace", "speed": None, "paused": True},
    {"op": "advance", "seconds": 11}, {"op": "advance"}, {"op": "ring", "every_s": 0},
    {"op": "ring", "every_s": 1, "count": 0}, {"op": "ring", "every_s": 1e-3, "count": 5},
    {"op": "rewind"}, {"op": "rewind", "t": -1}, {"op": "rewind", "snapshot": 12345},
    {"op": "drop", "snapshot": -1}, {"op": "drop", "snapshot": 4321}, {"op": "drop"},
    {"op": "follow", "every": 0}, {"op": "follow", "period_ms": 20000},
    {"op": "follow", "past": 9000}, {"op": "follow", "samples": 1}, {"op": "unfollow"},
    {"op": "lease"}, {"op": "lease", "take": True, "deadman_ms": 5}, {"op": "lease", "give": 9},
    {"op": "lease", "take": True, "deadman_ms": 600000}, {"op": "lease", "give": -1},
    {"op": "lease", "drop": True}, {"op": "stop"}, {"op": "write", "setpoints": [1]},
    {"op": "snapshot"}, {"op": "input", "name": "axis_enable", "index": 1, "value": 1},
    {"op": "input", "name": "estop", "value": 1},
    {"op": "input", "name": "load_torque", "value": 1e-7}, {"op": "inputs"},
    {"op": "rewind", "snapshot": 0}, {"op": "inputs"}, {"op": "snapshots"},
    {"op": "close"}, {"op": "close"},
]  # fmt: skip


def by_socket(tmp_path) -> list[dict]:
    with machine(load("lab500")) as sim:
        server = Server(sim, tmp_path / "mc0.sock", None)
        server.pace.set(None, True)
        client, replies = Asker(server), []
        for asked in ASKED:
            client.post(asked)
            replies.append(client.reply())
        server.close()
    return replies


def by_page() -> list[dict]:
    node, script = Path(sys.executable).with_name("node"), Path(__file__).with_name("messages.mjs")
    done = subprocess.run([node, script, SITE, "lab500"], input=json.dumps(ASKED), text=True,
                          capture_output=True, check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.req("TOOL-1")
def test_both_carriers_give_the_same_replies(tmp_path):
    socket_, page = by_socket(tmp_path), by_page()
    assert len(page) == len(ASKED)
    for asked, one, other in zip(ASKED, socket_, page, strict=True):
        if other.get("lease"):
            other["lease"] = 1  # clients are counted otherwise: the scenario's program is the first
        assert {**other, "id": other.get("id")} == one, asked
    other_answers = {"hello", "clients", "machine", "export"}
    assert set(REQUESTS) - {a.get("op") for a in ASKED} == other_answers
