# SPDX-License-Identifier: Apache-2.0
# Length: one test for each kind of message.
"""The messages beside a program: device, lease, inputs, pace, the past, the stream."""

import json
import os
import random
import struct
import threading

import pytest

from mmcs import mcdef
from mmcs.device.client import Device
from mmcs.device.link import Link, Samples
from mmcs.device.messages import REQUESTS
from mmcs.device.sockets import connect
from mmcs.tests.raw import Asker

REPLIES = 100_000


@pytest.fixture
def link(serving):
    with Link(path=serving.server.path, timeout=None) as made:
        yield made


def refused(link, op, **arguments):
    with pytest.raises(OSError) as no:
        link.request(op, **arguments)
    return no.value.errno, no.value.strerror


def hold(link, axis=0):
    link.request("change", axis=axis, param={"mode": mcdef.MD_POS, "a0": 5})
    link.request("call", request="MENABLE")


def heard(link, wanted=lambda told: True):
    """The next message that is wanted: what has not come before so many replies never comes."""
    for _ in range(REPLIES):
        while link._kept:
            if wanted(message := link.receive()):
                return message
        link.request("alive")
    raise AssertionError(f"{REPLIES} replies, and not the message that was waited for")


def event(link, kind, axis=None):
    return heard(link, lambda told: isinstance(told, dict) and told.get("kind") == kind
                 and axis in (None, told["axis"]))  # fmt: skip


def setpoints_after(link) -> list[int]:
    """Of a sample that comes after now, by axis."""
    since = link.request("hello")["time"] + 0.02
    link.request("follow", events=False, period_ms=0)
    message = heard(link, lambda told: isinstance(told, Samples) and told.row(0)["t"] > since)
    link.request("unfollow")
    return [row[7] for row in message.row(0)["axes"]]


# --- the device ---


@pytest.mark.req("DRV-4", "DRV-9")
def test_one_setpoint_leaves_the_others_and_what_an_axis_adopts(link):
    """Also that of an axis which has just entered position mode, and begins where it is."""
    link.request("open", mode="rw")
    for axis in (0, 1):
        hold(link, axis)
    link.request("write", setpoints=[300, 0])
    link.request("setpoint", axis=1, value=70)
    assert setpoints_after(link) == [300, 70]
    link.request("change", axis=0, param={"mode": mcdef.MD_TORQ})
    link.request("change", axis=0, param={"mode": mcdef.MD_POS})
    link.request("setpoint", axis=1, value=71)  # at once: axis 0 has adopted nothing yet
    first, second = setpoints_after(link)
    assert second == 71 and first not in (0, 300)  # where it was when it entered the mode
    link.request("stop")
    assert refused(link, "setpoint", axis=1, value=1)[0] == 5
    link.request("close")


WEB = b"GET / HTTP/1.0\r\n" + b"x" * 100


@pytest.mark.parametrize(("suffix", "bytes_"), [
    (".msg", b"\0\0\0\0"), (".msg", b"\xff\xff\xff\xff"), (".msg", b"\4\0\0\0[1]]"),
    (".msg", b"\3\0\0\0[1]"), (".msg", b"\2\0\0\0\xff\xff"),
    (".msg", struct.pack("<I", 60000) + b"[" * 60000), (".msg", WEB), (".sock", WEB),
])  # fmt: skip
def test_rubbish_is_hung_up(serving, suffix, bytes_):
    with connect(serving.server.path.with_suffix(suffix)) as rude:
        rude.sendall(bytes_)
        rude.settimeout(10)
        while rude.recv(4096):  # its hello, then the end
            pass


@pytest.mark.parametrize("name", [float("nan"), float("inf")])
def test_an_id_that_no_reply_can_name_is_refused(bench, name):
    client = Asker(bench.server)
    client.post({"op": "hello", "id": name})
    told = client.reply()
    assert told["id"] is None and told["text"] == "id: a number or a text"


