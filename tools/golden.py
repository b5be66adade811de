# SPDX-License-Identifier: Apache-2.0
"""Whole outputs beside those of before, of which a file has digests: each of a line, or of some
lines of a long text. With MMCS_WRITE=1 in the environment the file gets those of today."""

import difflib
import os
import re
import zlib
from pathlib import Path

import pytest

from mmcs import ROOT, __version__

FILE = ROOT / "mmcs" / "tests" / "golden.txt"
MOST = 14  # digests of a text, whose row has 100 columns
# Of a computer, a build, a release or the hour, and of what the process has simulated before.
VARY = {
    r'("(?:wall_s|rtf|evals|hits|misses|bytes|build|files|log_crc32|sum|sweep)": ?).*': r"\1",
    r"in [\d.]+ s(: real-time factor|, ).*": r"in a time\1",
    r"mmcs: (\d+ of \d+ \w+, about .* left|building .*)\n": "",
    re.escape(__version__): "VERSION",
    rf"('(?:pid|stopped_by)': ){os.getpid()}\b": r"\1its own",
}  # fmt: skip


def plain(text: str, *folders: Path) -> str:
    """Without what may differ; folders have no name."""
    for folder in (*folders, ROOT):
        text = text.replace(str(folder), "")
    for pattern, instead in VARY.items():
        text = re.sub(pattern, instead, text)
    return text


def kept(file: Path) -> dict[str, list[str]]:
    rows = (line.partition(": ") for line in file.read_text().splitlines())
    return {name: digests.split() for name, _, digests in rows}


def same(name: str, text: str, file: Path = FILE) -> None:
    """Fails with those parts of the text that were not there before."""
    lines = text.splitlines()
    each = max(1, -(-len(lines) // MOST))
    parts = ["\n".join(lines[n : n + each]) for n in range(0, len(lines), each)]
    now = [f"{zlib.crc32(part.encode()) & 0xFFFF:04x}" for part in parts]
    if os.environ.get("MMCS_WRITE"):
        rows = sorted((kept(file) | {name: now}).items())
        file.write_text("".join(f"{key}: {' '.join(digests)}\n" for key, digests in rows))
    if (before := kept(file).get(name)) == now:
        return
    found = difflib.SequenceMatcher(a=before or [], b=now, autojunk=False).get_opcodes()
    new = [part for tag, _, _, a, b in found if tag != "equal" for part in parts[a:b]]
    told = f"{name}: not as before, or lines of before are gone:"
    meant = "if that is meant: MMCS_WRITE=1 pytest this test"
    pytest.fail("\n".join([told, *new, meant]), pytrace=False)
