# SPDX-License-Identifier: Apache-2.0
"""The third of three processes, §2.3: starts a controller and a monitor over and over, and kills
them by SIGKILL at random moments.

killer.py PROGRAM SEED ROUNDS      prints "N rounds K kills"; exits with 1 if one ends by itself
"""

import random
import subprocess
import sys
import time


def start(program: str, role: str) -> subprocess.Popen:
    return subprocess.Popen([program, role], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


def is_going(child: subprocess.Popen) -> bool:
    """Waits for the line that it prints after its first sample."""
    line = child.stdout.readline()
    if line == b"going\n":
        return True
    print(f"{child.args[1]}: {line!r}, {child.wait()}")
    return False


def kill(child: subprocess.Popen) -> None:
    child.kill()
    child.wait()
    child.stdout.close()


def main() -> int:
    program, seed, rounds = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    chance = random.Random(seed)
    kills = 0
    living: dict[str, subprocess.Popen] = {}
    for done in range(rounds):
        for role in ("controller", "monitor"):
            if role not in living:
                living[role] = start(program, role)
        last = done == rounds - 1
        patient = last or chance.random() < 0.7  # else even before they have opened the device
        if patient and not all(is_going(living[role]) for role in set(living) & fresh(living)):
            return 1
        time.sleep(chance.random() * 0.2)
        victims = chance.choice((["controller"], ["monitor"], ["controller", "monitor"]))
        for role in victims:
            if patient and living[role].poll() is not None:
                print(f"{role} ended by itself: {living[role].stdout.read()!r}")
                return 1
            kill(living.pop(role))
            kills += 1
        if len(victims) == 2:
            time.sleep(chance.random() * 0.1)
    for child in living.values():
        kill(child)
    print(f"{rounds} rounds {kills + len(living)} kills")
    return 0


_greeted: set[int] = set()


def fresh(living: dict[str, subprocess.Popen]) -> set[str]:
    """Those whose first line has not been read yet; it will be now."""
    new = {role for role, child in living.items() if child.pid not in _greeted}
    _greeted.update(living[role].pid for role in new)
    return new


if __name__ == "__main__":
    sys.exit(main())
