# SPDX-License-Identifier: Apache-2.0
"""Snapshots that somebody made up, of physics and of a real processor: refused, or a machine that
goes on."""

import ctypes
import random
import struct
from pathlib import Path

import pytest
from needed import needs

from mmcs import ROOT, hosts, load, machine, mcdef
from tools.compiled import compiled, written

HEADER, DIGEST = 104, 96  # bytes of a snapshot's header; where it says what follows it
ON_S = 0.0004  # that a machine goes on from what it took
CORE = {"cpu_type": 0, "d0": 4, "pc": 4 * 34, "ir": 4 * 47}  # of Musashi; flags come after the FPU


class Crafted:
    """A machine with its snapshot, whose content is to be changed."""

    def __init__(self, host):
        self.sim = machine(load("lab500", "duration=0.06", "expect=[]"), host=host)
        self.sim.run(0.0203)
        self.keep()
        source = written(
            "digest.cpp",
            '#include "hash.h"\nextern "C" uint64_t of(const uint8_t *data, size_t size) '
            "{ return mmcs::digest(data, size); }\n",
        )
        command = ["c++", "-std=c++17", "-shared", "-fPIC", f"-I{ROOT}/sim/engine"]
        library = compiled("digest.so", command, [source])
        self.of = ctypes.CDLL(str(library)).of
        self.of.restype = ctypes.c_uint64

    def keep(self):
        self.state = self.sim.snapshot_bytes(self.sim.snapshot())
        self.past, self.before = self.sim.history_bytes(), self.sim.hash()

    def sealed(self, content: bytes) -> bytes:
        """With the digest that belongs to it: a digest is no signature."""
        content = bytes(content)
        digest = self.of(content, ctypes.c_size_t(len(content)))
        return self.state[:DIGEST] + struct.pack("<Q", digest) + content

    def changed(self, place: int, data: bytes) -> bytes:
        content = bytearray(self.state[HEADER:])
        content[place : place + len(data)] = data
        return self.sealed(content)

    def taken(self, state: bytes) -> bool:
        try:
            self.sim.restore_bytes(state, self.past)
        except ValueError as error:
            assert self.sim.hash() == self.before
            assert "snapshot" in str(error)
            return False
        self.sim.run(self.sim.time + ON_S)
        self.sim.restore_bytes(self.state, self.past)
        return True

    def core(self) -> tuple[int, int]:
        """Where the 68020's state is, and its bytes: in front of its memory."""
        config = hosts.config("m68020")
        image = Path(config["firmware"]).read_bytes()
        memory = self.state.index(image[64:1024]) - 64 - HEADER
        size = ctypes.CDLL(config["processor"]).iss_state_size()
        assert struct.unpack_from("<Q", self.state, HEADER + memory - 16 - size) == (size,)
        return memory - 8 - size, size

    def words(self) -> dict[str, int]:
        """Places of words behind the 68020's memory."""
        core, size = self.core()
        after = core + size + 8 + 0x20000
        return {"units": after, "cycles": after + 8, "bell": after + 16, "up": after + 17}


@pytest.fixture
def crafted(request):
    one = Crafted(getattr(request, "param", "m68020"))
    yield one
    one.sim.destroy()


def u32(value):
    return struct.pack("<I", value)


@needs("m68020")
@pytest.mark.req("SW-1")
def test_what_no_68020_is_in_is_refused(crafted):
    core, size = crafted.core()
    assert crafted.taken(crafted.changed(core, crafted.state[HEADER + core :][:size]))
    for name, wrong in (("cpu_type", 1), ("ir", 0x10000), ("ir", 0x7FFFFFFF)):
        assert not crafted.taken(crafted.changed(core + CORE[name], u32(wrong))), name
    for name, right in (("d0", 0xFFFFFFFF), ("pc", 0), ("pc", 0xFFFFFFFE), ("pc", 0x12345)):
        assert crafted.taken(crafted.changed(core + CORE[name], u32(right))), name


