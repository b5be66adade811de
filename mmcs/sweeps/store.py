# SPDX-License-Identifier: Apache-2.0
"""What a sweep leaves: rows as they finish, then one table and a summary."""

import csv
import hashlib
import json
import math
import statistics
from pathlib import Path

from mmcs.errors import InputError, show
from mmcs.folder import lock, whole_file
from mmcs.sweeps.plan import MAX_RUNS, Plan

ROWS = "rows.jsonl"
TABLE = "table.csv"
MAX_LINE = 1 << 20  # bytes of a row
LEADING = ("status", "unmet", "why")


def check_resume(folder: Path, what: str = "sweep") -> None:
    if not (folder / ROWS).is_file():
        allowed = f"holds no {what} to go on with; leave out --resume"
        raise InputError.one(folder, "", None, allowed)


class Store:
    """The finished rows, on disk before they are counted."""

    def __init__(self, folder: Path, identity: str, resume: bool, what: str = "sweep"):
        self.path, self._what = folder / ROWS, what
        self._identity = identity
        self.rows: dict[int, dict] = {}
        self.bad = 0  # of those added now
        self._lock = lock(folder, what)
        if resume:
            try:
                self._read()
            except InputError:
                self._lock.close()
                raise
        elif self.path.exists():  # finished or not, it was somebody's hour
            self.path.replace(self.path.with_suffix(".before.jsonl"))
        new = not self.path.exists()
        self._file = self.path.open("ab", buffering=0)
        if new:
            self._line({"sweep": identity})

    def _read(self) -> None:
        whole = 0
        with self.path.open("r+b") as file:
            for number, line in enumerate(iter(lambda: file.readline(MAX_LINE), b"")):
                if not line.endswith(b"\n"):
                    break  # it was being written when the end came
                whole += len(line)
                entry = _entry(line, self._identity)
                if number:
                    self.rows |= entry
                elif "sweep" not in entry:
                    allowed = "is damaged; leave out --resume"
                    raise InputError.one(self.path, "", None, allowed)
                elif entry["sweep"] != self._identity:
                    allowed = f"is another {self._what} (values, seed, scenario or build differ)"
                    raise InputError.one(self.path, "", None, f"{allowed}; leave out --resume")
            file.truncate(whole)

    def add(self, n: int, row: dict) -> None:
        self._line({"n": n, "row": row, "sum": checksum(self._identity, n, row)})
        self.rows[n] = row
        self.bad += row["status"] != "ok"

    def _line(self, entry: dict) -> None:
        left = memoryview(json.dumps(entry, separators=(",", ":")).encode() + b"\n")
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError as error:
            error.filename = str(self.path)  # a full disk names none
            raise

    def close(self) -> None:
        self._file.close()
        self._lock.close()


def checksum(identity: str, n: int, row: dict) -> str:
    """What a line of the file ends with: a row that was changed by hand is not believed."""
    return hashlib.sha256(json.dumps([identity, n, row]).encode()).hexdigest()[:16]


def _entry(line: bytes, identity: str) -> dict:
    """{number: row}, or the first line; {} for what is neither: that row is run again."""
    try:
        entry = json.loads(line)
        if isinstance(entry.get("sweep"), str):
            return entry
        n, row = entry["n"], entry["row"]
        whole = type(n) is int and 0 <= n < MAX_RUNS and entry["sum"] == checksum(identity, n, row)
        return {n: row} if whole else {}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}


def table(plan: Plan, rows: dict[int, dict]) -> tuple[list[str], list[list]]:
    """Headings and lines, in the order of the rows' numbers."""
    names: dict[str, None] = dict.fromkeys(LEADING)
    for n in sorted(rows):
        names |= dict.fromkeys(rows[n])
    heading = ["run", *plan.keys, *names]
    lines = []
    for n in sorted(rows):
        values = [_plain(v) for v in plan.values(n).values()]
        lines.append([n, *values, *(rows[n].get(name) for name in names)])
    return heading, lines


def _plain(value: object) -> object:
    return show(value) if isinstance(value, list | dict | bool) else value


def write_table(folder: Path, plan: Plan, rows: dict[int, dict]) -> None:
    heading, lines = table(plan, rows)
    with whole_file(folder / TABLE) as part, part.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heading)
        writer.writerows(lines)


# --- summary -----------------------------------------------------------------------------------


def print_summary(plan: Plan, rows: dict[int, dict]) -> None:
    from mmcs import screen
    from mmcs.sweeps.workers import WORST

    title = f"{plan.name}: {len(rows)} of {len(plan)} runs, varied: {', '.join(plan.keys)}"
    head, figures = ("worst axis of a run", "least", "median", "95 %", "most"), []
    ran = [row for row in rows.values() if row["status"] != "failed"]
    for name in WORST:
        values = sorted(abs(row[name]) for row in ran if row.get(name) is not None)
        if values:
            high = values[min(len(values) - 1, math.ceil(0.95 * len(values)) - 1)]
            cells = (values[0], statistics.median_low(values), high, values[-1])
            figures.append((name, *("never" if v == math.inf else f"{v:.4g}" for v in cells)))
    screen.echo(screen.table(title, head, figures, left=1))
    screen.echo(f"the worst again: {plan.command(max(rows, key=lambda n: _rank(rows[n])))}")


def _rank(row: dict) -> tuple[float, float]:
    """The higher, the worse: by expectations, then by the rms error; none is worse than any."""
    bad, error = row["unmet"], row.get("rms_error_counts")
    return math.inf if bad is None else bad, math.inf if error is None else error
