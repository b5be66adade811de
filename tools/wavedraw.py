# SPDX-License-Identifier: Apache-2.0
"""Draws signal changes as SVG, true to scale, and writes them as WaveJSON."""

import json
from dataclasses import dataclass
from html import escape

LEFT, WIDTH, ROW, TOP = 150, 900, 30, 56
HIGH, LOW = 6, 24  # of a row
EDGE = 2.5  # width of a drawn edge
VOLT = 32768 / 10
NS = 1000
STYLE = (
    "text{font:12px ui-monospace,monospace;fill:#1c2733}.t{font:bold 14px sans-serif}"
    ".g{stroke:#dde4ea;stroke-width:1}.a{fill:#5b6b7a;font-size:10px}.w{fill:none;stroke:#0b5394;"
    "stroke-width:1.5}.b{fill:#e8f0f8;stroke:#0b5394;stroke-width:1.2}.v{font-size:10px}"
    ".x{fill:none;stroke:#b45309;stroke-width:1.5}"
)


@dataclass
class Line:
    """One signal: (time in ps, value) from the left border on."""

    label: str
    form: str  # bit, hex, addr (VME A15-A01), volt (signed, 32768 = 10 V)
    width: int
    changes: list[tuple[int, int]]

    def text(self, value: int) -> str:
        if self.form == "addr":
            return f"{value << 1:04X}"
        if self.form == "volt":
            return f"{self.signed(value) / VOLT:.2f}"
        return f"{value:0{(self.width + 3) // 4}X}"

    def signed(self, value: int) -> int:
        return value - (1 << self.width) if value >> (self.width - 1) & 1 else value

    def spans(self, end: int):
        for n, (at, value) in enumerate(self.changes):
            yield at, self.changes[n + 1][0] if n + 1 < len(self.changes) else end, value


def grid_step(span: int) -> int:
    """A round time in ps that divides the picture into 6 to 15 parts."""
    step = NS
    for factor in (2, 2.5, 2) * 8:
        if span / step <= 15:
            break
        step = int(step * factor)
    return step


def unit(span: int) -> tuple[int, str]:
    return (1_000_000, "us") if span > 20_000_000 else (NS, "ns")


def svg(title: str, lines: list[Line], start: int, end: int) -> str:
    """True to scale; time 0 is the left border."""
    span = end - start
    height = TOP + ROW * len(lines) + 12
    divisor, name = unit(span)
    total = LEFT + WIDTH + 20

    def x(at: int) -> float:
        return round(LEFT + (at - start) / span * WIDTH, 1)

    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {total} {height}" '
        f'width="{total}" height="{height}">',
        f"<title>{escape(title)}</title><style>{STYLE}</style>",
        f'<rect width="{total}" height="{height}" fill="#fff"/>',
        f'<text class="t" x="10" y="20">{escape(title)}</text>',
    ]
    step = grid_step(span)
    for n in range(span // step + 1):
        at = x(start + n * step)
        out.append(f'<line class="g" x1="{at}" y1="{TOP - 8}" x2="{at}" y2="{height - 8}"/>')
        label = f"{n * step / divisor:g}" + (f" {name}" if n == 0 else "")
        out.append(f'<text class="a" x="{at}" y="{TOP - 14}" text-anchor="middle">{label}</text>')
    for row, line in enumerate(lines):
        y = TOP + row * ROW
        out.append(f'<text x="10" y="{y + 19}">{escape(line.label)}</text>')
        draw = {"bit": _bit, "volt": _volt}.get(line.form, _bus)
        out += draw(line, y, end, x)
    return "\n".join([*out, "</svg>"]) + "\n"


def _bit(line: Line, y: int, end: int, x) -> list[str]:
    points = []
    for begin, stop, value in line.spans(end):
        level = y + (HIGH if value else LOW)
        points += [f"{x(begin)},{level}", f"{x(stop)},{level}"]
    return [f'<polyline class="w" points="{" ".join(points)}"/>']


def _bus(line: Line, y: int, end: int, x) -> list[str]:
    out = []
    for begin, stop, value in line.spans(end):
        left, right = x(begin), x(stop)
        e = min(EDGE, (right - left) / 2)
        mid = y + (HIGH + LOW) / 2
        out.append(
            f'<path class="b" d="M{left},{mid}L{left + e:.1f},{y + HIGH}H{right - e:.1f}'
            f'L{right},{mid}L{right - e:.1f},{y + LOW}H{left + e:.1f}Z"/>'
        )
        text = line.text(value)
        if right - left > 6 * len(text) + 2:
            out.append(
                f'<text class="v" x="{(left + right) / 2:.1f}" y="{mid + 4}" '
                f'text-anchor="middle">{text}</text>'
            )
    return out


def _volt(line: Line, y: int, end: int, x) -> list[str]:
    points, out = [], []
    for begin, stop, value in line.spans(end):
        level = y + (HIGH + LOW) / 2 - line.signed(value) / 32768 * (LOW - HIGH) / 2
        points += [f"{x(begin)},{level:.1f}", f"{x(stop)},{level:.1f}"]
        if x(stop) - x(begin) > 40:
            below = level + 12 if level < y + 14 else level - 4
            out.append(
                f'<text class="v" x="{x(begin) + 4}" y="{below:.1f}">{line.text(value)}</text>'
            )
    return [f'<polyline class="x" points="{" ".join(points)}"/>', *out]


def wavejson(title: str, lines: list[Line], start: int, end: int) -> str:
    """For WaveDrom: one brick for each step of time in which anything moves (not to scale)."""
    times = sorted({at for line in lines for at, _ in line.changes if at > start})
    slots = [start, *times]
    signals = []
    for line in lines:
        values, wave, data, last = dict(line.changes), "", [], None
        for at in slots:
            value = values.get(at, last)
            if value == last:
                wave += "."
            elif line.form == "bit":
                wave += str(value)
            else:
                wave += "="
                data.append(line.text(value))
            last = value
        signals.append({"name": line.label, "wave": wave} | ({"data": data} if data else {}))
    ticks = [f"{(at - start) / NS:g}" for at in slots]
    body = {
        "head": {"text": title},
        "signal": signals,
        "foot": {"text": "changes at (ns): " + " ".join(ticks[:40])},
    }
    return json.dumps(body, indent=1) + "\n"
