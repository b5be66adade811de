# SPDX-License-Identifier: Apache-2.0
"""Both carriers of sim/service: Python and a page give the same replies, designs, records, logs."""

import json
import math
import random
import subprocess
import sys
from pathlib import Path

import pytest

from mmcs import BUILD, load, machine, make_record, simulate, write_log
from mmcs.device.messages import REQUESTS
from mmcs.device.server import Server
from mmcs.tests.raw import Asker
from mmcs.tool.advisor import Advisor

SITE = BUILD / "web"
NEAR = 1e-8  # of two libraries' sines; near z = 1 they lose eight digits

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
        server.machine.now.paused = True
        client, replies = Asker(server), []
        for asked in ASKED:
            client.post(asked)
            replies.append(client.reply())
        server.close()
    return replies


def by_page(asked: list[dict], name: str = "lab500", *plays: str) -> dict:
    node, script = Path(sys.executable).with_name("node"), Path(__file__).with_name("messages.mjs")
    done = subprocess.run([node, script, SITE, name, *plays], input=json.dumps(asked), text=True,
                          capture_output=True, check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.req("TOOL-1")
def test_both_carriers_give_the_same_replies(tmp_path):
    socket_, page = by_socket(tmp_path), by_page(ASKED)["replies"]
    assert len(page) == len(ASKED)
    for asked, one, other in zip(ASKED, socket_, page, strict=True):
        if other.get("lease"):
            other["lease"] = 1  # clients are counted otherwise: the scenario's program is the first
        assert {**other, "id": other.get("id")} == one, asked
    other_answers = {"hello", "clients", "machine", "export"}
    assert set(REQUESTS) - {a.get("op") for a in ASKED} == other_answers


def designs() -> list[dict]:
    """P, PD, PID with and without a filter, at any interval."""
    rng = random.Random(1989)

    def some(low: float, high: float, zero: float = 0.3) -> float:
        return 0 if rng.random() < zero else math.exp(rng.uniform(math.log(low), math.log(high)))

    asked = [
        {"p": some(1e-3, 1e4), "i": some(1e-2, 1e5), "d": some(1e-4, 100),
         "tau": some(1e-4, 0.1, 0.5), "interval_s": rng.choice((5e-4, 1e-3, 2e-3, 0.01))}
        for _ in range(400)
    ]  # fmt: skip
    asked += [{**gains, "p": -gains["p"]} for gains in asked[:50]]
    asked += [{"p": size, "interval_s": 1e-3} for size in (1e9, 3e9, 1e12, 0.5, 1.5, 2.5, 1e-9)]
    asked += [{"interval_s": 1e-3}]
    return [{"op": "design"} | one for one in asked]


@pytest.mark.req("TOOL-1", "SYN-1")
def test_both_carriers_give_the_same_designs():
    """Integers, warnings and errors to the letter."""
    asked, advisor, met = designs(), Advisor(Path()), set()
    for question, page in zip(asked, by_page(asked)["replies"], strict=True):
        own = advisor.answer(question)
        assert page.get("text") == own.get("error"), question
        off = page.pop("gain_error", 0) - own.pop("gain_error", 0)
        assert abs(off) < NEAR and all(page[key] == own[key] for key in own if key != "error")
        met |= {word.split()[0] for word in own.get("warnings", [own.get("error")])}
    assert met == {"S*I*T", "a", "rounding", "one", "scale"}  # each was met


@pytest.mark.req("SIM-3", "API-1")
@pytest.mark.parametrize("name", ["lab500", "puma560_bounce", "fault_estop"])
def test_both_carriers_write_the_same_record_and_log(tmp_path, name):
    result, page = simulate(load(name)), by_page([], name, "plays")
    write_log(result, tmp_path)
    assert page["csv"] == (tmp_path / "log.csv").read_text()
    own = make_record(result, "native")
    own["cycles"] = page["record"]["cycles"]  # Python's program ends with MSTOP; a page plays on
    assert page["record"] == own
