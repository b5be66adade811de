#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs a command on a bad machine: beside busy loops, and with every process of it stopped at
random moments. No test may tell the difference; `make test-loaded` is this around the suite.

  stall.py [--loops N] [--seed S] -- COMMAND...
"""

import argparse
import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

STOP_S = 0.4  # the longest stop
PAUSE_S = 0.05  # the longest time without one


def living(session: int) -> list[int]:
    """Every process of the session, however deep."""
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError, ValueError):
            stat = Path(f"/proc/{name}/stat").read_text()
            if int(stat.rsplit(")", 1)[1].split()[3]) == session:
                found.append(int(name))
    return sorted(found)


def stall(child: subprocess.Popen, chance: random.Random) -> int:
    """Stops one process after another until the command has ended; how often."""
    stops = 0
    while child.poll() is None:
        victims = living(child.pid)
        if victims:
            victim = chance.choice(victims)
            with contextlib.suppress(ProcessLookupError):
                os.kill(victim, signal.SIGSTOP)
                time.sleep(chance.random() ** 3 * STOP_S)
                os.kill(victim, signal.SIGCONT)
                stops += 1
        time.sleep(chance.random() * PAUSE_S)
    return stops


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--loops", type=int, default=4)
    parser.add_argument("--seed", type=int, default=1989)
    parser.add_argument("command", nargs="+")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    child = None
    busy = [
        subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(options.loops)
    ]
    try:
        child = subprocess.Popen(options.command, start_new_session=True)
        stops = stall(child, random.Random(options.seed))
    finally:  # nothing is left behind, nor left stopped, if this one is stopped
        for process in living(child.pid) if child else []:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        for loop in busy:
            loop.kill()
            loop.wait()
    print(f"stall: {stops} stops, {options.loops} busy loops beside it", flush=True)
    return child.returncode


if __name__ == "__main__":
    sys.exit(main())
