# SPDX-License-Identifier: Apache-2.0
"""`make bench BASE=commit`: the speed of this tree beside that of another commit.

Both are built here and measured in turn, load by load, by the other's own bench; a ratio is the
median of the ratios within each round. The commit is checked out into build/bench/base, where a
checkout that lies there is taken as it is.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys

from mmcs import BUILD, ROOT

LOADS = {
    "6 axes, coupled PUMA, typical move": (3, True, "typical"),
    "6 axes, coupled PUMA, full joint speed": (3, True, "full"),
    "32 axes, typical move": (16, False, "typical"),
}
# Runs in either tree, whose bench and builder have lain in two places.
SERVER = """
import inspect, json, sys
try:
    from studies.bench.machines import Loaded, Machine, ensure_library
except ImportError:
    sys.path.insert(0, "sim")
    from bench.machines import Loaded, Machine, ensure_library
more = {"skip": True} if "skip" in inspect.signature(ensure_library).parameters else {}
kept = {}
for line in sys.stdin:
    cards, arm, load = key = tuple(json.loads(line))
    if key not in kept:
        library = ensure_library(cards, "speed", **more)
        kept[key] = Loaded(Machine(cards, True, arm), load, library)
    print(json.dumps(kept[key].measure()), flush=True)
"""


class Tree:
    """A tree's bench in a process of its own."""

    def __init__(self, folder):
        env = dict(os.environ, PYTHONPATH=str(folder))
        env["PATH"] = f"{os.path.dirname(sys.executable)}:{env.get('PATH', '')}"
        self._server = subprocess.Popen(
            [sys.executable, "-c", SERVER], cwd=folder, env=env, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip

    def rate(self, load: tuple) -> float:
        """Simulated seconds in a second of the processor."""
        self._server.stdin.write(json.dumps(load) + "\n")
        self._server.stdin.flush()
        found = json.loads(self._server.stdout.readline())
        return found["s"] / found["cpu"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("commit")
    parser.add_argument("--rounds", type=int, default=7)
    given = parser.parse_args()
    base = BUILD / "bench" / "base"
    if not base.exists():
        subprocess.run(["git", "worktree", "add", "-f", "--detach", base, given.commit],
                       cwd=ROOT, check=True)  # fmt: skip
    trees = [Tree(base), Tree(ROOT)]
    print(f"| load | {given.commit} | now | ratio |\n|---|---|---|---|")
    for name, load in LOADS.items():
        pairs = [[tree.rate(load) for tree in trees] for _ in range(given.rounds)]
        before, now = (statistics.median(column) for column in zip(*pairs, strict=True))
        ratio = statistics.median(b / a for a, b in pairs)
        print(f"| {name} | {before:.2f}x | {now:.2f}x | {ratio:.2f} |", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
