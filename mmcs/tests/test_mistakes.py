# SPDX-License-Identifier: Apache-2.0
"""Classes of bad input of scenario and robot files: what a user sees of each (tools/golden.py)."""

import functools
import re
import shlex

import pytest

from mmcs.cli.app import main
from mmcs.tests.conftest import GOOD, call, put
from tools.golden import plain, same

HEAD, MOTION = GOOD.split("[[motion]]\n")
# What a table of a scenario has beside the line in question.
TABLES = {
    "motion": MOTION, "servo": "", "motor": "", "expect": 'kind = "axis"\n',
    "event": 'at = 0.2\ninput = "estop"\nvalue = 1\n',
}  # fmt: skip


def top(line):
    """GOOD with this line among the keys of the top level."""
    return f"{put(HEAD, line)}[[motion]]\n{MOTION}"


def table(name, lines):
    """GOOD with these lines in a table of it, or in one more."""
    text = functools.reduce(put, lines.splitlines(), TABLES[name])
    return f"{HEAD}[[{name}]]\n{text}" + ("" if name == "motion" else f"[[motion]]\n{MOTION}")


TABLE = table("motion", 'kind = "table"\nfile = "t.csv"\nduration = 0.1').replace("to = 200\n", "")
# By table: lines, or more than one, that cannot be.
LINES = {
    "": """cards = "one"; cards = 1.5; cards = 0; cards = 17; duration = true; duration = inf;
duration = 0; robot = 5; robot = "lab50"; dynamics = "coupled"; double_buffer = 1; servo = 3;
host = 3; interval_us = 99; interval_us = 2147483647; heartbeat_us = 999; heartbeat_us = 50001;
heartbeat_us = 10000.5; heartbeat_us = true; clk_hz = 9000000; clk_hz = 88000000; interval = 5;
robot = "puma560"; pose_deg = [1e300]; "a\\nb" = 1""",
    "motion": """kind = "stp"; axis = "first"; axis = [0, 0]; axis = 1; to = "far"; to = [1.0, 2.0];
at = 1.0; at = -1; colour = 1; to = 1e12""",
    "servo": """mode = "postion"; a0 = 3000000000; b0 = 0; clkdivisor = 0; ipole = 1024;
plo = 5\nphi = -5; flags = ["coulomb"]""",
    "motor": "axis = 3; fricton = 1",
    "event": """until = 0.1; input = "e-stop"; input = "card_absent"\nindex = 1;
input = "dip_xor"\nvalue = 16""",
    "expect": """rise_ms = [9, 3]; rise_ms = 9; ; rise = 3; kind = "stats"\nmissed = -1;
kind = "event"\nevent = "error"\naxis = 5\nseen = false;
kind = "event"\nevent = "panic"\nafter = 0.3\nseen = false""",
}
WHOLE = [
    # TOML itself
    'description = "a\n', f"{HEAD}cards = 2", "cards =",
    # keys
    *(GOOD.replace(line, "") for line in ("cards = 1\n", "to = 200", 'kind = "step"')),
    # values that depend on others
    "interval_us = 500" + table("servo", "clkdivisor = 101"), TABLE.replace("t.csv", "no.csv"),
    table("motion", 'kind = "ramp"\nduration = 0.2')
    + '[[motion]]\naxis = 0\nkind = "step"\nat = 0.1\nto = 0\n',
    HEAD + '[[process]]\nkind = "pd"\naxis = 0\nat = 2.0\nto = 5\np = 1.0\n',
    # as no editor leaves it: deep, huge, misplaced
    f"a = {'[' * 5000}{']' * 5000}", f"{'.'.join(900 * 'a')} = 1", f"cards = {'9' * 5000}",
    GOOD.replace("200", "9" * 400), f"\ufeff{GOOD}", GOOD.replace("lab500", "a" * 300),
    TABLE.replace("t.csv", "t\\u0000.csv"),
]  # fmt: skip