@needs("m68020")
@pytest.mark.req("SW-1")
def test_processor_and_machine_are_near_each_other(crafted):
    """Neither has years to wait for."""
    words, content = crafted.words(), crafted.state[HEADER:]
    units, cycles = struct.unpack_from("<qq", content, words["units"])
    assert abs(units // 25 - crafted.sim.clock) < 8000
    for wrong in (-1, 1 << 62, units + 25 * 8_000_001, units - 25 * 8_000_001):
        assert not crafted.taken(crafted.changed(words["units"], struct.pack("<q", wrong)))
    assert crafted.taken(crafted.changed(words["units"], struct.pack("<q", units + 25)))
    assert not crafted.taken(crafted.changed(words["cycles"], struct.pack("<q", cycles + 1)))
    for name in ("bell", "up"):
        assert not crafted.taken(crafted.changed(words[name], b"\2"))


@needs("m68020")
@pytest.mark.req("SW-1")
def test_whatever_a_68020_is_said_to_be_in(crafted):
    """Any bits of its core, its memory and what is behind them: no end but a sentence."""
    dice = random.Random(17)
    core, size = crafted.core()
    end = len(crafted.state) - HEADER
    ends = {True: 0, False: 0}
    for n in range(300):
        content = bytearray(crafted.state[HEADER:])
        for _ in range(dice.randrange(1, 6)):
            low, high = dice.choice(((core, core + size), (core, core + size), (core, end),
                                     (core + size + 0x1E000, core + size + 0x20000 + 64),
                                     (0, core)))  # fmt: skip
            at = dice.randrange(low, min(high, end))
            content[at] = dice.randrange(256) if n % 2 else content[at] ^ 1 << dice.randrange(8)
        ends[crafted.taken(crafted.sealed(content))] += 1
    assert min(ends.values()) > 30, ends


NOT = float("nan")
PLANT = {  # members of AxisState, eight bytes each, and what none of them can be
    **{n: (NOT, float("inf"), -1e13) for n in range(6)},  # angles, speeds, current, A/D
    6: (2, -1), 7: (-1, 1 << 40), 8: (2,),  # brake, its steps, whether the encoder is faulty
    10: (1 << 61, -1 << 63), 11: (1 << 62,), 12: (-1, 1 << 20), 13: (-1 << 40, 1 << 40),
    14: (8, -1), 15: (2,), 16: (2,), 17: (NOT, 1e300), 19: (-1 << 40, 1 << 40), 22: (2,),
    25: (1e300,), 40: (NOT, -1e10),  # inputs
}  # fmt: skip


@pytest.mark.req("API-1")
@pytest.mark.parametrize("crafted", ["native"], indirect=True)
def test_physics_of_no_machine_are_refused(crafted):
    """They went on to what is no number, or no whole one."""
    sim = crafted.sim
    sim.add_event(sim.time, sim.input_names().index("drive_offset"), 0, 5.0)
    sim.run(sim.time + 0.01)
    crafted.keep()
    truth = sim.true(0)
    assert truth["velocity"] > 0
    joint = struct.pack("<dd", truth["angle"], truth["velocity"])
    content = crafted.state[HEADER:]
    place = content.rindex(joint) - 16  # after the motor's own, which may be the same
    assert crafted.taken(crafted.changed(place + 24, struct.pack("<d", truth["velocity"] * 2)))
    for member, values in PLANT.items():
        for value in values:
            form = "<d" if isinstance(value, float) else "<q"
            changed = crafted.changed(place + 8 * member, struct.pack(form, value))
            assert not crafted.taken(changed), (member, value)


@pytest.mark.req("API-1")
@pytest.mark.parametrize("crafted", ["native"], indirect=True)
def test_statistics_below_nothing_are_refused(crafted):
    """The driver counts on, and stops at the largest number: from below 0 it went beyond that."""
    sim = crafted.sim
    client = sim.open(2)
    assert sim.ioctl(client, mcdef.MENABLE) == 0
    sim.run(sim.time + 0.02)
    crafted.keep()
    stats = sim.ioctl_bytes(client, mcdef.MGETSTATS, b"")[1]
    assert struct.unpack_from("<i", stats)[0] > 5
    place = crafted.state[HEADER:].index(stats)
    for n in range(6):
        assert crafted.taken(crafted.changed(place + 4 * n, struct.pack("<i", 2**31 - 1)))
        assert not crafted.taken(crafted.changed(place + 4 * n, struct.pack("<i", -1))), n
