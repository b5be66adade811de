# SPDX-License-Identifier: Apache-2.0
"""Skipping against clocking every clock (studies/lockstep.py)."""

import zlib

import pytest

from mmcs import load, machine, regs
from studies import lockstep

pytestmark = pytest.mark.req("API-1")


class Pair:
    """The plain machine and the one that skips, under the same actions."""

    def __init__(self, plain, skipping):
        self.plain, self.skipping, self.both, self.kept = plain, skipping, (plain, skipping), []
        self.numbers = {name: number for number, name in enumerate(plain.input_names())}

    def act(self, *actions, case=None):
        """Both answer each action alike; what they answer to the last."""
        for action in actions:
            if action[0] in ("snapshot", "back"):
                got = [lockstep.cross(self.both, self.kept, action[0])] * 2
            else:
                got = [lockstep.act(sim, action, self.numbers) for sim in self.both]
            assert got[0] == got[1], (case, action, lockstep.failure(self.plain))
            assert self.plain.clock == self.skipping.clock, (case, action)
        return got[0]

    def hashes_are_equal(self):
        return self.plain.hash() == self.skipping.hash()

    def registers_are_equal(self):
        return lockstep.differences(self.both) == "no register"


@pytest.fixture
def pair(request):
    """Of lab500, or of the scenario that the test names."""
    _, plain, skipping = lockstep.machines(getattr(request, "param", "lab500"))
    with plain, skipping:
        yield Pair(plain, skipping)


