# SPDX-License-Identifier: Apache-2.0
"""Clients of a served machine in a random dialogue: each answer and each message as ever."""

import math
import random
import zlib

import pytest
from machines import event, machine

from mmcs import mcdef
from mmcs.engine.script import Serving, _lines
from mmcs.inputs import INPUTS

STEPS, PARTS, BIG = 12000, 16, 1 << 31
# Of the answers of each part of the steps. Who means to change them puts in what the test shows.
AS_EVER = "5e17 f825 bc8f 8887 3bcd a02c eed8 4546 3f9d f1f6 37a7 3697 1abf 77b5 59cc d352"
CALLS = [*mcdef.requests(), *["MENABLE"] * 8, *["MCLEARERROR"] * 3, "MFLY"]
LAST = [1, 1, 2, 3, 9, None]
PARAMS = [
    {"a0": 9000}, {"mode": 17, "b0": 64, "a0": 7309, "a1": -7027}, {"ilim": BIG}, {"b0": 0}, {},
    {"plo": -50, "phi": 50, "mode": 17 + mcdef.POSCHK}, {"a9": 1}, {"which": 1},
]  # fmt: skip
WELL = ["estop", "axis_enable", "cable", "card_absent", "pot_noise", "motor_jam", "host_stall",
        "bus_error", "writes_lost", "write_flip", "vme_a_stuck0"]  # fmt: skip
# What is asked, with which arguments: valid ones, bounds, and those beside them.
BARE = "hello alive clients inputs machine close stop snapshot snapshots unfollow sing"
ASKED = {
    **dict.fromkeys(BARE.split(" "), {}), "name": {"name": ["mctool", 'a "b"\\', "", "\x7fé", 5]},
    "open": {"mode": ["rw", "rw", "rw", "r", "w"]}, "read": {"axes": [0, 1, 2, 3, True]},
    "write": {"setpoints": [[50, -60], [70], [90, 0], [], [1, 2, 3], [1.5], [BIG - 1, -BIG], [BIG],
                            7]},
    "setpoint": {"axis": [0, 1, 0, 1, 2, -1], "value": [40, -400, 7, BIG - 1, -BIG, BIG, -BIG - 1]},
    "call": {"request": CALLS, "value": [0, 1, 2, 500, 1000, None, -BIG, 2 * BIG - 1, 2 * BIG],
             "axis": [0, 1, 0, 1, 2, 255, 256, None], "param": PARAMS},
    "change": {"axis": [0, 1, 0, 1, 2, 256], "param": PARAMS},
    "load": {"offset": [1, 0x409, 0x441, 8, 0, 2047, 2048]},
    "store": {"offset": [1, 0x409, 0x41, 2047, 2048], "value": [0, 0x18, 255, 256]},
    "lease": {"give": [None, None, None, 99, 3], "drop": [False, False, True],
              "take": [True, False], "deadman_ms": [50, 62.5, 62.5, 90, None, 49, 600001]},
    "input": {"name": ["gravity", *WELL, *WELL],
              "index": [0, 0, 1, 2, -1], "value": [0, 0, 1, 1, 2, 0.5, -1, 1e9]},
    "pace": {"speed": [1e-6, 0.5, 1e6, 1.1e6, 0, None], "paused": [True, False, False, 1]},
    "advance": {"seconds": [0, 0.01, 0.02, 10.5]}, "drop": {"snapshot": LAST},
    "ring": {"every_s": [0.001, 0.01, 0.01, 3600, 0.0009, 3601], "count": [1, 5, 5, 1000, 0, 1001]},
    "export": {"snapshot": LAST}, "rewind": {"snapshot": LAST, "t": [0.1, 0.1, 0.1, 1e9, 1e10]},
    "follow": {"samples": [True, False], "events": [True, False], "every": [1, 3, 1000000, 0],
               "period_ms": [0, 31.25, 10001], "past": [0, 10, 10, 8192, 8193]},
}  # fmt: skip
OFTEN = "advance call call call call change write setpoint setpoint read lease lease follow input"
ODD = [None, True, "", "1", 1.5, [], {}, {"a": {"b": 1}}, [[1]]]