def test_parameters_change_one_at_a_time_without_racing(serving):
    def turn(field):
        with Device() as dev:
            for n in range(1, 101):
                assert dev.change_param(0, **{field: n})[field] == n

    threads = [threading.Thread(target=turn, args=(f,)) for f in ("a0", "a1", "a2")]
    with Device() as dev:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        param = dev.get_param(0)
    assert [param[f] for f in ("a0", "a1", "a2")] == [100] * 3


# --- lease ---


def test_the_lease(serving, link):
    link.request("name", name="mctool")
    with Device() as dev, Link(path=serving.server.path, timeout=None) as other:
        dev.write([0])
        assert refused(link, "lease", take=True)[0] == 9  # nothing is open
        link.request("open", mode="r")
        assert refused(link, "lease", take=True)[0] == 9  # not for writing
        link.request("close")
        link.request("open", mode="rw")
        link.request("lease", take=True)
        with pytest.raises(OSError, match="mctool\\) has the lease") as no:
            dev.write([0])
        assert no.value.errno == 16
        for change in (dev.enable, dev.clear_error, lambda: dev.change_param(0, a0=3)):
            with pytest.raises(OSError) as no:
                change()
            assert no.value.errno == 16
        dev.read()
        dev.get_param(0)
        dev.stop()  # everybody's right
        assert refused(other, "pace", speed=1.0)[0] == 16
        assert refused(other, "store", offset=0x409, value=0)[0] == 16
        assert refused(other, "input", name="estop", value=0)[0] == 16
        other.request("input", name="estop", value=1)
        other.request("open", mode="r")
        assert refused(link, "lease", give=other.hello["you"])[0] == 22
        other.request("close")
        other.request("open", mode="rw")
        assert refused(other, "lease", take=True)[0] == 16
        link.request("lease", give=other.hello["you"])
        mine = next(c for c in link.request("clients")["clients"] if c["lease"])
        assert mine["client"] == other.hello["you"]
        other.request("lease", drop=True)
        dev.take_lease()
        assert refused(other, "write", setpoints=[1])[0] == 16
        dev.drop_lease()
        other.request("call", request="MCLEARERROR")


@pytest.mark.parametrize("deadman_ms", [60, 10_000])
def test_a_holder_who_is_silent_or_hangs_up_stops_the_machine(serving, deadman_ms):
    with Link(path=serving.server.path, timeout=None) as watch:
        watch.request("follow", samples=False)
        with Link(path=serving.server.path, timeout=None) as holder:
            holder.request("open", mode="rw")
            hold(holder)
            holder.request("lease", take=True, deadman_ms=deadman_ms)
            if deadman_ms < 100:
                assert event(watch, "stopped")["value"] == 1
                assert event(watch, "lease")["value"] == -1
        assert deadman_ms < 100 or event(watch, "stopped")["value"] == 1


# --- operating the machine ---


def test_a_monitor_cannot_keep_snapshots_without_end(link):
    kept = [link.request("snapshot")["snapshot"]["id"] for _ in range(100)]
    assert refused(link, "snapshot") == (16, "100 snapshots are kept already; drop one")
    link.request("drop", snapshot=kept[0])
    link.request("snapshot")


def test_pause_advance_rewind(serving, link):
    link.request("open", mode="rw")
    hold(link)
    link.request("write", setpoints=[300])
    assert link.request("pace", paused=True)["paused"]
    kept = link.request("snapshot")["snapshot"]
    there = link.request("read")["states"]
    link.request("change", axis=0, param={"a0": 9})
    link.request("input", name="motor_jam", index=1, value=1)
    later = link.request("advance", seconds=0.3)["t"]
    assert later == pytest.approx(kept["t"] + 0.3, abs=1e-3)
    moved = link.request("read")["states"]
    assert moved != there
    with Device() as late:  # was not there then
        assert link.request("rewind", snapshot=kept["id"])["t"] == kept["t"]
        assert link.request("read")["states"] == there
        assert link.request("call", request="MGETPARAM", axis=0)["param"]["a0"] == 5
        assert not any(i["values"] for i in link.request("inputs")["inputs"])
        assert late.get_param(0)["a0"] == 5  # it has the device here, too
    # the same future as before, but for what is done differently
    link.request("change", axis=0, param={"a0": 9})
    link.request("input", name="motor_jam", index=1, value=1)
    link.request("advance", seconds=later - link.request("hello")["time"])
    assert link.request("read")["states"] == moved
    found = link.request("snapshots")["snapshots"]
    assert any(s["id"] == kept["id"] and s["kept"] for s in found)
    link.request("rewind", t=later - 0.15)
    link.request("drop", snapshot=kept["id"])
    assert refused(link, "rewind", snapshot=kept["id"])[0] == 22


