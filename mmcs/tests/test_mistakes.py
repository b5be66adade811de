# SPDX-License-Identifier: Apache-2.0
"""Every class of bad input but robot files, each with the exact line a user sees, and status 2."""

import functools

import pytest

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
        "clk_hz = 9000000": "must be a multiple of 8000000",
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
CASES = {
    # TOML itself
    "syntax": ('description = "a\n', "line 1, column 17: not valid TOML: Illegal character '\\n'"),
    "twice": (HEAD + "cards = 2", "line 7, column 10: not valid TOML: Cannot overwrite a value"),
    "unfinished": ("cards =", "line 1, column 8: not valid TOML: Invalid value"),
    # keys
    "unknown key": (top("interval = 5"), 'interval: unknown key; did you mean "interval_us"?'),
    "unknown far": (
        table("motion", "colour = 1"),
        "motion.0.colour: unknown key; allowed: axis, at, unit, kind, to",
    ),
    "missing": (
        without("cards = 1\n"),
        "cards: is missing; the number of motor interface cards, 1 to 16",
    ),
    "missing in motion": (without("to = 200"), "motion.0.to: is missing; the new setpoint"),
    "no kind": (without('kind = "step"'), 'motion.0: needs a key "kind"'),
    "motor unknown": (
        table("motor", "fricton = 1"),
        'motor.0.fricton: unknown key; did you mean "friction"?',
    ),
    # values that depend on others
    "flag": (
        table("servo", 'flags = ["coulomb"]'),
        'servo.0.flags.0 = "coulomb": must be one of "coulcomp", "adfb", "zerofb", "addmd", '
        '"adoff", "poschk", "softerr"; did you mean "coulcomp"?',
    ),
    "slow servo": (
        "interval_us = 500" + table("servo", "clkdivisor = 101"),
        "axis 0: clkdivisor = 101: must be at most 100 at this interval_us: "
        "servo at least every 50 ms",
    ),
    "plo above phi": (table("servo", "plo = 5\nphi = -5"), "axis 0: plo = 5: must be <= phi (-5)"),
    "too far": (table("motion", "to = 1e12"), "motion.0.to: leaves the 32-bit range of setpoints"),
    "no such table": (
        table("motion", 'kind = "table"\nfile = "no.csv"\nduration = 0.1').replace("to = 200", ""),
        'motion.0.file = "no.csv": cannot be read: No such file or directory',
    ),
    "overlap": (
        table("motion", 'kind = "ramp"\nduration = 0.2')
        + '[[motion]]\naxis = 0\nkind = "step"\nat = 0.1\nto = 0\n',
        "motion: axis 0: the step at 0.1 s begins before the ramp at 0.05 s ends (0.25 s)",
    ),
    "event card": (
        table("event", 'input = "card_absent"\nindex = 1'),
        "event.0.index = 1: must be 0",
    ),
    "event value": (
        table("event", 'input = "dip_xor"\nvalue = 16'),
        "event.0.value = 16.0: must be 0 to 15 (bits of the DIP switch that are set wrong)",
    ),
    "count": (
        table("expect", 'kind = "stats"\nmissed = -1'),
        "expect.0.missed = -1: must be a whole number from 0, or a pair [low, high]",
    ),
    "hash": (
        table("expect", 'kind = "hash"\nhash = "12"'),
        'expect.0.hash = "12": must be 0x and 16 hexadecimal digits',
    ),
    "expects nothing": (
        table("expect", ""),
        "expect.0: expects nothing; add one of: rise_ms, overshoot_pct, settle_ms, "
        "steady_error_counts, final_counts, peak_error_counts",
    ),
    "cards too few": (top('robot = "puma560"'), "cards = 1: 6 axes need at least 3 cards"),
}
for _name, _lines in LINES.items():
    for _line, _why in _lines.items():
        _told = f"{_name}.0.{_line}: {_why}" if _name else f"{_line}: {_why}"
        CASES[_told.partition(":")[0]] = (table(_name, _line) if _name else top(_line), _told)


@pytest.mark.req("DRV-3")
@pytest.mark.parametrize("case", CASES)
def test_scenario_mistake(mmcs, scenario, case):
    text, expected = CASES[case]
    path = scenario(text)
    for command in ("run", "check"):
        one_clear_line(mmcs(command, path), start=f"{path}: {expected}\n")


def test_check_explains_every_mistake_and_run_the_first(mmcs, scenario):
    path = scenario(top("cards = 0") + "colour = 1\n")
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
        '--host = "vax": must be one of "native", "m68020"',
    ),
    "trace": (
        ["run", "lab500", "--trace", "x.vcd"],
        '--trace = "x.vcd": must be a file name ending in .fst',
    ),
    "record as a log": (
        ["export", "mcap", "lab500", "--out", "run.mmcs"],
        '--out = "run.mmcs": must end in .mcap',
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
    one_clear_line(mmcs(*args), start=f"{expected}\n")


@pytest.mark.parametrize(
    ("args", "expected"),
    [
        (["fly"], "No such command 'fly'."),
        (["run"], "SCENARIO: name one, or a snapshot with --from"),
        (["run", "lab500", "--fast"], "No such option '--fast'."),
    ],
)
def test_misused_command(mmcs, args, expected):
    one_clear_line(mmcs(*args), start=expected)


def test_out_folder_that_cannot_be_made(mmcs, tmp_path):
    (tmp_path / "file").write_text("")
    answer = mmcs("run", "lab500", "--out", tmp_path / "file" / "out")
    one_clear_line(answer, start=f"{tmp_path}/file/out: cannot be made: Not a directory\n")