class Carrier(Serving):
    """Has the clients, sockets apart, and a clock of its own."""

    def __init__(self, sim, chance):
        super().__init__(sim)
        self.chance, self.time, self.mine = chance, 0.0, {}

    def ask(self, who):
        chance, lib, ffi = self.chance, self._lib, self._ffi
        op = chance.choice([*ASKED, *OFTEN.split(" ") * 2])
        if op == "close" or not who.device:
            op = chance.choice([op, "open"])
        asked = {"op": op}
        for name, values in ASKED[op].items():
            if chance.random() < 0.8:
                asked[name] = chance.choice(chance.choice([values] * 29 + [ODD]))
        if asked.get("give") == 3:
            asked["give"] = chance.choice([*self.mine.values()]).number
        if asked.get("t") == 0.1:
            asked["t"] = self.sim.time - 0.1
        if isinstance(asked.get("snapshot"), int):  # from the last one on backwards
            there = [one["id"] for one in self.sim.snapshots()] or [7]
            asked["snapshot"] = there[-asked["snapshot"] % len(there)]
        flat = "".join(f"{line}\n" for line in _lines(asked)).encode(errors="replace")
        flat = flat[: chance.choice([None] * 29 + [chance.randrange(len(flat))])]  # cut short
        held = chance.choice([ffi.NULL] * 9 + [ffi.new("char[]", b"not now")])
        only_check = chance.random() < 0.1
        by = chance.choice([who, ffi.NULL]) if op in ("ring", "pace", "drop") else who
        reply = lib.mmcs_server_request(self.now, by, self.time, flat, only_check, held)
        if self.now.target >= 0 and chance.random() < 0.3:
            self.sim.run(self.now.target / 8e6)
            self.now.target = -1
        return asked, only_check, ffi.string(reply).split(b"basic")[0]  # the C++ library's words

    def carry(self, number, who):
        """What comes by other ways than the messages."""
        chance, what = self.chance, self.chance.randrange(10)
        if what == 0 and chance.random() < 0.3:
            self.leave(self.mine.pop(number))
        elif what == 1:
            device = chance.choice([b"/dev/mc0", b"/dev/vme16", b"/dev/mc1"])
            return device, self.open(who, device, chance.choice([0, 1, 2, 2, 3, 0o4002]))
        elif what == 2 and who.device == 1:
            code = mcdef.requests()[chance.choice(CALLS[:-1])].code
            return code, self.server_ioctl(who, code, bytes([chance.randrange(3), 0, 0, 0]))
        elif what == 3 and who.device == 1:
            return self._lib.mmcs_server_write(self.now, who, self._ffi.new("int[]", [9, 8]), 8)
        elif what == 4 and who.device == 2:
            address = 0x6000 + chance.choice([0x409, 0x441, 1, 8, 0x7FF, 0x800, -1])
            size = chance.choice([1, 1, 2, 4])
            return address, self.bus(who, address, size, chance.choice([None, b"\x18\xf8\0\1"]))
        elif what == 5:
            return self._lib.mmcs_server_check(self.now, self.time)
        elif what == 6:
            return self.held(who), self.said_since(max(0, self.sim.tap_head()[1] - 9))
        elif what == 7:
            when = chance.choice([self.sim.time, math.nan, 1e300, self.sim.time + 0.001])
            given = chance.choice([3, 3, -1, 9999]), chance.choice([-2, -1, 0, 1, 2])
            event = self._ffi.new(
                "mmcs_event *", (when, *given, chance.choice([0, 1, 2, -math.inf, math.nan]))
            )
            return self._lib.mmcs_sim_add_event(self.sim.handle, event), self.sim.notes()[-1:]
        elif what == 8 and who.device == 1:
            kind = chance.choice(mcdef.SEGMENT_KINDS)
            self.sim.add_segment(axis=chance.randrange(2), kind=kind, t0=chance.choice([0, 0.003]),
                                 duration=chance.choice([0, 0.02]), to=chance.randrange(400),
                                 amplitude=90, f0=chance.randrange(-40, 41), f1=90,
                                 v_max=chance.choice([0, 9e3]), a_max=chance.choice([0, 1e6]),
                                 table=[3, 90, 40])  # fmt: skip
            return kind, self.sim.start_motion(who.driver)
        elif what == 9:
            return self.sim.signals(chance.choice([-2, 0, 0, 1, 2, 15, 18]))
        return None

    def step(self):
        chance = self.chance
        self.time += chance.choice([1, 8, 32]) / 1024  # so exact that ends are met
        if chance.random() < 0.03:  # all is well again
            for name in [*WELL, "host_dead"]:
                event(self.sim, 0, name, INPUTS[name].healthy)
        number = chance.randrange(4)
        if number not in self.mine:
            self.mine[number] = self.enter(chance.choice(["device", "message"]), 700 + number, "me")
        who = self.mine[number]
        who.heard = self.time if chance.random() < 0.7 else who.heard
        told = self.ask(who) if chance.random() < 0.7 else self.carry(number, who)
        streams = [zlib.crc32(self.stream(one, self.time)) for one in self.mine.values()]
        if not self.now.paused:
            self.sim.run(self.sim.time + chance.choice([1e-6, 3e-4, 2e-3]))
        state = [(c.device, c.driver, c.flags, c.writes, c.number) for c in self.mine.values()]
        state += [self.now.opens, self.now.stopped_by, self.now.target, self.now.speed]
        return number, told, streams, state, self.sim.clock, self.sim.hash()


@pytest.mark.req("API-1")
def test_a_dialogue_is_as_ever():
    with machine(amp_panic_cut=1) as sim:
        carrier = Carrier(sim, random.Random(1989))
        sim.tap(30, 20)  # so few that some are lost
        steps = [str(carrier.step()) for _ in range(STEPS - 400)]
        steps[-1] += str([carrier.request(None, {"op": "snapshot"}) for _ in range(101)])
        event(sim, 0.001, "host_dead", 1)
        steps += [str(carrier.step()) for _ in range(400)]
        for _ in range(10001):  # refused, and more than there is room for notes
            sim.lib.mmcs_sim_add_event(sim.handle, sim.ffi.new("mmcs_event *", (math.nan, 0, 0, 0)))
        steps[-1] += f"{len(sim.notes())} {sim.lib.mmcs_sim_notes_lost(sim.handle)}"
    each, parts = STEPS // PARTS, []
    for n in range(0, STEPS, each):
        parts.append(f"{zlib.crc32(str(steps[n : n + each]).encode()) & 0xFFFF:04x}")
    assert " ".join(parts) == AS_EVER, "the first part that differs begins a story of its own"
