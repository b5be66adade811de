# SPDX-License-Identifier: Apache-2.0
"""MSTATUS of <sys/mmcs.h>: what a program may ask of the machine that the report does not have."""

import select

import pytest

ASKED = """
import os, sys
import mmcs
from mmcs import mcdef as mc
dev, mon = mmcs.Device(), mmcs.Device(flags=os.O_RDONLY)
say = lambda text="": print(text, flush=True)
at = dev.status()
number = dev.wait()
after = mon.status()
print(at.enabled, at.stopped, at.why == "", 0 <= after.sample - number < 1000,
      after.time_ns > at.time_ns)
dev.enable()
print(mon.status().enabled)
mon.stop()
now = dev.status()
print(now.enabled, now.stopped, now.stopped_by == os.getpid())
dev.enable()
say(dev.status().stopped)
sys.stdin.readline()
while dev.status().enabled:
    pass
say(dev.status().why)
sys.stdin.readline()
say(dev.status().why)
"""
PANICS = [
    ("estop", 0, 1, "button, or a cause that has passed (", "the hand-held button is pressed"),
    ("cable", 0, 0, "no card answers: cable or power (", "the ribbon cable is pulled"),
]


@pytest.mark.parametrize("name, index, value, why, pin", PANICS)
def test_a_program_asks_how_the_machine_stands(bench, name, index, value, why, pin):
    told = []
    known = f"the simulator knows: {pin}, axis 1: wires A and B are swapped"
    bench.server.machine.console = told.append
    child = bench.python(ASKED)
    lines = [_line(bench, child) for _ in range(4)]
    assert lines == ["False False True True True", "True", "False True True", "False"]
    bench.server.machine.set_input("encoder_swap", 1, 1)
    bench.server.machine.set_input(name, index, value)
    bench.go_on(child)
    assert _line(bench, child) == f"{why}{known})"
    # they have passed, and something else comes: still what shut the machine down
    bench.server.machine.set_input(name, index, 1 - value)
    bench.server.machine.set_input("encoder_swap", 1, 0)
    bench.sim.run(bench.sim.time + 0.2)
    bench.go_on(child)
    out, status = bench.finish(child)
    assert (out.strip(), status) == (why.removesuffix(" ("), 0)
    assert told.count(known) == 1 and told[told.index(known) - 1].startswith("mc: PANIC: "), told


PRESSED = """
import sys
import mmcs
with mmcs.Device() as dev:
    dev.enable()
    now = dev.status()
    print(now.enabled, now.cause, now.why, flush=True)
    sys.stdin.readline()
    print(dev.status().why)
"""


@pytest.mark.req("DRV-9")
def test_a_button_pressed_before_menable_is_told_as_the_simulators_knowledge(bench):
    """No register tells: the latch is edge-triggered (§4.3.6)."""
    told = []
    bench.server.machine.console = told.append
    bench.server.machine.set_input("estop", 0, 1)
    child = bench.python(PRESSED)
    known = "the simulator knows: the hand-held button is pressed"
    assert _line(bench, child) == f"True 0 PANIC stands, which no register tells ({known})"
    assert told[-1] == f"{known}: PANIC stands, and the brakes stay on", told
    bench.server.machine.set_input("estop", 0, 0)
    bench.go_on(child)
    assert bench.finish(child) == ("\n", 0)


def _line(bench, child):
    bench.until(lambda: select.select([child.stdout], [], [], 0)[0] or child.poll() is not None)
    return child.stdout.readline().strip()


LIMIT = """
import mmcs
from mmcs import mcdef as mc
with mmcs.Device() as dev:
    par = dev.get_param(1)
    dev.set_param(1, {**par, "mode": mc.MD_VEL | mc.POSCHK, "plo": 5, "phi": 9})
    try:
        dev.enable()
    except OSError:
        pass
    for n in range(3):
        dev.wait()
    print(dev.status().why)
    try:
        dev.write([1])
    except OSError as error:
        print(error.strerror)
"""


def test_an_axis_that_shut_the_machine_down(bench):
    out, status = bench.finish(bench.python(LIMIT))
    first, second = out.splitlines()
    assert (status, first) == (0, "an error of axis 1: see its errcode")
    assert "shut down by an error" in second
