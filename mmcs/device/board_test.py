# SPDX-License-Identifier: Apache-2.0
"""A self-test of a card on a board, through its registers alone.

Drives stay isolated: no step sets port B1. A write to a D/A is a heartbeat, and heartbeats release
the brakes while the stop loop is closed: the steps that write D/As are run only if asked for.
Time is that of the board's own timers, in milliseconds of SCLOCK, so the computer's does not count.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from mmcs import regs
from mmcs.device.board_line import Line
from mmcs.errors import RunError

PATTERNS = (0xA8, 0x50, 0x00)  # of port A: bits that move no count, its mode 0
WALK = (0x00, *(1 << n for n in range(8)), 0xFF)
CODES = (0x800, 0x000, 0x555, 0xAAA, 0xFFF, 0x7FF, 0x800)
ABSENT = 0xFF
TICKS = 256  # of counter 2's low byte
LATE = 4  # further milliseconds that a heartbeat may last: polls lie that far apart
SYN_A, SYN_B = regs.CARD_PPI_A_SYN_A_BM, regs.CARD_PPI_A_SYN_B_BM
QUAD = 5  # counts every edge
SIGNALS = (SYN_A, SYN_A | SYN_B, SYN_B, 0)  # a period of A before B
BEATS = (regs.CARD_PPI_C_HEARTBEAT1_BM, regs.CARD_PPI_C_HEARTBEAT2_BM)
LOW = (regs.CARD_DAC1_LO, regs.CARD_DAC2_LO)
HIGH = (regs.CARD_DAC1_HI, regs.CARD_DAC2_HI)
COUNTERS = (regs.CARD_ENC1_MSB, regs.CARD_ENC2_MSB)
ADC_LOW = (regs.CARD_ADC1_LO, regs.CARD_ADC2_LO)


@dataclass
class SelfTest:
    line: Line
    heartbeat_ms: float = 50.0

    def run(self, brakes: bool) -> Iterator[str]:
        """A sentence for each step that is good; the first that is not ends it, by RunError."""
        yield self.adaptor()
        cards = self.scan()
        yield f"scan: {_cards(cards)}"
        for card in cards:
            yield self.ports(card)
            yield self.counters(card)
        if not brakes:
            yield (
                "loop back, heartbeats, PANIC: not tested, they release the brakes; secure the load"
                " and give --brakes"
            )
            return
        for card in cards:
            yield self.loop_back(card)
        yield self.heartbeats(cards)
        yield self.panic(cards)

    # -- the adaptor -----------------------------------------------------------------------------

    def adaptor(self) -> str:
        """PCCSR's base bits, the timers; SCLOCK becomes 1 kHz, which counter 2 counts."""
        for value in (0x00, 0x01, 0x02, 0x04, 0x08, 0x10, 0x1F, regs.PCCSR_BASE_CARDS):
            self.line.write(regs.PCCSR, value)
            self._same("PCCSR", value, self.line.read(regs.PCCSR) & regs.PCCSR_BASE_BM)
        counters = ((regs.PIT0, 80), (regs.PIT1, 100), (regs.PIT2, 0))
        for number, (offset, count) in enumerate(counters):
            word = number << regs.PIT_CONTROL_SC_BP | regs.PIT_CONTROL_RW_LSB_GC | 2 << 1
            self.line.sequence((regs.PIT_CONTROL, word), (offset, count))
            ask = 0xE0 | 2 << number  # the status
            _, status = self.line.sequence((regs.PIT_CONTROL, ask), (offset, None))
            self._same(f"timer {number}: status", word & 0x3F, status & 0x3F)
        first = self._now()
        for _ in range(1000):
            if self._now() != first:
                return "adaptor: PCCSR and timers read what was written, SCLOCK runs"
        raise RunError(
            "the timers stand still in 1000 reads: SCLOCK does not run; look for the board's clock"
            " (its lights, the PLL)"
        )

    def _now(self) -> int:
        """Milliseconds of SCLOCK, of the low byte of counter 2, which counts down."""
        latch = 2 << regs.PIT_CONTROL_SC_BP | regs.PIT_CONTROL_RW_LATCH_GC
        _, count = self.line.sequence((regs.PIT_CONTROL, latch), (regs.PIT2, None))
        return -count % TICKS

    def _wait(self, ms: int) -> None:
        begin = self._now()
        while (self._now() - begin) % TICKS <= ms:
            pass

    # -- cards -----------------------------------------------------------------------------------

    def _put(self, card: int, register: int, value: int) -> None:
        self.line.write(regs.card_offset(card, register), value)

    def _get(self, card: int, register: int) -> int:
        return self.line.read(regs.card_offset(card, register))

    def scan(self) -> list[int]:
        found = []
        for card in range(regs.CARDS_MAX):
            self._put(card, regs.CARD_PPI_CONTROL, regs.PPI_MODE_BOARD)
            seen = []
            for value in PATTERNS:
                self._put(card, regs.CARD_PPI_A, value)
                seen.append(self._get(card, regs.CARD_PPI_A))
            if tuple(seen) == PATTERNS:
                found.append(card)
            elif set(seen) != {ABSENT}:
                got = ", ".join(f"0x{value:02X}" for value in seen)
                raise RunError(
                    f"card {card}: port A read {got} in place of 0xA8, 0x50, 0x00; two cards may"
                    " have the same address: set each card's switches to a number of its own"
                )
        if not found:
            raise RunError(
                "no card answers at any of the 16 addresses: check the card's power and cable"
            )
        return found

    def ports(self, card: int) -> str:
        """Ports A and B bit by bit; port B1 stays 0: it connects the drives."""
        drives = regs.CARD_PPI_B_DAC_JOINT_BM
        for value in WALK:
            self._put(card, regs.CARD_PPI_A, value)
            self._same(f"card {card}: port A", value, self._get(card, regs.CARD_PPI_A))
        for value in dict.fromkeys(v & ~drives for v in WALK):
            self._put(card, regs.CARD_PPI_B, value)
            self._same(f"card {card}: port B", value, self._get(card, regs.CARD_PPI_B))
        self._put(card, regs.CARD_PPI_CONTROL, regs.PPI_MODE_BOARD)
        self._same(f"card {card}: port A after the mode word", 0, self._get(card, regs.CARD_PPI_A))
        return f"card {card}: ports A and B read what was written, bit by bit"

    def counters(self, card: int) -> str:
        """The counters hold what is written, and follow the synthetic signals both ways."""
        self._load(card, 0x1234)
        upwards = []
        for steps in (SIGNALS * 3, (*SIGNALS[2::-1], 0)):
            before = self._counts(card)
            self._put(card, regs.CARD_PPI_A, QUAD)
            for signal in steps:
                self._put(card, regs.CARD_PPI_A, QUAD | signal)
            after = self._counts(card)
            moved = [
                (a - b + 0x8000) % 0x10000 - 0x8000 for a, b in zip(after, before, strict=True)
            ]
            if moved not in ([len(steps)] * 2, [-len(steps)] * 2):
                raise RunError(
                    f"card {card}: counters moved by {moved[0]} and {moved[1]} in"
                    f" {len(steps)} edges of the synthetic encoder: load the bitstream again; if it"
                    " stays, the clock is bad"
                )
            upwards.append(moved[0] > 0)
        if upwards[0] == upwards[1]:
            raise RunError(
                f"card {card}: counters do not turn with the synthetic encoder: load the bitstream"
                " again"
            )
        self._put(card, regs.CARD_PPI_A, 0)
        return f"card {card}: counters hold what is written and count {len(SIGNALS) * 3} edges"

    def _load(self, card: int, count: int) -> None:
        for joint, register in enumerate(COUNTERS):
            self.line.sequence(
                (regs.card_offset(card, regs.CARD_PPI_C), None),
                (regs.card_offset(card, register), count >> 8),
                (regs.card_offset(card, register + 1), count & 0xFF),
            )
            self._same(f"card {card}: counter {joint + 1}", count, self._counts(card)[joint])

    def _counts(self, card: int) -> tuple[int, int]:
        """Live counts of both joints: a latched one is read away first."""
        counts = []
        for register in COUNTERS:
            for _ in range(2):
                _, high, low = self.line.sequence(
                    (regs.card_offset(card, regs.CARD_PPI_C), None),
                    (regs.card_offset(card, register), None),
                    (regs.card_offset(card, register + 1), None),
                )
            counts.append(high << 8 | low)
        return counts[0], counts[1]

    # -- what releases brakes --------------------------------------------------------------------

    def _convert(self, card: int, joint: int, code: int) -> None:
        self._put(card, LOW[joint], code & 0xFF)
        self._put(card, HIGH[joint], code >> 8)

    def loop_back(self, card: int) -> str:
        """Each D/A code, through the relay into the A/D."""
        self._wait(2)  # the relay: B1 was 0 before
        for code in CODES:
            wanted = (code, code ^ 0xFFF)  # no joint has the other's code
            for joint in range(2):
                self._convert(card, joint, wanted[joint])
            self._put(card, regs.CARD_LATCH, 0)
            for _ in range(100):
                if self._get(card, regs.CARD_PPI_C) & regs.CARD_PPI_C_ADC_READY_BM:
                    break
            else:
                raise RunError(
                    f"card {card}: the A/Ds are busy in 100 reads (port C4 is 0): check their"
                    " supply"
                )
            high = self._get(card, regs.CARD_ADC_HI)
            for joint in range(2):
                read = (high >> 4 * joint & 15) << 8 | self._get(card, ADC_LOW[joint])
                if read != wanted[joint]:
                    raise RunError(
                        f"card {card}, joint {joint + 1}: loop back of D/A 0x{wanted[joint]:03X}"
                        f" reads A/D 0x{read:03X}: check relay and converters"
                    )
        self._beat([card])
        return f"card {card}: loop back of {len(CODES)} codes, each joint its own"

    def _beat(self, cards: list[int]) -> None:
        for card in cards:
            for joint in range(2):
                self._convert(card, joint, 0x800)

    def heartbeats(self, cards: list[int]) -> str:
        """They live after a write and end after their time."""
        self._beat(cards)
        begin = self._now()
        alive = {(card, joint) for card in cards for joint in range(2)}
        lasted = {}
        for card, joint in sorted(alive):
            if not self._get(card, regs.CARD_PPI_C) & BEATS[joint]:
                raise RunError(
                    f"card {card}, joint {joint + 1}: no heartbeat after a D/A write (port C): load"
                    " the bitstream again"
                )
        gap, before = 0, begin
        limit = 2 * self.heartbeat_ms + LATE
        while alive:
            now = self._now()
            ms, gap, before = (now - begin) % TICKS, max(gap, (now - before) % TICKS), now
            for card, joint in sorted(alive):
                if not self._get(card, regs.CARD_PPI_C) & BEATS[joint]:
                    lasted[card, joint] = ms
            alive -= lasted.keys()
            if ms > limit and alive:
                card, joint = min(alive)
                raise RunError(
                    f"card {card}, joint {joint + 1}: the heartbeat lives {ms} ms after the last"
                    f" write, and must end at {self.heartbeat_ms:g} ms: keep the power of the"
                    " drives off"
                )
        first, last = min(lasted.values()), max(lasted.values())
        if not self.heartbeat_ms - LATE <= first or last > self.heartbeat_ms + LATE + gap:
            raise RunError(
                f"heartbeats lasted {first} to {last} ms in place of {self.heartbeat_ms:g}: the"
                " board's clock has another rate than its ClkHz"
            )
        return f"heartbeats: end {first} to {last} ms after the last write"

    def panic(self, cards: list[int]) -> str:
        """Goes with the last D/A write, comes when heartbeats end, and is latched."""
        base = regs.PCCSR_BASE_CARDS
        self._beat(cards)
        self._wait(1)
        self.line.write(regs.PCCSR, base)
        self.line.write(regs.PCCSR, regs.PCCSR_LATCH_EN_BM | base)
        if self.line.read(regs.PCCSR) & regs.PCCSR_PANIC_LATCHED_BM:
            raise RunError(
                "PANIC is latched while all heartbeats live: the stop loop opens, check its"
                " contacts"
            )
        self._wait(round(self.heartbeat_ms) + LATE)
        latched = self.line.read(regs.PCCSR) & regs.PCCSR_PANIC_LATCHED_BM
        self.line.write(regs.PCCSR, base)
        if not latched:
            raise RunError(
                "PANIC did not come when the heartbeats ended: close the stop loop, switch the axes"
                " on and test again; if it stays away, keep the power of the drives off"
            )
        if self.line.read(regs.PCCSR) & regs.PCCSR_PANIC_LATCHED_BM:
            raise RunError("PCCSR bit 7 = 0 does not clear PANIC's latch: load the bitstream again")
        return "PANIC: gone while heartbeats live, latched when they ended"

    @staticmethod
    def _same(what: str, wrote: int, read: int) -> None:
        if read != wrote:
            raise RunError(
                f"{what}: wrote 0x{wrote:02X}, read 0x{read:02X}: load the bitstream again; if it"
                " stays, the board is bad"
            )


def _cards(cards: list[int]) -> str:
    return f"card{'s' if len(cards) > 1 else ''} {', '.join(map(str, cards))} of 16 addresses"