def lines(text):
    return re.split(r";\s", text)


@pytest.fixture
def told(tmp_path, monkeypatch):
    """Holds what `run` and `check` say of mine.toml with this text beside that of before."""
    monkeypatch.chdir(tmp_path)

    def hold(name, texts, file="mine.toml"):
        said = []
        for text in texts:
            (tmp_path / file).write_text(text)
            said += [f"{text[-200:]}\n{call(words, 'mine.toml')}" for words in ("run", "check")]
        same(name, plain("\n".join(said), tmp_path))

    return hold


@pytest.mark.req("DRV-3")
@pytest.mark.parametrize("name", [*LINES, "whole"])
def test_scenario_mistakes(told, name):
    texts = WHOLE if name == "whole" else [
        table(name, line) if name else top(line) for line in lines(LINES[name])
    ]  # fmt: skip
    told(f"wrong {name}", texts)


# --- robot files -------------------------------------------------------------------------------

ROBOT = """
title = "a motor"
[[axis]]
rotor_inertia = 1e-6
inertia = 2e-6
viscous = 0.0
coulomb_pos = 0.1
coulomb_neg = 0.1
stiction_pos = 0.1
stiction_neg = 0.1
km = 0.02
resistance = 1.0
v_supply = 24.0
amp_gain = 0.3
amp_max = 3.0
amp_tau = 0.0
gear = 1.0
counts_per_rev = 2000
"""
# Of the axis: lines that cannot be.
ROBOT_LINES = """km = 0; friction = -1; inertia = 2000000.0; rotor_inertia = 1e-16; gear = 1e+300;
rotor_inertia = 0.001; amp_gain = -1e+300; gear = 0.0; stiction_neg = 0.05; counts_per_rev = 7;
backlash = 0.1; servo.pd_1000us = [1, 2]; servo.pd_1000us = [1, 2, 2147483648];
source.gear = "E book"; source.gear = "A book"; copies = 33; km = 2.0"""
FLEXIBLE = ROBOT.replace("gear = 1.0", "gear = 1.0\nstiffness = 0.5\nload_inertia = 5e-6")
FLEXIBLE_LINES = "load_inertia = 0.0; stiffness = 500.0; damping = 1.0"
LINK = "[[link]]\nalpha=0.0\na=0.0\nd=0.0\ntheta0=0.0\nmass=1.0\ninertia=[1,1,1,0,0,0]\ncom="
ROBOTS = [
    ROBOT.replace("km = 0.02", ""), ROBOT.replace("viscous", "viscus"),
    ROBOT.replace("[[axis]]", "[every_axis]\nviscus = 1\n[[axis]]"),
    ROBOT.replace("[[axis]]", "gravity = [0, 0, 1e9]\n[[axis]]"),
    f"{ROBOT}stop_lo = 1.0\nstop_hi = 2.0", f"{ROBOT}{LINK}[0,0,0]\n{LINK}[0,0,0]",
    f'{ROBOT}{LINK}[0,0,0]\nsource = "A x"', f"{ROBOT}{LINK}[0]",
    *(put(ROBOT, line) for line in lines(ROBOT_LINES)),
    *(put(FLEXIBLE, line) for line in lines(FLEXIBLE_LINES)),
]  # fmt: skip


def test_robot_mistakes(told, scenario):
    scenario(GOOD.replace("lab500", "own.toml"), "mine.toml")
    told("wrong robots", ROBOTS, "own.toml")


def test_help_cuts_no_text_and_has_an_example_of_each_command(mmcs):
    text = mmcs("--help")[1]
    assert "..." not in text.replace("[ARGS]...", "")
    for name, command in main.commands.items():
        words = mmcs(name, "--help")[1].split()
        [example] = re.findall(rf"Example: (mmcs {name}\b.*)$", " ".join(words))
        if name not in ("export", "lab"):  # the words are those that it takes
            command.make_context(name, shlex.split(example)[2:])
