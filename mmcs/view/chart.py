# SPDX-License-Identifier: Apache-2.0
"""Line charts as SVG, in a hundredth of the time that a plotting library takes to be imported."""

import math
from dataclasses import dataclass, field
from html import escape

import numpy as np

GREY, PALE = "#8a8f98", "#e4e6ea"
FONT = 'font-family="sans-serif" font-size="9"'
TEXT = '<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{more}>{text}</text>'


def ticks(low: float, high: float, most: int) -> tuple[list[float], int]:
    """Round values within the range, 1, 2, 2.5 or 5 apart, and how many decimals they take."""
    wanted = max((high - low) / most, 1e-300)
    power = math.floor(math.log10(wanted))
    step = next(s * 10.0**power for s in (1, 2, 2.5, 5, 10) if s * 10.0**power >= wanted * 0.999)
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    decimals += round(step * 10**decimals, 6) % 1 != 0
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [n * step for n in range(first, last + 1)], decimals


def number(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}"
    return text.replace("-", "\N{MINUS SIGN}") if float(text) else text.lstrip("-")


@dataclass
class Cell:
    """A chart at a place of the picture, in points from its upper left corner."""

    left: float
    top: float
    width: float
    height: float
    title: str = ""
    labels: tuple[str, ...] = ()  # beside it, a line each
    below: str | None = None  # under the x axis with its numbers; None: without
    lines: list = field(default_factory=list)
    rules: list = field(default_factory=list)

    def line(self, x, y, colour: str, width: float, steps: bool = False, label: str = "") -> None:
        """steps: each value stands until the next."""
        self.lines.append((np.asarray(x), np.asarray(y, dtype=float), colour, width, steps, label))

    def rule(self, colour: str, width: float, y=None, x=None, dash: str = "") -> None:
        """A line across at this y, or down at this x."""
        self.rules.append((colour, width, y, x, dash))

    def draw(self, low: float, high: float) -> list[str]:
        """From x = low to high; y as far as lines and rules go."""
        values = [v for _, y, *_ in self.lines if len(y) for v in (y.min(), y.max())]
        values += [y for _, _, y, _, _ in self.rules if y is not None]
        bottom, top = min(values, default=0.0), max(values, default=0.0)
        room = 0.05 * (top - bottom) or 0.05 * abs(top) or 1.0
        bottom, top = bottom - room, top + room
        end, base = self.left + self.width, self.top + self.height

        def across(x):
            return self.left + (x - low) / (high - low) * self.width

        def up(y):
            return base - (y - bottom) / (top - bottom) * self.height

        out, rows = [], ticks(bottom, top, max(2, int(self.height / 20)))
        for value in rows[0]:
            out.append(f'<path d="M{self.left:.1f} {up(value):.2f}H{end:.1f}" stroke="{PALE}"/>')
            out.append(TEXT.format(x=self.left - 4, y=up(value) + 3, anchor="end", more="",
                                   text=number(value, rows[1])))  # fmt: skip
        columns = ticks(low, high, max(2, int(self.width / 40)))
        for value in columns[0]:
            out.append(
                f'<path d="M{across(value):.2f} {self.top:.1f}V{base:.1f}" stroke="{PALE}"/>'
            )
            if self.below is not None:
                out.append(TEXT.format(x=across(value), y=base + 12, anchor="middle", more="",
                                       text=number(value, columns[1])))  # fmt: skip
        for colour, width, y, x, dash in self.rules:
            way = f"M{self.left:.1f} {up(y):.2f}H{end:.1f}" if x is None else (
                f"M{across(x):.2f} {self.top:.1f}V{base:.1f}")  # fmt: skip
            dashes = f' stroke-dasharray="{dash}"' if dash else ""
            out.append(f'<path d="{way}" stroke="{colour}" stroke-width="{width}"{dashes}/>')
        for x, y, colour, width, steps, _ in self.lines:
            way = _way(across(x), up(y), steps)
            out.append(f'<path d="{way}" stroke="{colour}" stroke-width="{width}" '
                       'stroke-linejoin="round"/>')  # fmt: skip
        out.append(f'<path d="M{self.left:.1f} {self.top:.1f}V{base:.1f}H{end:.1f}" '
                   f'stroke="{GREY}"/>')  # fmt: skip
        last = [y[-1] for _, y, *_, label in self.lines if label and len(y)]
        out += self._words(end, base, sum(last) > len(last) * (bottom + top) / 2)
        return out

    def _words(self, end: float, base: float, legend_below: bool):
        if self.title:
            yield TEXT.format(x=self.left, y=self.top - 6, anchor="start", more=' font-size="10"',
                              text=escape(self.title))  # fmt: skip
        for n, label in enumerate(self.labels):
            x, y = self.left - 52 + 11 * n, self.top + self.height / 2
            turn = f' transform="rotate(-90 {x:.1f} {y:.1f})"'
            yield TEXT.format(x=x, y=y, anchor="middle", more=turn, text=escape(label))
        if self.below:
            middle = self.left + self.width / 2
            yield TEXT.format(x=middle, y=base + 24, anchor="middle", more="", text=self.below)
        named = [(colour, label) for *_, colour, _, _, label in self.lines if label]
        left = end - 18 - 6 * max((len(label) for _, label in named), default=0)
        for n, (colour, label) in enumerate(named):
            y = base - 8 - 12 * (len(named) - 1 - n) if legend_below else self.top + 10 + 12 * n
            yield f'<path d="M{left:.1f} {y - 3:.1f}h14" stroke="{colour}" stroke-width="1.4"/>'
            yield TEXT.format(x=left + 18, y=y, anchor="start", more="", text=escape(label))


def _way(x: np.ndarray, y: np.ndarray, steps: bool) -> str:
    """What an SVG path goes along, in tenths; points that change nothing are left out."""
    if not len(y):
        return "M0 0"
    x, y = (np.round(10 * v).astype(int) for v in (x, y))
    moves = np.flatnonzero(np.diff(y)) + 1
    before = moves if steps else moves - 1
    kept = sorted({0, *before.tolist(), *moves.tolist(), len(y) - 1})
    right, down = np.diff(x[kept]) / 10, np.diff(y[kept]) / 10
    form = "h{:g}v{:g}" if steps else "l{:g} {:g}"
    way = "".join(form.format(*each) for each in zip(right, down, strict=True))
    return f"M{x[0] / 10:g} {y[0] / 10:g}{way}"


def picture(cells: list[Cell], width: float, height: float, title: str) -> str:
    """The picture: all cells over the same x."""
    ends = [x for cell in cells for x, *_ in cell.lines if len(x)]
    low = min((float(x[0]) for x in ends), default=0.0)
    high = max((float(x[-1]) for x in ends), default=0.0)
    if high <= low:
        high = low + 1.0
    low, high = low - 0.02 * (high - low), high + 0.02 * (high - low)
    body = "\n".join(part for cell in cells for part in cell.draw(low, high))
    head = TEXT.format(x=0.01 * width, y=18, anchor="start", more=' font-size="11"',
                       text=escape(title))  # fmt: skip
    return f"""<?xml version="1.0" encoding="utf-8"?>
<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}pt" height="{height:g}pt" \
viewBox="0 0 {width:g} {height:g}">
<rect width="100%" height="100%" fill="white"/>
<g fill="none" stroke-width="0.6" stroke-linecap="square">
<style>text {{ fill: black; stroke: none }}</style>
<g {FONT}>
{head}
{body}
</g>
</g>
</svg>
"""
