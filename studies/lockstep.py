# SPDX-License-Identifier: Apache-2.0
"""Compares boards that rest with the plain machine: `python -m studies.lockstep [--clocks N]`.

Two machines do the same: rtl/mmcs.sv as a whole, every clock, asserted, and the boards of the speed
build. A random stranger sets registers, switches, wires, pushes motors so that edges of encoders
come every few clocks, cuts power, goes back to snapshots that the other machine took, and, every
second time, flips bits of any register, after which assertions that fail end nothing; then
scenarios run from end to end. After every action clock and data read must agree, and again and
again the hash, which covers every register.
"""

import argparse
import itertools
import random
import time

from mmcs import RunError, Session, load, machine, regs, scenario_names
from mmcs.inputs import INPUTS
from studies import run
from studies.shrink import shrunk

CLK_HZ = 8_000_000
PUSHES = 0.1  # of the actions follow one
READIES = 0.06  # of the actions find a card made ready
# Actions in a bout. After each of every fourth bout the hashes are compared, in the others at the
# end alone: to read registers ends what boards put off, which is to last long sometimes.
BOUT = 50
PIT = regs.PIT0

# Those of the machine, then those of the plant; of some, less than the highest value of the table.
SWITCHES = ("estop", "cable", "pc_power", "sysreset", "axis_enable", "card_absent", "sclock_open",
            "panic_open", "dip_xor", "dac_stuck1", "dac_stuck0", "adc_stuck", "irq_lost",
            "bus_error", "encoder_a_cut", "encoder_swap", "encoder_slip", "encoder_glitch",
            "index_glitch", "motor_jam", "pot_cut")  # fmt: skip
LESS = {"bus_error": 2, "encoder_slip": 40, "encoder_glitch": 20000, "index_glitch": 20000}
RARE = {"cable", "pc_power", "sysreset", "estop"}  # they put much else to rest: ended soon
# Mode words of the three counters: binary, and in BCD; then what counts are made of.
PIT_VALUES = (0x34, 0x74, 0xB4, 0x36, 0x76, 0x30, 0x31, 0x71, 0xB1, 0x35, 0x75, 0xB5, 0x37, 0x77,
              0x10, 0x14, 0, 1, 2, 3, 0x10, 0x40, 0x99)  # fmt: skip


class Differs(RunError):
    """The two machines part; done: the actions that led there."""

    done: list[tuple] = []


def stranger(seed: int, cards: int, axes: int, actions: int, registers: dict[str, int]):
    """Random actions on a machine: ("read", offset, am, size), ("write", ..., value),
    ("event", after_s, name, index, value), ("run", clocks), ("snapshot",), ("back",). registers:
    those whose bits may flip, by name, with their width."""
    rng = random.Random(seed)

    def card_offset() -> int:
        card = rng.randrange(cards + (rng.random() < 0.05))
        own = *range(regs.CARD_ADC_HI + 1), regs.CARD_LATCH, regs.CARD_LATCH_ALL
        return regs.card_offset(card & 15, rng.choice((*own, rng.randrange(32))))

    def offset() -> int:
        which = rng.random()
        if which < 0.72:
            return card_offset()
        if which < 0.84:
            return PIT + 2 * rng.randrange(4)
        if which < 0.94:
            return rng.choice((regs.PCCSR, regs.PCCSR, regs.VECTOR))
        return rng.randrange(0x800)

    def value(at: int) -> int:
        if at == regs.PCCSR:  # the base address of the cards stays, mostly
            return rng.choice((0xF8, 0xB8, 0xD8, 0x98, 0x18, rng.randrange(256)))
        if PIT <= at < PIT + 8 and rng.random() < 0.5:
            return rng.choice(PIT_VALUES)
        return rng.choice((rng.randrange(256), rng.randrange(256), 0, 0xFF, 0x80, 0x8B, 1 << 3))

    yield ("write", regs.PCCSR, 0x2D, 1, 0xF8)  # the cards answer
    for _ in range(actions):
        what = rng.random()
        if what < 0.42:
            at = offset()
            yield ("write", at, rng.choice((0x2D, 0x2D, 0x2D, 0x29, 0x39)), 1, value(at))
        elif what < 0.68:
            size = rng.choice((1, 1, 1, 1, 2, 4))
            at = offset() if size == 1 else rng.randrange(0x200) * 4
            yield ("read", at, 0x2D, size)
        elif what < 0.71 and registers:
            name, width = rng.choice(list(registers.items()))
            bits = rng.choice((1 << rng.randrange(width), rng.randrange(1, 1 << width)))
            yield ("event", rng.randrange(400) / CLK_HZ, f"seu.{name}", 0, bits)
        elif what < 0.80:
            name = rng.choice(SWITCHES)
            if name in RARE and rng.random() < 0.7:
                name = rng.choice(("axis_enable", "dip_xor", "encoder_glitch"))
            count = {"machine": 1, "card": cards, "axis": axes}[INPUTS[name].scope]
            index = rng.randrange(count)
            after = rng.choice((0, rng.randrange(40), rng.randrange(4000)))
            worst = rng.randint(0, LESS.get(name, INPUTS[name].high))
            yield ("event", after / CLK_HZ, name, index, worst)
            if name in RARE or rng.random() < 0.5:
                healthy = INPUTS[name].healthy
                after += rng.choice((1, 2, 3, rng.randrange(1, 3000)))
                yield ("event", after / CLK_HZ, name, index, healthy)
        elif what < 0.81:
            yield ("snapshot",)
        elif what < 0.813:
            yield ("back",)
        else:
            yield ("run", rng.choice((1, 2, 3, rng.randrange(1, 30), rng.randrange(1, 600),
                                      round(10 ** rng.uniform(1, 5.2)))))  # fmt: skip


