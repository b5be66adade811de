# SPDX-License-Identifier: Apache-2.0
"""Which share of ten of what costs most is run: SHARE=0 to 9 in the environment; without it, all.

As a program it prints the share of this commit: commits modulo ten, 0 where they cannot be counted.
"""

import os
import subprocess
import sys
import zlib


def shared(items: list) -> list:
    """The items of the chosen share: ten slices of equal size, in the order of the list."""
    n = os.environ.get("SHARE", "")
    size = len(items)
    return items[int(n) * size // 10 : (int(n) + 1) * size // 10] if n else items


def mixed(names: set[str]) -> list[str]:
    """The names in an order that has nothing to do with what they are called."""
    return sorted(names, key=lambda name: (zlib.crc32(name.encode()), name))


def of_commit() -> int:
    def git(*words: str) -> str:
        done = subprocess.run(["git", *words], capture_output=True, text=True, check=False)
        return done.stdout.strip()

    if git("rev-parse", "--is-shallow-repository") != "false":
        print("mmcs: no whole history here, share 0 of ten is run", file=sys.stderr)
        return 0
    return int(git("rev-list", "--count", "HEAD")) % 10


if __name__ == "__main__":
    print(of_commit())
