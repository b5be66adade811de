# SPDX-License-Identifier: Apache-2.0
"""Threads that use the package for the first time at the same moment."""

import sys

from tools.compiled import ran

# Every thread is inside the maker, if it can be, before the first of them has made anything.
FOUR = """
import contextlib, threading
import mmcs
from concurrent.futures import ThreadPoolExecutor
from mmcs import mcdef
from mmcs.runs import runner
together, real = threading.Barrier(4), mcdef.workshop
def slow():
    with contextlib.suppress(threading.BrokenBarrierError):
        together.wait(5)
    return real()
mcdef.workshop = slow
with ThreadPoolExecutor(4) as pool:
    print(*set(pool.map(lambda _: mmcs.run("lab500", duration=0.1).hash, range(4))))
"""


def test_four_threads_at_a_cold_start():
    """One FFI for all of them: a structure of another one is refused."""
    one = "import mmcs; print(mmcs.run('lab500', duration=0.1).hash)"
    mine = ran(sys.executable, "-c", one, check=True)
    four = ran(sys.executable, "-c", FOUR)
    assert four.stdout == mine.stdout, four.stderr[-500:]
