# SPDX-License-Identifier: Apache-2.0
"""Skipping against clocking every clock (studies/lockstep.py). MMCS_LONG=1 for 1e9 clocks."""

import os

import pytest

from mmcs import regs
from studies import lockstep

LONG = os.environ.get("MMCS_LONG") == "1"
pytestmark = pytest.mark.req("API-1")


class Pair:
    """The plain machine and the one that skips, under the same actions."""

    def __init__(self, plain, skipping):
        self.plain, self.skipping, self.both = plain, skipping, (plain, skipping)
        self.numbers = {name: number for number, name in enumerate(plain.input_names())}

    def act(self, *actions, case=None):
        """Both answer each action alike; what they answer to the last."""
        for action in actions:
            got = [lockstep.act(sim, action, self.numbers) for sim in self.both]
            assert got[0] == got[1], (case, action, lockstep.failure(self.plain))
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


BOTH_ROBOTS = pytest.mark.parametrize("pair", ["lab500", "puma560"], indirect=True)


@pytest.mark.parametrize(
    ("name", "seed", "upsets"),
    [
        ("puma560", 105, True), ("lab500", 1, False), ("lab500", 2, True),
        pytest.param("puma560", 14, True, marks=pytest.mark.slow),
        pytest.param("puma560", 62, False, marks=pytest.mark.slow),
        pytest.param("lab500", 700011, False, marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_a_stranger_finds_no_difference(name, seed, upsets):
    """Random accesses, switches, wires, upsets, ways back; seeds that found mistakes once are among
    them."""
    assert lockstep.lockstep_torture(seed, 1600, name, upsets) > 100_000


@pytest.mark.req("INT-1")
def test_a_fault_of_two_clocks_ends(pair):
    """The edge detector that was held at 1 sees again what SCLOCK is, in the machine and in boards
    that were at rest meanwhile."""
    pair.act(("run", 1000), ("event", 1e-6, "irq_lost", 0, 1),
             ("event", 1.25e-6, "irq_lost", 0, 0), ("run", 1000))  # fmt: skip
    assert not lockstep.failure(pair.plain)
    assert pair.hashes_are_equal() and pair.registers_are_equal()


@pytest.mark.req("PAN-2")
@pytest.mark.parametrize("name", ["pc_power", "cable"])
def test_a_command_cut_short(pair, name):
    """Power or cable away for a few clocks, ending at every clock of a read: the same answer."""
    answers = set()
    for back in range(3, 20):
        for lost in (1, 2, 3):
            answers.add(pair.act(
                ("write", regs.PCCSR, 0x2D, 1, 0xF8),
                ("event", (back - lost) / lockstep.CLK_HZ, name, 0, 0),
                ("event", back / lockstep.CLK_HZ, name, 0, 1),
                ("read", 15, 0x2D, 1),
                case=(back, lost),
            ))  # fmt: skip
            pair.act(("run", 2000))  # the reset of the cards is over
            assert pair.hashes_are_equal(), (back, lost)
    assert answers == {0, 0xFF}


@pytest.mark.req("CRD-1")
@BOTH_ROBOTS
def test_a_switch_moves_within_a_command(pair):
    """The card's address leaves and comes back, at every clock of a write and after it: what the
    card did not hear in between is over for it, too."""
    for away in range(1, 18):
        for back in (away + 1, 60):
            pair.act(
                ("write", regs.PCCSR, 0x2D, 1, 0xF8),
                ("event", away / lockstep.CLK_HZ, "dip_xor", 0, 8),
                ("event", back / lockstep.CLK_HZ, "dip_xor", 0, 0),
                ("write", regs.card_offset(0, regs.CARD_ENC1_MSB), 0x2D, 1, away),
                ("run", 100),
                case=(away, back),
            )
            assert pair.hashes_are_equal(), (away, back)
    assert not lockstep.failure(pair.plain)


@pytest.mark.req("CRD-1")
@BOTH_ROBOTS
def test_data_move_within_a_command(pair):
    """A bit of the bus master's data register flips at every clock of a write: the card sees it."""
    port, seen = regs.card_offset(0, regs.CARD_PPI_A), set()
    for after in range(1, 18):
        seen.add(pair.act(
            ("write", regs.PCCSR, 0x2D, 1, 0xF8),
            ("write", regs.card_offset(0, regs.CARD_PPI_CONTROL), 0x2D, 1, 0x80),
            ("event", after / lockstep.CLK_HZ, "seu.u_adaptor.u_core.u_master.d_q", 0, 16),
            ("write", port, 0x2D, 1, 1),
            ("run", 100),
            ("read", port, 0x2D, 1),
            case=after,
        ))  # fmt: skip
        assert pair.hashes_are_equal(), after
    assert seen == {1, 17}


def test_a_wire_comes_back_while_a_pulled_card_is_asked(pair):
    """An encoder's wire leaves between two accesses to a card that is pulled, and is back within
    the second: nobody waited for the first edge, and the second must not be taken for none."""
    port = regs.card_offset(0, regs.CARD_PPI_A)
    ready = [("write", regs.PCCSR, 0x2D, 1, 0xF8),
             ("write", regs.card_offset(0, regs.CARD_PPI_CONTROL), 0x2D, 1, regs.PPI_MODE_BOARD),
             ("write", regs.card_offset(0, regs.CARD_PPI_B), 0x2D, 1,
              regs.CARD_PPI_B_ENC_JOINT_BM),
             ("write", port, 0x2D, 1, 5),
             ("event", 0, "encoder_glitch", 0, 20_000),
             ("event", 0, "card_absent", 0, 1)]  # fmt: skip
    for action in ready + [("run", 20), ("write", port, 0x2D, 1, 5)] * 1000:
        pair.act(action)
        # else the first edge would be waited for
        assert action[0] != "write" or pair.hashes_are_equal()


def test_an_answer_comes_as_the_waiting_ends(pair):
    """SYSRESET* ends so late in a read that DTACK* comes in the clock in which the master gives up:
    the level that it then waits for may go within the clock that shows it."""
    seen = set()
    for after in range(110, 135):
        for action in (("event", 0, "sysreset", 0, 1), ("run", 10),
                       ("event", after / lockstep.CLK_HZ, "sysreset", 0, 0),
                       ("read", regs.PCCSR, 0x2D, 1), ("run", 300)):  # fmt: skip
            seen.add(pair.act(action, case=after))
            assert pair.plain.clock == pair.skipping.clock, after
        assert pair.hashes_are_equal()
    assert {"TimeoutError", 0} <= seen


def test_a_way_back_into_a_card_without_power(pair):
    """A bit of the D/A that is stuck stands against the reset of a card without power; so it does
    after a way back, which must not let the reset fall anew."""
    kept: list = []
    pair.act(("event", 1e-6, "dac_stuck1", 0, 615), ("event", 1e-6, "pc_power", 0, 0), ("run", 100))
    lockstep.cross(pair.both, kept, "snapshot")
    pair.act(("event", 1e-6, "pc_power", 0, 1), ("run", 5000))
    lockstep.cross(pair.both, kept, "back")
    assert pair.registers_are_equal()


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
    with pytest.raises(lockstep.Differs, match="seed 1"):
        lockstep.torture(pair.both, 1, 200)


if LONG:

    def test_a_thousand_million_clocks():
        assert lockstep.main(["--clocks", "1e9"]) == 0