def lively(seed: int, cards: int, axes: int, actions):
    """The actions, and between them what makes edges of encoders count: torques, so that motors
    run fast, slow down, run against their stops, are held, and rest; and cards made ready."""
    rng = random.Random(f"lively {seed}")
    joint = regs.CARD_PPI_B_ENC_JOINT_BM | regs.CARD_PPI_B_DAC_JOINT_BM
    for action in actions:
        what = rng.random()
        if what < PUSHES:
            axis, torque = rng.randrange(axes), rng.choice((-1, 1)) * 10 ** rng.uniform(0, 4)
            yield ("event", 0, "load_torque", axis, torque)
            if rng.random() < 0.2:
                held = rng.randrange(1, 40_000) / CLK_HZ
                yield ("event", held, "load_torque", axis, 0)
                yield ("event", held, "motor_jam", axis, 1)
                yield ("event", held + rng.randrange(1, 4000) / CLK_HZ, "motor_jam", axis, 0)
        elif what < PUSHES + READIES:
            number = rng.randrange(cards)
            yield ("event", 0, "card_absent", number, 0)
            yield ("event", 0, "dip_xor", number, 0)
            yield ("run", 100)
            index = rng.choice((0, regs.CARD_PPI_B_INDEX_EN_BM))
            ready = ((regs.CARD_PPI_CONTROL, regs.PPI_MODE_BOARD),
                     (regs.CARD_PPI_B, joint | index),
                     (regs.CARD_PPI_A, rng.choice((5, 5, rng.randrange(8)))))  # fmt: skip
            yield ("write", regs.PCCSR, 0x2D, 1, 0xF8)
            for register, value in ready:
                yield ("write", regs.card_offset(number, register), 0x2D, 1, value)
        yield action


def act(sim, action: tuple, numbers: dict[str, int]) -> object:
    """What the machine answers; numbers: of its inputs, by name."""
    what, *rest = action
    try:
        if what == "read":
            return sim.bus_read(*rest)
        if what == "write":
            offset, am, size, value = rest
            sim.bus_write(offset, value, am, size)
        elif what == "event":
            after, name, index, value = rest
            sim.add_event(sim.time + after, numbers[name], index, value)
        elif not sim.run((sim.clock + rest[0] - 0.5) / CLK_HZ):
            return failure(sim)
    except OSError as error:  # no answer, or BERR*
        return type(error).__name__
    return None


def failure(sim) -> str:
    """The assertion that has failed."""
    found = (n["text"] for n in reversed(sim.notes()) if n["kind"] == "assert")
    return next((text for text in found if not text.startswith("after an upset")), "")


def cross(pair: tuple, kept: list, what: str) -> None:
    """Snapshots of both are kept; or both go back, each to the one that the other took."""
    if what == "snapshot":
        kept[:] = [(sim.snapshot_bytes(sim.snapshot()), sim.history_bytes()) for sim in pair]
    elif kept:
        for sim, snapshot in zip(pair, reversed(kept), strict=True):
            sim.restore_bytes(*snapshot)


