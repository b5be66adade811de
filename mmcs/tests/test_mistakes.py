# SPDX-License-Identifier: Apache-2.0
# Length: one row for each class of bad input.
"""Every class of bad input, each with the exact line that a user sees, and status 2. Where a line
ends in a space, more of it follows: what is allowed."""

import functools
import re
import shlex

import pytest

from mmcs.cli.app import main
from mmcs.tests.conftest import GOOD, one_clear_line, put

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


def without(line):
    assert line in GOOD
    return GOOD.replace(line, "")


TABLE = table("motion", 'kind = "table"\nfile = "t.csv"\nduration = 0.1').replace("to = 200\n", "")
MODES = '"off", "position", "velocity", "torque", "test1"'
KINDS = '"step", "ramp", "quintic", "trapezoid", "sine", "square", "chirp", "table"'
# By table: a line, and why it cannot be. Told is TABLE.0.LINE: WHY.
LINES = {
    "": {
        'cards = "one"': "must be a whole number",
        "cards = 1.5": "must be a whole number",
        "cards = 0": "must be at least 1",
        "cards = 17": "must be at most 16",
        "duration = true": "must be a number",
        "duration = inf": "must be a finite number",
        "duration = 0": "must be more than 0",
        "robot = 5": "must be a string in quotes",
        'robot = "lab50"': 'no such robot; did you mean "lab500"?',
        'dynamics = "coupled"': 'robot "lab500" has no [[link]]',
        "double_buffer = 1": "must be true or false",
        "servo = 3": "must be a list [...]",
        "host = 3": "must be a table",
        "interval_us = 99": "must be at least 100",
        "interval_us = 2147483647": "must be at most 1000000",
        "heartbeat_us = 999": "must be at least 1000",
        "heartbeat_us = 50001": "must be at most 50000",
        "heartbeat_us = 10000.5": "must be a whole number",
        "heartbeat_us = true": "must be a whole number",
        "clk_hz = 9000000": "must be a multiple of 8000000",
        "clk_hz = 88000000": "must be at most 80000000",
    },
    "motion": {
        'kind = "stp"': f'must be one of {KINDS}; did you mean "step"?',
        'axis = "first"': 'must be an axis number from 0, a list of them, or "all"',
        "axis = [0, 0]": "must not name an axis twice",
        "axis = 1": 'robot "lab500" has axes 0 to 0',
        'to = "far"': "must be a number, or a list with one number per axis",
        "to = [1.0, 2.0]": "must have 1 numbers, one per axis named",
        "at = 1.0": "must be before the end of the run (0.3 s)",
        "at = -1": "must be at least 0",
    },
    "servo": {
        'mode = "postion"': f'must be one of {MODES}; did you mean "position"?',
        "a0 = 3000000000": "must be at most 2147483647",
        "b0 = 0": "must not be 0: it divides the compensator's output",
        "clkdivisor = 0": "must be at least 1",
        "ipole = 1024": "must be at most 1023",
    },
    "motor": {"axis = 3": 'robot "lab500" has axes 0 to 0'},
    "event": {
        "until = 0.1": "must be after at (0.2)",
        'input = "e-stop"': 'no such input; did you mean "estop"?',
    },
    "expect": {
        "rise_ms = [9, 3]": "must be [low, high] with low <= high",
        "rise_ms = 9": "must be a pair [low, high]",
    },
}
# The whole of what is told.
TOLD_WHOLE = {
    "motion": {
        "colour = 1": "motion.0.colour: unknown key; allowed: axis, at, unit, kind, to",
        "to = 1e12": "motion.0.to: leaves the 32-bit range of setpoints",
    },
    "servo": {
        "plo = 5\nphi = -5": "axis 0: plo = 5: must be <= phi (-5)",
        'flags = ["coulomb"]': 'servo.0.flags.0 = "coulomb": must be one of "coulcomp", "adfb", '
        '"zerofb", "addmd", "adoff", "poschk", "softerr"; did you mean "coulcomp"?',
    },
    "motor": {"fricton = 1": 'motor.0.fricton: unknown key; did you mean "friction"?'},
    "event": {
        'input = "card_absent"\nindex = 1': "event.0.index = 1: must be 0",
        'input = "dip_xor"\nvalue = 16': "event.0.value = 16.0: must be 0 to 15 "
        "(bits of the DIP switch that are set wrong)",
    },
    "expect": {
        "": "expect.0: expects nothing; add one of: rise_ms, overshoot_pct, settle_ms, "
        "steady_error_counts, final_counts, peak_error_counts",
        "rise = 3": "expect.0.rise: unknown key; did ",
        'kind = "stats"\nmissed = -1': "expect.0.missed = -1: "
        "must be a whole number from 0, or a pair [low, high]",
        'kind = "event"\nevent = "error"\naxis = 5\nseen = false': "expect.0.axis = 5: "
        'robot "lab500" has axes 0 to 0',
        'kind = "event"\nevent = "panic"\nafter = 0.3\nseen = false': "expect.0.after = 0.3: "
        "must be before the end of the run (0.3 s)",
    },
}
CASES = {
    # TOML itself
    "syntax": ('description = "a\n', "line 1, column 17: not valid TOML: Illegal character '\\n'"),
    "twice": (HEAD + "cards = 2", "line 7, column 10: not valid TOML: Cannot overwrite a value"),
    "unfinished": ("cards =", "line 1, column 8: not valid TOML: Invalid value"),
    # keys
    "unknown key": (top("interval = 5"), 'interval: unknown key; did you mean "interval_us"?'),
    "missing": (without("cards = 1\n"),
        "cards: is missing; the number of motor interface cards, 1 to 16"),
    "missing in motion": (without("to = 200"), "motion.0.to: is missing; the new setpoint"),
    "no kind": (without('kind = "step"'), 'motion.0: needs a key "kind"'),
    # values that depend on others
    "slow servo": ("interval_us = 500" + table("servo", "clkdivisor = 101"),
        "axis 0: clkdivisor = 101: must be at most 100 at this interval_us: "
        "servo at least every 50 ms"),
    "no such table": (TABLE.replace("t.csv", "no.csv"),
        'motion.0.file = "no.csv": cannot be read: No such file or directory'),
    "overlap": (table("motion", 'kind = "ramp"\nduration = 0.2')
                + '[[motion]]\naxis = 0\nkind = "step"\nat = 0.1\nto = 0\n',
                "motion: axis 0: the step at 0.1 s begins before the ramp at 0.05 s ends (0.25 s)"),
    "cards too few": (top('robot = "puma560"'), "cards = 1: 6 axes need at least 3 cards"),
    "pose": (top("pose_deg = [1e300]"), "pose_deg.0 = 1e+300: must be at most 36000"),
    "process too late": (HEAD + '[[process]]\nkind = "pd"\naxis = 0\nat = 2.0\nto = 5\np = 1.0\n',
                         "process.0.at = 2.0: must be before the end of the run (0.3 s)"),
    # as no editor leaves it: deep, huge, misplaced
    "deep": ("a = " + "[" * 5000 + "]" * 5000, "nests deeper than 10 levels"),
    "deep key": (".".join(["a"] * 900) + " = 1", "nests deeper than 10 levels"),
    "digits": (f"cards = {'9' * 5000}", "holds an integer with thousands of digits"),
    "beyond float": (GOOD.replace("200", "9" * 400),
        f"motion.0.to = {'9' * 57}...: must be a number, or a list with one number per axis"),
    "mark": ("\ufeff" + GOOD, "begins with a byte-order mark: save it without"),
    "line in a key": (top('"a\\nb" = 1'), "a\\nb: unknown key; allowed: description, robot, "),
    "long robot": (GOOD.replace("lab500", "a" * 300),
        f'robot = "{"a" * 56}...: no such robot; there are: '),
    "table name": (TABLE.replace("t.csv", "t\\u0000.csv"),
        'motion.0.file = "t\\x00.csv": cannot be read: no file has such a name'),
}  # fmt: skip
for _name, _lines in TOLD_WHOLE.items():
    CASES |= {f"{_name} {told}": (table(_name, line), told) for line, told in _lines.items()}
