# SPDX-License-Identifier: Apache-2.0
"""Figures saved as SVG, half as long as Matplotlib writes them, and the same for the same data."""

import re
from io import StringIO
from pathlib import Path

DIGITS = 2  # of a coordinate, in points
LINES = re.compile(r"(?:[ML] \S+ \S+ *)+(?:z *)?")  # a path of straight lines
ONE = r'<g(?: id="\w+")?>\n(<[^>]*/>|<text[^>]*>[^<]*</text>)\n</g>'  # a group of one element
FILLED = r'(<path d=")([^"]*z)("(?! style="[^"]*opacity)[^>]*/>)\n\1([^"]*z)\3'


def save(figure, path: Path) -> None:
    text = StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    path.write_text(smaller(text.getvalue()))


def smaller(text: str) -> str:
    """The same picture: no metadata, one font, short numbers, relative and merged paths."""
    text = re.sub(r"\n *<metadata>.*?</metadata>|\n *<!--.*?-->", "", text, flags=re.S)
    text = re.sub(r"font-family: [^;\"]*", "font-family: 'DejaVu Sans', sans-serif", text)
    text = re.sub(r"font: ([\d.]+px) [^;\"]*", r"font: \1 'DejaVu Sans', sans-serif", text)
    text = re.sub(r' transform="rotate\(-0 [^"]*"', "", text)
    text = re.sub(r'\n *(?=[<LMCQz"])', "\n", text)
    text = re.sub(r'\b(?:x|y|width|height)="[^"]*"|translate\([^)]*\)', _short, text)
    text = re.sub(r'\bd="[^"]*"', lambda m: _relative(_short(m)), text)
    for pattern, instead in ((ONE, r"\1"), (FILLED, r"\1\2\4\3")):
        found = True
        while found:
            text, found = re.subn(pattern, instead, text)
    return text


def _short(attribute: re.Match) -> str:
    def number(found: re.Match) -> str:
        return f"{float(found[0]):.{DIGITS}f}".rstrip("0").rstrip(".")

    return re.sub(r"-?\d+\.\d+", number, attribute[0].replace("\n", ""))


def _relative(path: str) -> str:
    """Each point from the one before, where all lines are straight."""
    inside = path[3:-1]
    if not LINES.fullmatch(inside):
        return path
    unit, made, x, y = 10**DIGITS, [], 0, 0
    for command, right, down in re.findall(r"([ML]) (\S+) (\S+)|z", inside):
        if not command:
            made.append("z")
            continue
        to = round(float(right) * unit), round(float(down) * unit)
        if command == "M":
            made.append(f"M{to[0] / unit:g} {to[1] / unit:g}")
        else:
            made.append(f"l{(to[0] - x) / unit:g} {(to[1] - y) / unit:g}")
        x, y = to
    return f'd="{"".join(made)}"'
