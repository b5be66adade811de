# SPDX-License-Identifier: Apache-2.0
"""Every class of bad input but robot files, each with the exact line a user sees, and status 2."""

import pytest

from mmcs.tests.conftest import GOOD

ROOM = GOOD.replace("[[motion]]", "{}\n[[motion]]", 1)


def top(line):
    """GOOD with a line among the keys of the top level."""
    return ROOM.format(line)


def motion(line):
    """GOOD with a line in its motion."""
    return GOOD + line + "\n"


def swap(old, new):
    assert old in GOOD
    return GOOD.replace(old, new)


MODES = '"off", "position", "velocity", "torque", "test1"'
KINDS = '"step", "ramp", "quintic", "trapezoid", "sine", "square", "chirp", "table"'
CASES = {
    # TOML itself
    "syntax": ('description = "a\n', "line 1, column 17: not valid TOML: Illegal character '\\n'"),
    "twice": (top("cards = 2"), "line 7, column 10: not valid TOML: Cannot overwrite a value"),
    "unfinished": ("cards =", "line 1, column 8: not valid TOML: Invalid value"),
    # keys
    "unknown key": (top("interval = 5"), 'interval: unknown key; did you mean "interval_us"?'),
    "unknown far": (
        motion("colour = 1"),
        "motion.0.colour: unknown key; allowed: axis, at, unit, kind, to",
    ),
    "missing": (
        swap("cards = 1\n", ""),
        "cards: is missing; the number of motor interface cards, 1 to 16",
    ),
    "missing in motion": (swap("to = 200", ""), "motion.0.to: is missing; the new setpoint"),
    "no kind": (swap('kind = "step"', ""), 'motion.0: needs a key "kind"'),
    # types
    "word for number": (
        swap("cards = 1", 'cards = "one"'),
        'cards = "one": must be a whole number',
    ),
    "fraction": (swap("cards = 1", "cards = 1.5"), "cards = 1.5: must be a whole number"),
    "truth for number": (
        swap("duration = 0.3", "duration = true"),
        "duration = true: must be a number",
    ),
    "number for word": (
        swap('robot = "lab500"', "robot = 5"),
        "robot = 5: must be a string in quotes",
    ),
    "number for truth": (top("double_buffer = 1"), "double_buffer = 1: must be true or false"),
    "table for list": (top("servo = 3"), "servo = 3: must be a list [...]"),
    "number for table": (top("host = 3"), "host = 3: must be a table"),
    "infinite": (
        swap("duration = 0.3", "duration = inf"),
        "duration = inf: must be a finite number",
    ),
    # values
    "cards 0": (swap("cards = 1", "cards = 0"), "cards = 0: must be at least 1"),
    "cards 17": (swap("cards = 1", "cards = 17"), "cards = 17: must be at most 16"),
    "no time": (swap("duration = 0.3", "duration = 0"), "duration = 0: must be more than 0"),
    "interval": (top("interval_us = 99"), "interval_us = 99: must be at least 100"),
    "long interval": (
        top("interval_us = 2147483647"),
        "interval_us = 2147483647: must be at most 1000000",
    ),
    "clock": (top("clk_hz = 9_000_000"), "clk_hz = 9000000: must be a multiple of 8000000"),
    "mode": (
        top('[[servo]]\nmode = "postion"'),
        f'servo.0.mode = "postion": must be one of {MODES}; did you mean "position"?',
    ),
    "flag": (
        top('[[servo]]\nflags = ["coulomb"]'),
        'servo.0.flags.0 = "coulomb": must be one of "coulcomp", "adfb", "zerofb", "addmd", '
        '"adoff", "poschk", "softerr"; did you mean "coulcomp"?',
    ),
    "kind": (
        swap('"step"', '"stp"'),
        f'motion.0.kind = "stp": must be one of {KINDS}; did you mean "step"?',
    ),
    "gain": (
        top("[[servo]]\na0 = 3_000_000_000"),
        "servo.0.a0 = 3000000000: must be at most 2147483647",
    ),
    "b0": (
        top("[[servo]]\nb0 = 0"),
        "servo.0.b0 = 0: must not be 0: it divides the compensator's output",
    ),
    "motor unknown": (
        top("[[motor]]\nfricton = 1"),
        'motor.0.fricton: unknown key; did you mean "friction"?',
    ),
    "motor's axis": (
        top("[[motor]]\naxis = 3\nviscous = 1e-6"),
        'motor.0.axis = 3: robot "lab500" has axes 0 to 0',
    ),
    "divisor": (top("[[servo]]\nclkdivisor = 0"), "servo.0.clkdivisor = 0: must be at least 1"),
    "slow servo": (
        top("interval_us = 500\n[[servo]]\nclkdivisor = 101"),
        "axis 0: clkdivisor = 101: must be at most 100 at this interval_us: "
        "servo at least every 50 ms",
    ),
    "ipole": (top("[[servo]]\nipole = 1024"), "servo.0.ipole = 1024: must be at most 1023"),
    "plo above phi": (top("[[servo]]\nplo = 5\nphi = -5"), "axis 0: plo = 5: must be <= phi (-5)"),
    "axis word": (
        swap("axis = 0", 'axis = "first"'),
        'motion.0.axis = "first": must be an axis number from 0, a list of them, or "all"',
    ),
    "axis twice": (
        swap("axis = 0", "axis = [0, 0]"),
        "motion.0.axis = [0, 0]: must not name an axis twice",
    ),
    "axis beyond": (
        swap("axis = 0", "axis = 1"),
        'motion.0.axis = 1: robot "lab500" has axes 0 to 0',
    ),
    "target word": (
        swap("to = 200", 'to = "far"'),
        'motion.0.to = "far": must be a number, or a list with one number per axis',
    ),
    "targets": (
        swap("to = 200", "to = [1, 2]"),
        "motion.0.to = [1.0, 2.0]: must have 1 numbers, one per axis named",
    ),
    "too far": (swap("to = 200", "to = 1e12"), "motion.0.to: leaves the 32-bit range of setpoints"),
    "too late": (
        swap("at = 0.05", "at = 1"),
        "motion.0.at = 1.0: must be before the end of the run (0.3 s)",
    ),
    "past": (swap("at = 0.05", "at = -1"), "motion.0.at = -1: must be at least 0"),
    "no such table": (
        swap('kind = "step"', 'kind = "table"\nfile = "no.csv"\nduration = 0.1').replace(
            "to = 200", ""
        ),
        'motion.0.file = "no.csv": cannot be read: No such file or directory',
    ),
    "overlap": (
        swap('kind = "step"', 'kind = "ramp"\nduration = 0.2')
        + '[[motion]]\naxis = 0\nkind = "step"\nat = 0.1\nto = 0\n',
        "motion: axis 0: the step at 0.1 s begins before the ramp at 0.05 s ends (0.25 s)",
    ),
    "event order": (
        top('[[event]]\nat = 0.2\ninput = "estop"\nvalue = 1\nuntil = 0.1'),
        "event.0.until = 0.1: must be after at (0.2)",
    ),
    "event input": (
        top('[[event]]\nat = 0.2\ninput = "e-stop"\nvalue = 1'),
        'event.0.input = "e-stop": no such input; did you mean "estop"?',
    ),
    "event card": (
        top('[[event]]\nat = 0.2\ninput = "card_absent"\nindex = 1\nvalue = 1'),
        "event.0.index = 1: must be 0",
    ),
    "event value": (
        top('[[event]]\nat = 0.2\ninput = "dip_xor"\nvalue = 16'),
        "event.0.value = 16.0: must be 0 to 15 (bits of the DIP switch that are set wrong)",
    ),
    "band": (
        top('[[expect]]\nkind = "axis"\nrise_ms = [9, 3]'),
        "expect.0.rise_ms = [9, 3]: must be [low, high] with low <= high",
    ),
    "band shape": (
        top('[[expect]]\nkind = "axis"\nrise_ms = 9'),
        "expect.0.rise_ms = 9: must be a pair [low, high]",
    ),
    "count": (
        top('[[expect]]\nkind = "stats"\nmissed = -1'),
        "expect.0.missed = -1: must be a whole number from 0, or a pair [low, high]",
    ),
    "hash": (
        top('[[expect]]\nkind = "hash"\nhash = "12"'),
        'expect.0.hash = "12": must be 0x and 16 hexadecimal digits',
    ),
    "expects nothing": (
        top('[[expect]]\nkind = "axis"'),
        "expect.0: expects nothing; add one of: rise_ms, overshoot_pct, settle_ms, "
        "steady_error_counts, final_counts, peak_error_counts",
    ),
    # the robot
    "robot": (
        swap('"lab500"', '"lab50"'),
        'robot = "lab50": no such robot; did you mean "lab500"?',
    ),
    "cards too few": (swap('"lab500"', '"puma560"'), "cards = 1: 6 axes need at least 3 cards"),
    "not an arm": (
        top('dynamics = "coupled"'),
        'dynamics = "coupled": robot "lab500" has no [[link]]',
    ),
}


