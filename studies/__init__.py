# SPDX-License-Identifier: Apache-2.0
"""What looks at the product from outside: measurements, comparisons, tables of the book.

May know: every room of mmcs. No room of mmcs knows it.
"""

import resource
import subprocess
import sys
from collections.abc import Callable

from mmcs import ROOT, InputError, RunError


def run(main: Callable[[], int | None]) -> None:
    """Ends the program; bad input and a machine that cannot go on end in one line."""
    try:
        sys.exit(main() or 0)
    except (InputError, RunError) as error:
        print(f"mmcs: {error}", file=sys.stderr)
        sys.exit(2 if isinstance(error, InputError) else 1)


def carried_out(command: list, good: tuple = (0,), **how) -> tuple[str, float]:
    """What a program has said, and processor seconds of it and of all that it started."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, cwd=ROOT, text=True, capture_output=True, check=False, **how)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in good:
        said = (done.stderr or done.stdout).strip()[-400:]
        raise SystemExit(f"mmcs: {' '.join(map(str, command))[:60]}... failed: {said}")
    return done.stdout, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
