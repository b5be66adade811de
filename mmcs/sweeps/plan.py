# SPDX-License-Identifier: Apache-2.0
"""What a sweep runs: a grid or a random sample over values of a scenario. docs/use/sweep.md

Every row is made from the scenario, the sweep's seed and the row's number alone, so neither the
number of workers nor the order in which they finish shows in the results.
"""

import copy
import hashlib
import json
import math
import random
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from mmcs import __version__
from mmcs.errors import InputError, Mistake, show
from mmcs.scenario.files import Files, find, parse_toml, read_scenario
from mmcs.scenario.sets import parse_value, set_key, split_set

MAX_RUNS = 1_000_000
MAX_TRIED = 100  # values of a key before the first run
NUMBER = r"([^\s.,:/\"\[][^\s,:/\"\[]*?|\.\d[^\s,:/\"\[]*?)"
RANGE = re.compile(rf"\s*{NUMBER}\.\.{NUMBER}(:(log)?(\d*))?\s*")
GRID_EXAMPLE = "axis.0.b0=80,90,100"
RANDOM_EXAMPLE = "seed=1..1000"


@dataclass(frozen=True)
class Span:
    """LOW..HIGH as typed: whole numbers when both ends are."""

    low: float
    high: float
    log: bool

    @property
    def whole(self) -> bool:
        return isinstance(self.low, int) and isinstance(self.high, int)

    def at(self, share: float) -> float:
        """The value at a share of the way, 0 to 1; on whole spans each number has equal room."""
        if self.log:
            value = self.low * (self.high / self.low) ** share
            return min(max(round(value), self.low), self.high) if self.whole else value
        if self.whole:
            return min(self.low + int(share * (self.high - self.low + 1)), self.high)
        return self.low + share * (self.high - self.low)


@dataclass(frozen=True)
class Vary:
    """One key and what it takes: the values of a grid, or what a random one is drawn from."""

    key: str
    values: tuple = ()
    span: Span | None = None

    def draw(self, seed: int, sample: int) -> object:
        share = random.Random(f"{seed}/{sample}/{self.key}").random()
        return self.span.at(share) if self.span else self.values[int(share * len(self.values))]

    def extremes(self) -> tuple:
        return self.values or (self.span.low, self.span.high)


def parse_grid(item: str) -> Vary:
    """KEY=V1,V2,... or KEY=LOW..HIGH (whole numbers) or KEY=LOW..HIGH:N or :logN."""
    key, text = split_set(item, "--grid", GRID_EXAMPLE)
    span, count = _span("--grid", key, text)
    if span is None:
        return Vary(key, tuple(_values("--grid", key, text)))
    if count is None:
        if not span.whole or span.log:
            allowed = f"say how many values, like {text.strip().partition(':')[0]}:5"
            raise InputError.one("--grid", key, text.strip(), allowed)
        count = span.high - span.low + 1
    if not 1 <= count <= MAX_RUNS:
        raise InputError.one("--grid", key, text, f"must make 1 to {MAX_RUNS} values")
    return Vary(key, tuple(dict.fromkeys(_evenly(span, count))))


def parse_random(item: str) -> Vary:
    """KEY=LOW..HIGH, KEY=LOW..HIGH:log or KEY=V1,V2,... (one of them)."""
    key, text = split_set(item, "--random", RANDOM_EXAMPLE)
    span, count = _span("--random", key, text)
    if count is not None:
        allowed = "how many are drawn is for --samples to say"
        raise InputError.one("--random", key, text.strip(), allowed)
    return Vary(key, span=span) if span else Vary(key, tuple(_values("--random", key, text)))


def _span(option: str, key: str, text: str) -> tuple[Span | None, int | None]:
    match = RANGE.fullmatch(text)
    if not match:
        return None, None
    ends = []
    for word in match.group(1, 2):
        value = parse_value(word, key, option)
        good = isinstance(value, int | float) and not isinstance(value, bool)
        if not good or not abs(value) < 1e300:
            raise InputError.one(option, key, text.strip(), "needs a number on each side of ..")
        ends.append(value)
    low, high = ends
    if match[5] and len(match[5]) > 7:
        raise InputError.one(option, key, text.strip(), f"at most {MAX_RUNS} values")
    if low > high:
        raise InputError.one(option, key, text.strip(), "must be LOW..HIGH with low <= high")
    if match[4] and low <= 0:
        raise InputError.one(option, key, text.strip(), "on a log scale both ends must be above 0")
    if match[3] == ":":
        raise InputError.one(option, key, text.strip(), "after : comes a number, or log")
    return Span(low, high, bool(match[4])), int(match[5]) if match[5] else None


def _evenly(span: Span, count: int) -> Iterator[float]:
    if span.whole and not span.log and count == span.high - span.low + 1:
        yield from range(span.low, span.high + 1)  # quick: there may be a million
        return
    for n in range(count):
        share = n / max(1, count - 1)
        if span.log:
            yield span.at(share)
        else:
            value = span.low + share * (span.high - span.low)
            yield round(value) if span.whole else value


def _values(option: str, key: str, text: str) -> list:
    try:
        values = parse_toml(f"v = [{text}]")["v"]
    except ValueError:  # bare words, as --set takes them
        values = [parse_value(word.strip(), key, option) for word in text.split(",")]
    if not values or "" in values:
        raise InputError.one(option, key, None, "has an empty value; write V1,V2,V3")
    if len(values) > MAX_RUNS:
        raise InputError.one(option, key, None, f"has more than {MAX_RUNS} values")
    return values