def differences(pair: tuple) -> str:
    """The registers that differ, the first few."""
    names = list(pair[0].registers())
    values = [[sim.register(n) for n in range(len(names))] for sim in pair]
    found = [f"{name} {a:#x} {b:#x}" for name, a, b in zip(names, *values, strict=True) if a != b]
    return ", ".join(found[:5]) or "no register"


def compare(pair: tuple, actions) -> int:
    """Both machines under the same actions; the clocks that each of them made."""
    plain, skipping = pair
    numbers = {name: number for number, name in enumerate(plain.input_names())}
    kept: list = []
    done: list[tuple] = []
    again = 0  # clocks that were made once more, after going back

    def differs(what: str) -> Differs:
        error = Differs(f"{what}; {differences(pair)}")
        error.done = done
        return error

    for number, action in enumerate(actions):
        done.append(action)
        if action[0] in ("snapshot", "back"):
            again += plain.clock
            cross(pair, kept, action[0])
            again -= plain.clock
            got = [sim.hash() for sim in pair]
        else:
            got = [act(sim, action, numbers) for sim in pair]
        same = got[0] == got[1] and plain.clock == skipping.clock
        if same and (number // BOUT % 4 == 0 or number % BOUT == BOUT - 1):
            same = plain.hash() == skipping.hash()
        if not same:
            raise differs(
                f"in or before action {number} {action}: clock {plain.clock} and "
                f"{skipping.clock}, answers {got[0]} and {got[1]} {failure(plain)}"
            )
    if plain.hash() != skipping.hash():
        raise differs("the hashes differ at the end")
    return plain.clock + again


def torture(pair: tuple, seed: int, actions: int, upsets: bool = True) -> int:
    """Both machines under the same stranger; the clocks that each of them made."""
    plain, _ = pair
    cards, registers = plain.build()["cards"], plain.registers() if upsets else {}
    strange = stranger(seed, cards, plain.axes, actions, registers)
    return compare(pair, lively(seed, cards, plain.axes, strange))


def machines(name: str):
    setup = load(name)
    return setup, machine(setup, "trust"), machine(setup)


def lockstep_torture(seed: int, actions: int, name: str = "puma560", upsets: bool = True) -> int:
    _, plain, skipping = machines(name)
    with plain, skipping:
        try:
            return torture((plain, skipping), seed, actions, upsets)
        except Differs as error:
            found = error
    fewest = shrunk(found.done, lambda some: differ(name, some) is not None)
    lines = "\n  ".join(map(str, fewest))
    raise Differs(f"seed {seed}, {found}\nso they do after\n  {lines}\n{differ(name, fewest)}")


def differ(name: str, actions: list[tuple]) -> Differs | None:
    """How two machines from power-on differ after these actions."""
    _, plain, skipping = machines(name)
    with plain, skipping:
        try:
            compare((plain, skipping), actions)
        except Differs as error:
            return error
    return None


def lockstep_scenario(name: str) -> int:
    """One scenario from end to end in both builds; the clocks compared."""
    setup, *pair = machines(name)
    results = []
    for sim in pair:
        with sim:
            results.append(Session(sim, setup).run())
    plain, skipping = results
    if (plain.hash, plain.cycles) != (skipping.hash, skipping.cycles):
        raise Differs(f"scenario {name}: {plain.hash} plain, {skipping.hash} skipping")
    return plain.cycles


def runs(seed: int):
    """Endless: (name, seed, upsets) of the stranger, then a scenario's (name, seed, None)."""
    for number, scenario in enumerate(itertools.cycle(scenario_names())):
        first = seed + 4 * number
        yield from (("puma560", first, False), ("puma560", first + 1, True),
                    ("lab500", first + 2, False), ("lab500", first + 3, True))  # fmt: skip
        yield scenario, first, None


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m studies.lockstep", description=__doc__)
    parser.add_argument("--clocks", type=float, default=1e9, help="compare at least so many")
    parser.add_argument("--seed", type=int, default=1989)
    parser.add_argument("--actions", type=int, default=20_000, help="of the stranger, each time")
    options = parser.parse_args()
    began, clocks = time.monotonic(), 0
    for name, seed, upsets in runs(options.seed):
        if clocks >= options.clocks:
            break
        clocks += (lockstep_scenario(name) if upsets is None
                   else lockstep_torture(seed, options.actions, name, upsets))  # fmt: skip
        print(f"{clocks:.3g} clocks equal, the last of {name}, seed {seed}; "
              f"{time.monotonic() - began:.0f} s", flush=True)  # fmt: skip


if __name__ == "__main__":
    run(main)