def test_a_program_that_came_and_went_is_not_left_open_by_a_rewind(serving, link):
    link.request("open", mode="r")
    with Device() as dev:
        assert dev.change_param(0, a0=7, mode=mcdef.MD_POS) == dev.get_param(0)
        dev.enable()
        link.request("pace", paused=True)
        kept = link.request("snapshot")["snapshot"]["id"]
    assert any(link.request("hello")["opens"] == 1 for _ in range(REPLIES))  # another socket's end
    assert not link.request("hello")["enabled"]
    link.request("rewind", snapshot=kept)
    assert not link.request("hello")["enabled"]  # its writer is gone: the machine stops
    for _ in range(20):  # no open is left over: sixteen is all there is
        with Device() as dev:
            dev.read()
            link.request("rewind", snapshot=kept)


# --- the stream ---


def test_a_slow_reader_is_told_what_he_lost(bench):
    """He does not read until both rings have come round; nobody else waits for him."""
    client = Asker(bench.server)
    client.post({"op": "open", "mode": "rw"})
    client.post({"op": "follow", "period_ms": 0})
    client.post({"op": "call", "request": "MSETINTERVAL", "value": 200})
    while bench.sim.tap_head()[0] < 12_000:
        bench.server.step()
    lost = lambda told: Samples(told).lost if told[:1] == b"S" else 0  # noqa: E731
    behind = lost(client.heard(lost))
    head = bench.sim.tap_head()[0]
    assert 0 < behind < head
    client.sock.close()


def odd(chance):
    """Any value that JSON can hold."""
    words = [None, True, False, "", "rw", "r", "MENABLE", "MSETINTERVAL", "estop"]
    kinds = [
        lambda: chance.choice(words),
        lambda: chance.choice([0, 1, -1, 5, 1000, 1 << 31, 1 << 70, -(1 << 70)]),
        lambda: chance.choice([0.5, -1e300, 1e300, float("nan"), float("inf"), 60.0]),
        lambda: [odd(chance) for _ in range(chance.randrange(3))],
        lambda: {name: odd(chance) for name in chance.sample(NAMES, chance.randrange(3))},
        lambda: "".join(map(chr, (chance.randrange(0x3000) for _ in range(5)))),
        lambda: chance.choice([deep(30), deep(900)]),
    ]
    return chance.choice(kinds)()


def deep(levels):
    return json.loads("[" * levels + "]" * levels)


# in parts, since a test may not last as long as a million requests do
PARTS, REQUESTS_EACH = (20, 50_000) if os.environ.get("MMCS_LONG") == "1" else (1, 2000)
WORDS = (
    "id op mode axes setpoints request value param axis a0 offset take give drop deadman_ms name "
    "index speed paused every_s seconds count snapshot t samples events every period_ms past"
)
NAMES = WORDS.split()


@pytest.mark.parametrize("part", range(PARTS))
def test_random_requests_are_answered(unsignalled, bench, part):
    """Each with one reply, whatever they ask; then the server is as well as before. MMCS_LONG=1: a
    million."""
    chance = random.Random(int(os.environ.get("MMCS_SEED", "3")) + part)
    ops = [*REQUESTS, "sing"]
    client = Asker(bench.server)
    for n in range(REQUESTS_EACH):
        asked = {name: odd(chance) for name in chance.sample(NAMES, chance.randrange(5))}
        asked |= {"id": n, "op": chance.choice(ops)}
        client.post(asked)
        assert client.reply()["id"] == n, asked
        bench.server.machine.now.speed, bench.server.machine.now.paused = 0, False