@dataclass
class Plan:
    """All rows of a sweep. Row n is sample n // points of grid point n % points."""

    name: str  # of the scenario, as typed
    path: Path
    data: dict  # the scenario, --set applied
    typed: tuple[str, ...]  # of --set
    grid: list[Vary]
    drawn: list[Vary]
    samples: int
    seed: int
    _files: Files = field(default_factory=Files)

    @property
    def vary(self) -> list[Vary]:
        return self.grid + self.drawn

    @property
    def keys(self) -> list[str]:
        return [v.key for v in self.vary]

    @property
    def points(self) -> int:
        return math.prod(len(v.values) for v in self.grid)

    def __len__(self) -> int:
        return self.samples * self.points

    def values(self, n: int) -> dict[str, object]:
        """The values of row n, by key."""
        sample, point = divmod(n, self.points)
        out = {}
        for vary in reversed(self.grid):  # the last key moves fastest
            point, place = divmod(point, len(vary.values))
            out[vary.key] = vary.values[place]
        out = dict(reversed(out.items()))
        return out | {v.key: v.draw(self.seed, sample) for v in self.drawn}

    def setup(self, values: dict[str, object]):
        """The checked setup with these values. Raises InputError."""
        from mmcs.scenario.setup import make_setup

        data = copy.deepcopy(self.data)
        for key, value in values.items():
            set_key(data, key, copy.deepcopy(value), self._option(key))
        return make_setup(self.path, data, self._files)

    def _option(self, key: str) -> str:
        return "--grid" if key in [v.key for v in self.grid] else "--random"

    def _of(self, mistake: Mistake, key: str) -> Mistake:
        """By the name that the option gave the key."""
        end = mistake.key.rpartition(".")[2]
        if mistake.file != str(self.path) or end not in (key.rpartition(".")[2], "axis"):
            return mistake
        value = None if end == "axis" else mistake.value
        return replace(mistake, file=self._option(key), key=key, value=value)

    def tasks(self, rows: dict[int, dict], fail) -> Iterator[tuple[tuple[int], object]]:
        """((number,), setup) of what has no row yet; fail(number, why): the values are no good
        together."""
        for n in range(len(self)):
            if n in rows:
                continue
            try:
                setup = self.setup(self.values(n))
            except InputError as error:
                fail(n, str(error))
                continue
            yield (n,), setup

    def check(self) -> None:
        """Raises InputError for a value (or end of a range) that is good in no combination tried;
        of very many values, some are tried.

        A combination that turns out bad later is a failed row.
        """
        last = len(self) - 1
        tried = [self.values(n) for n in sorted({last * n // 6 for n in range(7)})]
        for vary in self.vary:
            values = vary.extremes()
            for value in values[:: -(-len(values) // MAX_TRIED)]:
                mistake = None
                for others in tried:
                    try:
                        self.setup(others | {vary.key: value})
                        break
                    except InputError as error:
                        mistake = mistake or error
                else:
                    raise InputError(*(self._of(one, vary.key) for one in mistake.mistakes))

    def first(self):
        """The setup of the first row that is good. Raises InputError."""
        mistake = None
        for n in range(min(len(self), 1000)):
            try:
                return self.setup(self.values(n))
            except InputError as error:
                mistake = mistake or error
        raise mistake

    def identity(self, build: str) -> str:
        """What a sweep must share with an earlier one to go on with it: all but `samples`."""
        parts = [
            __version__, build, str(self.path), self.data, self.first().files, self.seed,
            len(self.grid),
            [(v.key, v.values, v.span and (v.span.low, v.span.high, v.span.log))
             for v in self.vary],
        ]  # fmt: skip
        return hashlib.sha256(json.dumps(parts, default=str).encode()).hexdigest()[:16]

    def command(self, n: int) -> str:
        """What carries out row n alone."""
        import shlex

        sets = [f"{key}={_typed(value)}" for key, value in self.values(n).items()]
        words = [w for text in [*self.typed, *sets] for w in ("--set", text)]
        return shlex.join(["mmcs", "run", self.name, *words])


def _typed(value: object) -> str:
    return repr(value) if isinstance(value, float) else show(value)


def make_plan(
    name: str,
    grid: tuple[str, ...],
    drawn: tuple[str, ...],
    samples: int | None,
    seed: int,
    sets: tuple[str, ...] = (),
) -> Plan:
    """The checked plan; every mistake that can be known beforehand raises InputError."""
    if not grid and not drawn:
        allowed = f"nothing to vary: give --grid {GRID_EXAMPLE} or --random {RANDOM_EXAMPLE}"
        raise InputError.one("mmcs sweep", "", None, allowed)
    if samples is not None and not drawn:
        raise InputError.one("--samples", "", samples, "needs --random: what is drawn")
    if samples is not None and samples < 1:
        raise InputError.one("--samples", "", samples, "must be at least 1")
    path = find(name)
    data = {"skip": True} | read_scenario(path)[0]  # the same results, sooner
    for item in sets:
        key, text = split_set(item)
        set_key(data, key, parse_value(text, key))
    plan = Plan(
        name, path, data, sets,
        grid=[parse_grid(item) for item in grid],
        drawn=[parse_random(item) for item in drawn],
        samples=(samples or 100) if drawn else 1,
        seed=seed,
    )  # fmt: skip
    for key in plan.keys:
        if plan.keys.count(key) > 1:
            raise InputError.one("mmcs sweep", key, None, "is varied twice")
    if len(plan) > MAX_RUNS:
        raise InputError.one("mmcs sweep", "", None, f"makes {len(plan)} runs; at most {MAX_RUNS}")
    plan.check()
    return plan