@pytest.mark.req("DRV-3")
@pytest.mark.parametrize("case", CASES)
def test_scenario_mistake(mmcs, scenario, case):
    text, expected = CASES[case]
    path = scenario(text)
    for command in ("run", "check"):
        status, out, err = mmcs(command, path)
        assert err == f"mmcs: {path}: {expected}\n"
        assert (status, out) == (2, "")


def test_check_explains_every_mistake_and_run_the_first(mmcs, scenario):
    path = scenario(swap("cards = 1", "cards = 0") + "colour = 1\n")
    expected = [
        f"mmcs: {path}: motion.0.colour: unknown key; allowed: axis, at, unit, kind, to",
        f"mmcs: {path}: cards = 0: must be at least 1",
    ]
    status, _, err = mmcs("check", path)
    assert (status, err.splitlines()) == (2, expected)
    status, _, err = mmcs("run", path)
    assert (status, err.splitlines()) == (2, expected[:1])


OPTIONS = {
    "no such scenario": (["run", "lab50"], '"lab50": no such scenario; did you mean "lab500"?'),
    "no such file": (["run", "./nowhere.toml"], "./nowhere.toml: no such scenario file"),
    "host": (
        ["run", "lab500", "--host", "vax"],
        '--host = "vax": must be one of "native", "m68020", "rv32"',
    ),
    "trace": (
        ["run", "lab500", "--trace", "x.vcd"],
        '--trace = "x.vcd": must be a file name ending in .fst',
    ),
    "set": (
        ["run", "lab500", "--set", "cards"],
        "--set: cards: must be key=value, like servo.0.ilim=500",
    ),
    "set index": (
        ["run", "lab500", "--set", "motion.7.to=1"],
        '--set: motion.7.to=1: "7" must be an entry number: 0 to 0',
    ),
    "set through a value": (
        ["run", "lab500", "--set", "cards.x=1"],
        '--set: cards.x=1: "cards" is a value and has no keys',
    ),
    "set value": (
        ["run", "lab500", "--set", "cards=99"],
        "sim/scenarios/basic/lab500.toml: cards = 99: must be at most 16",
    ),
    "set of a servo": (
        ["run", "lab500", "--set", "axis.0.ilim=5", "--set", "axis.0.b0=0"],
        "--set: axis.0.b0 = 0: must not be 0: it divides the compensator's output",
    ),
    "set of a motor": (
        ["run", "lab500", "--set", "robot.axis.all.km=-1"],
        "--set: robot.axis.all.km = -1: must be at least 1e-12",
    ),
    "duration": (
        ["run", "lab500", "--duration", "-1"],
        "sim/scenarios/basic/lab500.toml: duration = -1.0: must be more than 0",
    ),
    "duration word": (
        ["run", "lab500", "--duration", "long"],
        "Invalid value for '--duration': 'long' is not a valid float.",
    ),
    "seed": (
        ["run", "lab500", "--seed", "-1"],
        "sim/scenarios/basic/lab500.toml: seed = -1: must be at least 0",
    ),
}


@pytest.mark.parametrize("case", OPTIONS)
def test_option_mistake(mmcs, case):
    args, expected = OPTIONS[case]
    status, out, err = mmcs(*args)
    assert err == f"mmcs: {expected}\n"
    assert (status, out) == (2, "")


@pytest.mark.parametrize(
    ("args", "expected"),
    [
        (["fly"], "No such command 'fly'."),
        (["run"], "SCENARIO: name one, or a snapshot with --from"),
        (["run", "lab500", "--fast"], "No such option '--fast'."),
    ],
)
def test_misused_command(mmcs, args, expected):
    status, out, err = mmcs(*args)
    assert (status, out) == (2, "")
    assert err.startswith(f"mmcs: {expected}") and err.count("\n") == 1


def test_out_folder_that_cannot_be_made(mmcs, tmp_path):
    (tmp_path / "file").write_text("")
    status, _, err = mmcs("run", "lab500", "--out", tmp_path / "file" / "out")
    assert (status, err) == (2, f"mmcs: {tmp_path}/file/out: cannot be made: Not a directory\n")