@pytest.mark.parametrize(
    ("name", "seed", "upsets"),
    [
        ("lab500", 1, False), ("lab500", 2, True),
        pytest.param("puma560", 105, True, marks=pytest.mark.slow),
        pytest.param("puma560", 14, True, marks=pytest.mark.slow),
        pytest.param("puma560", 62, False, marks=pytest.mark.slow),
        pytest.param("lab500", 700011, False, marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_a_stranger_finds_no_difference(name, seed, upsets):
    """Random accesses, switches, wires, upsets, ways back; seeds that found mistakes once are among
    them."""
    assert lockstep.lockstep_torture(seed, 1600, name, upsets) > 100_000


AS_EVER = {"lab500": "c227ab5f", "puma560": "2bd2fd7d"}


@pytest.mark.req("CRD-1", "ADP-1")
@pytest.mark.parametrize("name", AS_EVER)
def test_a_stranger_meets_what_was_ever_there(name):
    """To the bit. Who means to change it puts the new digests here."""
    with machine(load(name)) as sim:
        numbers = {known: number for number, known in enumerate(sim.input_names())}
        size, told, kept = (sim.build()["cards"], sim.axes), [], sim.snapshot()
        strange = lockstep.stranger(7, *size, 4000, sim.registers())
        for action in lockstep.lively(7, *size, strange):
            if action[0] == "snapshot":
                kept = sim.snapshot()
            elif action[0] == "back":
                sim.restore(kept)
            else:
                told.append((lockstep.act(sim, action, numbers), sim.clock))
        told += [sim.notes(), sim.hash(), [sim.true(axis) for axis in range(sim.axes)]]
    assert f"{zlib.crc32(repr(told).encode()):08x}" == AS_EVER[name]


PCCSR, ASK = ("write", regs.PCCSR, 0x2D, 1, 0xF8), ("read", regs.PCCSR, 0x2D, 1)
PORT_A = regs.card_offset(0, regs.CARD_PPI_A)


def put(register, value):
    """A write to a register of card 0."""
    return ("write", regs.card_offset(0, register), 0x2D, 1, value)


def at(clock, name, value):
    """An input of the machine, card 0 or axis 0, so many clocks from now."""
    return ("event", clock / lockstep.CLK_HZ, name, 0, value)


def cut_short(name):
    """Power or cable away for a few clocks, ending at every clock of a read; then the reset of the
    cards is over."""
    return [[PCCSR, at(back - lost, name, 0), at(back, name, 1), ("read", 15, 0x2D, 1),
             ("run", 2000)] for back in range(3, 20) for lost in (1, 2, 3)]  # fmt: skip


# The card's address leaves and comes back, at every clock of a write and after it: what the card
# did not receive in between is over for it, too.
SWITCH = [
    [PCCSR, at(away, "dip_xor", 8), at(back, "dip_xor", 0), put(regs.CARD_ENC1_MSB, away),
     ("run", 100)] for away in range(1, 18) for back in (away + 1, 60)
]  # fmt: skip
# A bit of the bus master's data register flips at every clock of a write: the card sees it.
DATA = [
    [PCCSR, put(regs.CARD_PPI_CONTROL, 0x80), at(after, "seu.u_adaptor.u_core.u_master.d_q", 16),
     put(regs.CARD_PPI_A, 1), ("run", 100), ("read", PORT_A, 0x2D, 1)] for after in range(1, 18)
]  # fmt: skip
# An encoder's wire leaves between two accesses to a card that is pulled, and is back within the
# second: the first edge was not waited for, and the second must not be taken for none.
COUNTS = [PCCSR, put(regs.CARD_PPI_CONTROL, regs.PPI_MODE_BOARD),
          put(regs.CARD_PPI_B, regs.CARD_PPI_B_ENC_JOINT_BM), put(regs.CARD_PPI_A, 5)]  # fmt: skip
WIRE = [
    [*COUNTS, at(0, "encoder_glitch", 20_000), at(0, "card_absent", 1)],
    *[[("run", 20), put(regs.CARD_PPI_A, 5)]] * 1000,
]  # fmt: skip
# SYSRESET* ends so late in a read that DTACK* comes in the clock in which the master gives up: the
# level that it then waits for may go within the clock that shows it.
WAIT = [
    [at(0, "sysreset", 1), ("run", 10), at(after, "sysreset", 0), ASK, ("run", 300)]
    for after in range(110, 135)
]
# The edge detector that was held at 1 sees again what SCLOCK is, in the machine and in boards that
# were at rest meanwhile.
HELD = [[("run", 1000), at(8, "irq_lost", 1), at(10, "irq_lost", 0), ("run", 1000)]]
# A bit of the D/A that is stuck stands against the reset of a card without power; so it does after
# a way back, which must not let the reset fall anew.
BACK = [[at(8, "dac_stuck1", 615), at(8, "pc_power", 0), ("run", 100), ("snapshot",),
         at(8, "pc_power", 1), ("run", 5000), ("back",)]]  # fmt: skip
# The clock stops at every clock of a read, and is asked to once more. What is done then: faults,
# a way there, accesses without an answer.
TIMERS = [("write", lockstep.PIT + at, 0x2D, 1, value) for at, value in (
    (6, 0x34), (0, 7), (0, 0), (6, 0x74), (2, 9), (2, 0), (6, 0xB4), (4, 0), (4, 0))]  # fmt: skip
STOPPED = [
    [*COUNTS, *TIMERS, at(0, "load_torque", 200), ("run", 1000), at(after, "clock_stop", 1), ASK,
     at(9, "clock_stop", 1), at(9, what, 1), ("run", 900), ("snapshot",), ASK, at(9, what, 0),
     ("run", 90), ("back",), ("run", 900), at(9, "clock_stop", 0), ("run", 900), ASK]
    for after in range(1, 18) for what in ("card_absent", "irq_lost", "adc_stuck", "dac_stuck1",
                                           "seu_pccsr", "sysreset", "pc_control_stuck0")
]  # fmt: skip
# A build with assertions of a machine of three cards.
SLOW = {"puma560": [pytest.mark.slow]}
FOUND = {
    "power": ("lab500", cut_short("pc_power"), {0, 0xFF}, "PAN-2"),
    "cable": ("lab500", cut_short("cable"), {0, 0xFF}, "PAN-2"),
    "switch": ("lab500", SWITCH, set(), "CRD-1"),
    "switch of six axes": ("puma560", SWITCH, set(), "CRD-1"),
    "data": ("lab500", DATA, {1, 17}, "CRD-1"),
    "data of six axes": ("puma560", DATA, {1, 17}, "CRD-1"),
    "wire": ("lab500", WIRE, set(), "ENC-1"),
    "wait": ("lab500", WAIT, {"TimeoutError", 0}, "VME-3"),
    "held": ("lab500", HELD, set(), "INT-1"),
    "way back": ("lab500", BACK, set(), "DAC-1"),
    "stopped": ("lab500", STOPPED, {"TimeoutError", 184, 185}, "CRD-1"),
}


@pytest.mark.parametrize("pair, sequences, answers", [
    pytest.param(*row, id=name, marks=[pytest.mark.req(req), *SLOW.get(row[0], ())])
    for name, (*row, req) in FOUND.items()
], indirect=["pair"])  # fmt: skip
def test_what_was_a_difference_once(pair, sequences, answers):
    """answers: all that reads give."""
    got = set()
    for number, actions in enumerate(sequences):
        given = [pair.act(action, case=number) for action in actions]
        got |= {is_ for is_, (what, *_) in zip(given, actions, strict=True) if what == "read"}
        assert pair.hashes_are_equal(), number
    assert got == answers and pair.registers_are_equal()


@pytest.mark.req("INT-1")
def test_what_sticks_stands_against_an_upset(pair):
    """SCLOCK is high and its edge detector stuck at 1: a flipped bit of the detector flips nothing,
    so no edge is latched, in the machine and in the boards. Without the fault one is."""
    control = lockstep.PIT + 6
    actions = [*(("write", control, 0x2D, 1, word) for word in (0x36, 0x76, 0xB6)),
               ("write", regs.PCCSR, 0x2D, 1, 0xF8)]  # fmt: skip
    flip = ("event", 1.25e-6, "seu.u_adaptor.u_core.u_pccsr.sclock_q", 0, 1)
    for stuck in (1, 0):
        answer = pair.act(*actions, ("event", 0, "irq_lost", 0, stuck), ("run", 5), flip,
                          ("run", 20), ("read", regs.PCCSR, 0x2D, 1))  # fmt: skip
        assert bool(answer & regs.PCCSR_SCLOCK_LATCHED_BM) == (not stuck)
        assert pair.registers_are_equal()


@pytest.mark.parametrize("name", ["pc_power", "cable", "sysreset"])
def test_what_sticks_stands_against_a_reset(pair, name):
    """A card's reset that comes and goes within clocks leaves bits of the D/A where they stick, at
    every clock."""
    rank = "g_card[0].u_card.g_axis[0].u_axis.u_dac.rank2_q"
    values = set()
    healthy = int(name != "sysreset")
    events = [("dac_stuck1", 10, 839), (name, 20, 1 - healthy), (name, 21, healthy)]
    for what, clock, value in events:
        pair.act(("event", clock / lockstep.CLK_HZ, what, 0, value))
    for _ in range(60):
        assert pair.act(("run", 1)) is None
        assert pair.registers_are_equal(), pair.plain.clock
        values.add(pair.plain.register(list(pair.plain.registers()).index(rank)))
    assert values == {2048, 2048 | 839}


def test_a_difference_is_found(pair):
    """One machine has a bit of a counter flipped, which no access reads: the hash tells."""
    pair.skipping.add_event(1e-5, pair.numbers["seu_encoder"], 0, 4)
    with pytest.raises(lockstep.Differs, match="u_encoder.count_q 0x0 0x4"):
        lockstep.torture(pair.both, 1, 200)


def test_a_difference_is_reported_with_the_fewest_actions(monkeypatch):
    """One machine takes a card's port A for port B, while PCCSR lets the cards answer."""
    plain = []

    def machine(setup, *kind, make=lockstep.machine):
        sim = make(setup, *kind)
        plain.extend([sim] * len(kind))
        return sim

    def wrong(sim, action, numbers, act=lockstep.act):
        if action[:2] == ("write", regs.CARD_PPI_A * 2 + 1) and sim in plain:
            action = ("write", regs.CARD_PPI_B * 2 + 1, *action[2:])
        return act(sim, action, numbers)

    monkeypatch.setattr(lockstep, "machine", machine)
    monkeypatch.setattr(lockstep, "act", wrong)
    with pytest.raises(lockstep.Differs, match="seed 3") as told:
        lockstep.lockstep_torture(3, 400, "lab500")
    actions = [line for line in str(told.value).splitlines() if line.startswith("  (")]
    assert 1 <= len(actions) <= 10, told.value