for _name, _lines in LINES.items():
    for _line, _why in _lines.items():
        _told = f"{_name}.0.{_line}: {_why}" if _name else f"{_line}: {_why}"
        CASES[_told.partition(":")[0]] = (table(_name, _line) if _name else top(_line), _told)


def line(told):
    return told if told.endswith(" ") else f"{told}\n"


@pytest.mark.req("DRV-3")
@pytest.mark.parametrize("case", CASES)
def test_scenario_mistake(mmcs, scenario, case):
    text, expected = CASES[case]
    path = scenario(text)
    for command in ("run", "check"):
        one_clear_line(mmcs(command, path), start=f"{path}: {line(expected)}")


# --- robot files -------------------------------------------------------------------------------

OWN = GOOD.replace('"lab500"', '"own.toml"')

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
# Of the axis: a line, and why it cannot be. Told is axis.0.LINE: WHY.
ROBOT_LINES = {
    "km = 0": "must be at least 1e-12",
    "friction = -1": "must be at least 0",
    "inertia = 2000000.0": "must be at most 1000000",
    "rotor_inertia = 1e-16": "must be at least 1e-12",
    "rotor_inertia = 0.001": "must be at most inertia (2e-06), which includes it",
    "amp_gain = -1e+300": "must be at least -10000",
    "gear = 1e+300": "must be at most 1000000",
    "gear = 0.0": "must not be 0; 1 for a motor without gear",
    "stiction_neg = 0.05": "must be at least coulomb_neg (0.1)",
    "counts_per_rev = 7": "must be a multiple of 4",
    "backlash = 0.1": "needs a stiffness above 0",
    **dict.fromkeys(("servo.pd_1000us = [1, 2]", f"servo.pd_1000us = [1, 2, {1 << 31}]"),
                    "must be [a0, a1, b0] or [a0, a1, b0, b1], whole numbers of 32 bits"),
    'source.gear = "E book"': "must be a confidence A, B, C or D, a space, and a reference",
    'source.gear = "A book"': '[reference] has no "book"',
}  # fmt: skip
FLEXIBLE = ROBOT.replace("gear = 1.0", "gear = 1.0\nstiffness = 0.5\nload_inertia = 5e-6")
FLEXIBLE_LINES = {
    "load_inertia = 0.0": "must be more than 0: what hangs on the flexible coupling",
    "stiffness = 500.0": "must be at most 83.3, or 0 for rigid: steps are 50 us",
    "damping = 1.0": "must be at most 0.00833: steps are 50 us",
}
LINK = "[[link]]\nalpha=0.0\na=0.0\nd=0.0\ntheta0=0.0\nmass=1.0\ninertia=[1,1,1,0,0,0]\ncom="
ROBOTS = {
    "missing": (ROBOT.replace("km = 0.02", ""), "axis.0.km: is missing"),
    "typo": (ROBOT.replace("viscous", "viscus"),
        'axis.0.viscus: unknown key; did you mean "viscous"?'),
    "every axis": (ROBOT.replace("[[axis]]", "[every_axis]\nviscus = 1\n[[axis]]"),
        'every_axis.viscus: unknown key; did you mean "viscous"?'),
    "winding": (put(ROBOT, "km = 2.0"),
        "axis.0.inertia = 2e-06: must be at least 0.0002, by km and resistance: steps are 50 us"),
    "gravity": (ROBOT.replace("[[axis]]", "gravity = [0, 0, 1e9]\n[[axis]]"),
        "gravity = [0, 0, 1000000000.0]: must be numbers from -1000 to 1000"),
    "stops": (ROBOT + "stop_lo = 1.0\nstop_hi = 2.0",
              "axis.0.angle0 = 0.0: must lie between the stops (1 to 2)"),
    "arm": (f"{ROBOT}{LINK}[0,0,0]\n{LINK}[0,0,0]",
            'link = "2 links": an arm needs one [[link]] per [[axis]] (1)'),
    "link source": (f'{ROBOT}{LINK}[0,0,0]\nsource = "A x"',
                    'link.0.source = "A x": [reference] has no "x"'),
    "vector": (f"{ROBOT}{LINK}[0]", "link.0.com = [0]: must be a list of 3 numbers"),
    "copies": (put(ROBOT, "copies = 33"), "axis.0.copies = 33: must be at most 32"),
    **{line: (put(ROBOT, line), f"axis.0.{line}: {why}") for line, why in ROBOT_LINES.items()},
    **{
        line: (put(FLEXIBLE, line), f"axis.0.{line}: {why}") for line, why in FLEXIBLE_LINES.items()
    },
}  # fmt: skip


@pytest.mark.parametrize("case", ROBOTS)
def test_robot_mistake(mmcs, scenario, case):
    text, expected = ROBOTS[case]
    robot = scenario(text, "own.toml")
    path = scenario(OWN)
    one_clear_line(mmcs("run", path), start=f"{robot}: {expected}\n")


def test_help_cuts_no_text_and_has_an_example_of_each_command(mmcs):
    text = mmcs("--help")[1]
    assert "..." not in text.replace("[ARGS]...", "")
    for name, command in main.commands.items():
        words = mmcs(name, "--help")[1].split()
        [example] = re.findall(rf"Example: (mmcs {name}\b.*)$", " ".join(words))
        if name not in ("export", "lab"):  # the words are those that it takes
            command.make_context(name, shlex.split(example)[2:])
