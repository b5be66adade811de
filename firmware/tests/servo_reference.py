# SPDX-License-Identifier: Apache-2.0
"""The servo law once more, from chapter 2's block diagram, in unbounded integers.

Written to be checked against the diagram, not to be fast: every block of Fig. 2.1 is a function of
its own, histories are lists, and limits are put on by name where a register of the real thing ends.
"""

from dataclasses import dataclass, field

OFF, POS, VEL, TORQ, TEST1 = range(5)
COULCOMP, ADFB, ZEROFB, ADDMD, ADOFF, POSCHK, SOFTERR = (0x10 << i for i in range(7))
PLO, PHI, ILIM = 1, 2, 4
FSCALE = 1024
DAC_TOP = 2047


def clamp(value: int, bits: int) -> int:
    top = (1 << (bits - 1)) - 1
    return max(-top - 1, min(top, value))


def quotient(n: int, d: int) -> int:
    """As C divides: toward zero."""
    magnitude = abs(n) // abs(d)
    return magnitude if (n < 0) == (d < 0) else -magnitude


def sign(value: int) -> int:
    return (value > 0) - (value < 0)


@dataclass
class Params:
    a0: int = 1
    a1: int = 0
    a2: int = 0
    b0: int = 1
    b1: int = 0
    b2: int = 0
    ic_pos: int = 0
    ic_neg: int = 0
    mode: int = OFF
    ilim: int = 1024
    ilimax: int = 0
    plo: int = -(1 << 31)
    phi: int = (1 << 31) - 1
    adc_a: int = 1
    adc_b: int = 0
    ipole: int = 0


@dataclass
class Compensator:
    """D(z); `products` are b0*u of the last two samples, whole."""

    errors: list[int] = field(default_factory=lambda: [0, 0])
    products: list[int] = field(default_factory=lambda: [0, 0])

    def output(self, p: Params, error: int) -> int:
        total = 0
        for a, e in zip((p.a0, p.a1, p.a2), [error, *self.errors], strict=True):
            total = clamp(total + a * e, 64)
        for b, product in zip((p.b1, p.b2), self.products, strict=True):
            whole = clamp(quotient(product, p.b0), 64)
            rest = product - quotient(product, p.b0) * p.b0
            term = clamp(clamp(b * whole, 64) + quotient(b * rest, p.b0), 64)
            total = clamp(total - term, 64)
        self.errors = [error, self.errors[0]]
        self.products = [total, self.products[0]]
        return clamp(quotient(total, p.b0), 64)

    def rebase(self, old: int, new: int) -> None:
        """Another b0, the same outputs."""
        self.products = [clamp(clamp(quotient(n, old), 64) * new, 64) for n in self.products]


def ramp(limit: int):
    """0 up to the limit, down to minus the limit, and so on."""
    value, step = 0, 1
    while True:
        yield value
        if limit > 0:
            if value == limit:
                step = -1
            elif value == -limit:
                step = 1
            value += step


class Servo:
    def __init__(self, params: Params, counter: int):
        self.p = params
        self.position = clamp((counter ^ 0x8000) - 0x8000, 32)
        self.counter = counter
        self.filtered = 0
        self.beyond = 0
        self.rest()

    def rest(self) -> None:
        self.seen: list[int] = []
        self.d = Compensator()
        self.strain = 0
        self.wave = ramp(max(0, min(self.p.ilim, DAC_TOP)))

    def change(self, params: Params) -> None:
        old, self.p = self.p, params
        flipped = old.mode ^ params.mode
        if flipped & (0xF | ADFB | ZEROFB):
            self.rest()
        elif old.b0 != params.b0:
            self.d.rebase(old.b0, params.b0)
        if flipped & (ADFB | POSCHK):
            self.beyond = 0

    def step(self, counter: int, raw: int, setpoint: int) -> list[int]:
        p, mode = self.p, self.p.mode & 0xF
        moved = (counter - self.counter + 0x8000) % 0x10000 - 0x8000
        self.position = (self.position + moved + (1 << 31)) % (1 << 32) - (1 << 31)
        self.counter = counter
        phi = clamp(p.adc_a * raw + p.adc_b, 32)
        y = phi if p.mode & ADFB else self.position
        y1, y2 = (self.seen + [y, y])[:2] if len(self.seen) != 1 else (self.seen[0],) * 2
        vel = clamp(quotient(3 * y - 4 * y1 + y2, 2), 32)
        self.seen = [y, y1]
        events = self.crossings(y)
        error, current, clipped = 0, 0, 0
        if mode in (POS, VEL, TORQ, TEST1):
            demand = phi if p.mode & ADDMD else setpoint
            fed = 0 if p.mode & ZEROFB else (vel if mode == VEL else y)
            error = clamp(demand - fed, 32)
            wish = self.torque(mode, error, demand, vel, phi)
            if self.overload(wish):
                events |= ILIM
            top = max(0, min(p.ilim, DAC_TOP)) if p.ilimax == 0 else DAC_TOP
            current = max(-top, min(top, wish))
            clipped = int(current != wish)
        reported = self.report(current)
        return [self.position, phi, y, vel, error, current, reported, events, clipped]

    def crossings(self, y: int) -> int:
        if not self.p.mode & POSCHK:
            return 0
        now = PLO * (y < self.p.plo) | PHI * (y > self.p.phi)
        events, self.beyond = now & ~self.beyond, now
        return events

    def torque(self, mode: int, error: int, demand: int, vel: int, phi: int) -> int:
        p = self.p
        if mode == TORQ:
            u = demand
        elif mode == TEST1:
            u = next(self.wave)
        else:
            u = self.d.output(p, error)
        if p.mode & COULCOMP:
            way = sign(vel) or (-sign(u) if p.ic_pos < 0 else sign(u))
            u = clamp(u + {1: p.ic_pos, -1: -p.ic_neg, 0: 0}[way], 64)
        return clamp(u + phi, 64) if p.mode & ADOFF else u

    def overload(self, wish: int) -> bool:
        p = self.p
        if p.ilimax == 0 or not (wish > p.ilim or wish < -p.ilim):
            self.strain = 0
            return False
        self.strain += 1
        if self.strain <= p.ilimax:
            return False
        self.strain = 0
        return True

    def report(self, current: int) -> int:
        pole = self.p.ipole
        if pole == 0:
            self.filtered = current * FSCALE
            return current
        self.filtered = quotient(pole * self.filtered, FSCALE) + (FSCALE - pole) * current
        return self.filtered
