# SPDX-License-Identifier: Apache-2.0
"""Every lab sheet from beginning to end: its commands as printed, a good student and a bad one."""

import csv
import json
import re
import shlex
import shutil
import tomllib

import pytest

from mmcs.scenario.load import load_robot
from mmcs.scenario.scenario import Host
from mmcs.tests.conftest import call, good, one_clear_line
from mmcs.view import compare, plot
from mmcs_labs.marks import answer_model, questions
from mmcs_labs.sheets import LABS, find_sheet, sheets
from tools.golden import same

ALL = sheets()
VELOCITY = LABS / "01_velocity" / "tests"
README = LABS.parent / "README.md"
FILE = LABS.parent / "tests" / "golden.txt"


@pytest.fixture
def folder(sheet, tmp_path, monkeypatch):
    """What `mmcs lab start` gives."""
    monkeypatch.chdir(tmp_path)
    assert call("lab", "start", sheet.number, "work")[0] == 0
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


def text(sheet):
    return (sheet.folder / "sheet.md").read_text()


@pytest.fixture
def unseen(monkeypatch):
    """Pictures are not drawn: they take most of a command's time, and have tests of their own."""

    def compared(a, b, path):
        path.write_text("")
        return compare.differences(a, b)

    monkeypatch.setattr(plot, "write_plot", lambda result, path: path.write_text(""))
    monkeypatch.setattr(compare, "write_comparison", compared)


def test_commands_of_the_sheet(sheet, folder, unseen):
    blocks = re.findall(r"^ *```sh\n(.*?)^ *```", text(sheet), re.M | re.S)
    commands = [line.strip() for block in blocks for line in block.splitlines()]
    assert commands
    for command in commands:
        program, *args = shlex.split(command, comments=True)
        assert program == "mmcs"
        status, out, err = call(*args)
        assert status == int("# status 1" in command), (command, out, err)


def test_good_student_and_bad(sheet, folder):
    """All points; no point, and for each question the reason that stands beside the answer; each
    figure as before. The empty answer is good input."""
    students = [sheet.folder / "tests" / "good.toml", sheet.folder / "tests" / "bad.toml"]
    (status, best, _), (_, out, err), (_, empty, _) = ends = [
        call("lab", "check", sheet.number, path) for path in (*students, "answer.toml")
    ]
    assert status == 0 and re.search(r"^(\d+) of \1 points$", best, re.M), best
    told = dict(re.findall(r"^(\w+) = .*# told: (.*)$", students[1].read_text(), re.M))
    keys = [question.key for question in questions(sheet)]
    assert list(told) == keys, err
    for key in keys:
        assert re.search(rf"^  0 of \d  {key}: .*{re.escape(told[key])}", out, re.M), (key, out)
    assert empty.count("no answer yet") == len(keys)
    same(sheet.name, "\n".join(f"{status}\n{out}" for status, out, _ in ends), FILE)


def test_the_sheet_asks_what_is_graded(sheet):
    """Keys and points of the sheet, of the answer file and of the grader are the same."""
    graded = [(question.key, question.points) for question in questions(sheet)]
    asked = re.findall(
        r"^\d\.  ((?:`\w+`,? ?(?:and )?)+)\((\d) points?( each)?\)", text(sheet), re.M
    )
    told = [(key, int(points)) for keys, points, _ in asked for key in re.findall(r"\w+", keys)]
    assert [(key, points) for key, points in told if key != "and"] == graded
    assert sum(points for _, points in graded) == 10
    answer = (sheet.folder / "answer.toml").read_text()
    keys = re.findall(r"^# (\w+) = ", answer, re.M)
    assert keys == [key for key, _ in graded]
    filled = tomllib.loads(re.sub(r"^# (?=\w+ = )", "", answer, flags=re.M))
    assert set(filled) == set(answer_model(sheet).model_fields)


DESIGNS = [
    (path, line.removeprefix("# mmcs "))
    for path in sorted(LABS.glob("*/*.toml"))
    for line in path.read_text().splitlines()
    if line.startswith("# mmcs design")
] + [
    (
        LABS / "02_sampling" / "sheet.md",
        "design -p 4.4 -d 0.11 --robot lab500 --interval 3000 --toml",
    ),
    (LABS / "04_windup" / "sheet.md", "design -p 4.4 -d 0.11 --robot lab500 --toml"),
]


@pytest.mark.parametrize("path, command", DESIGNS, ids=lambda v: getattr(v, "parent", v))
def test_integers_are_those_of_the_design(path, command):
    """Of the scenario that names the command, or of the sheet's `--set`."""
    out = good(call(*shlex.split(command)))
    made = dict(re.findall(r"^([ab]\d) = (-?\d+)$", out, re.M))
    stands = dict(re.findall(r"\b([ab]\d) ?= ?(-?\d+)", path.read_text()))
    assert len(made) == 6
    assert stands == {key: made[key] for key in stands} and len(stands) >= 3


def figures():
    """What the sheets say of motors and host, made of the robot files and the schema."""
    puma, lab = (load_robot(name)[1].axis for name in ("puma560", "lab500"))
    a0, a1, b0, b1 = puma[1].servo.pd_1000us
    small = lab[0].servo.pd_1000us
    yield 1, f"({lab[0].counts_per_rev} counts are a revolution)"
    yield 3, f"{sum(small[:2]) / small[2]:.1f} D/A units per count"
    yield 4, f"limit of the robot file, {lab[0].servo.ilim}:"
    yield 5, f"within {Host().latency_max_us:g} us and computes for {Host().cpu_us_per_axis:.0f} us"
    yield 6, f"gear ratio is {puma[0].gear}, the encoder makes {puma[0].counts_per_rev} counts"
    yield 6, f"the potentiometer {puma[0].pot_v_per_rad:g} V in a radian"
    yield 8, f"gives {puma[1].amp_gain} A per volt"
    yield 8, f"constant is {puma[1].km} N m/A, its gear {puma[1].gear}."
    yield 8, f"P = {(a0 + a1) / (b0 + b1):.1f} units per count"
    yield 8, f"Gears of {abs(puma[2].gear):.0f} to 1"


@pytest.mark.parametrize("number, phrase", list(figures()))
def test_figures_of_the_sheets(number, phrase):
    assert phrase in " ".join(text(find_sheet(str(number))).split())


def test_no_sheet_is_half_there():
    """A folder, a grader, two students and a row of the list for each sheet, and none without."""
    folders = {path.name for path in LABS.glob("[0-9]*")}
    assert folders == {sheet.folder.name for sheet in ALL}, "labs: a folder without sheet.md"
    for sheet in ALL:
        students = {path.name for path in (sheet.folder / "tests").glob("*")}
        assert students == {"good.toml", "bad.toml"}, f"{sheet.folder}/tests"
    rows = re.findall(r"^\| \[(\d+)\]\(mmcs_labs/(\w+)/", README.read_text(), re.M)
    assert rows == [(str(sheet.number), sheet.folder.name) for sheet in ALL], "labs/README.md"


def test_a_student_is_given_neither_grader_nor_answers(folder):
    names = [path.name for path in folder.rglob("*")]
    assert "sheet.md" in names
    assert not [name for name in names if re.search("good|bad|solution|grader|tests", name)]


# --- the command -------------------------------------------------------------------------------


def test_start_overwrites_nothing(tmp_path):
    (tmp_path / "answer.toml").write_text("mine")
    answer = call("lab", "start", 1, tmp_path)
    one_clear_line(answer, "is there already, perhaps with your work; name another folder")
    assert (tmp_path / "answer.toml").read_text() == "mine" and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    "number, answer, told",
    [
        (99, "", '"99": no such lab sheet; there are: 1 velocity'),
        ("x", "", '"x": no such lab sheet'),
        (1, "lag = 1", 'lag: unknown key; did you mean "lag_ms"?'),
        (1, 'lag_ms = "late"', 'lag_ms = "late": must be a number'),
        (1, "zero_share = 2", "zero_share = 2: must be at most 1"),
        (1, "weights = [1]", "weights: must have at least 2 entries"),
        (1, "lag_ms = ", "not valid TOML"),
        (1, None, "cannot be read: No such file"),
        (2, "gains = { a0 = 1 }", "gains.b0: is missing"),
        (2, "last_us = 700", "last_us = 700: must be a multiple of 500"),
    ],
)
def test_bad_input_is_one_error(number, answer, told, tmp_path):
    path = tmp_path / "answer.toml"
    if answer is not None:
        path.write_text(answer)
    one_clear_line(call("lab", "check", number, path), told)


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("number", ["0", "-1", "9999", "2147483647", "1e300"])
def test_any_number_is_graded_or_refused(sheet, number, tmp_path):
    """In every place of the answer file that has one, each key by itself."""
    path = tmp_path / "answer.toml"
    for line in (sheet.folder / "answer.toml").read_text().splitlines():
        if answer := re.match(r"# (\w+ = [^#]*)", line):
            path.write_text(re.sub(r"(?<![\w.])\d+(\.\d+)?", number, answer[1]))
            status, out, err = call("lab", "check", sheet.number, path)
            graded = status in (0, 1) and " of 10 points" in out and "nan" not in out
            assert graded or (status, out, err.count("\n")) == (2, "", 1), (answer[1], out, err)


def test_a_sheet_of_ones_own(own_sheets, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert call("lab", "--sheets", own_sheets) == (0, " 1  gain            A gain\n", "")
    out = good(call("lab", "--sheets", own_sheets, "start", 1, "work"))
    assert f"then mmcs lab --sheets {own_sheets} check 1 work/answer.toml\n" in out
    given = {path.name for path in (tmp_path / "work").iterdir()}
    assert given == {"sheet.md", "answer.toml", "scenario.toml"}
    check = ("lab", "--sheets", own_sheets, "check", 1, "work")
    assert "0 of 10 points" in call(*check)[1]
    right = "final = 195\ngains = { a0 = 29236, a1 = -28108, b0 = 128 }\n"
    (tmp_path / "work" / "answer.toml").write_text(right)
    status, out, _ = call(*check)
    assert "  4 of 4  final: 195 counts agrees" in out
    (tmp_path / "work" / "answer.toml").write_text("gains = { a0 = 1, b0 = 0 }\n")
    assert "0 of 6  gains: cannot be run: gains.b0: must not be 0" in call(*check)[1]


def test_a_sheet_without_gains_is_cautioned_once(own_sheets):
    folder = own_sheets / "01_gain"
    motor = "[[axis]]\ninertia = 8.3e-6\nkm = 0.0259\namp_gain = 0.3\ncounts_per_rev = 2000\n"
    (folder / "motor.toml").write_text('title = "a motor"\n' + motor)
    scenario = folder / "scenario.toml"
    scenario.write_text(scenario.read_text().replace('"lab500"', '"motor.toml"'))
    for student in ("anna", "bert"):
        gains = "gains = { a0 = 29236, a1 = -28108, b0 = 128 }\n"
        (own_sheets / f"{student}.toml").write_text(f"final = {len(student)}\n{gains}")
    _, out, err = call("lab", "--sheets", own_sheets, "check", 1, own_sheets, "--csv")
    told = "scenario.toml: axis 0 has no gains, neither here nor in motor.toml: "
    assert err == f"caution: {told}the motor may never move\n" and "caution" not in out


MISTAKEN = """
from mmcs_labs.marks import Question

QUESTIONS = [Question("final", 4, int, lambda answer, run: answer.nothing)]
"""
QUESTION = "from mmcs_labs.marks import Question\nQUESTIONS = "
LEAVES = QUESTION + "[Question('final', 4, int, lambda answer, run: __import__('sys').exit(0))]"
BROKEN_SHEETS = {
    "a question that ends the grader": ("grader.py", LEAVES, "final, grader.py:2: SystemExit: 0"),
    "a grader that ends": ("grader.py", "import sys; sys.exit(0)", "grader.py: SystemExit: 0"),
    "one question twice": (
        "grader.py",
        QUESTION + "2 * [Question('final', 4, int, print)]",
        "QUESTIONS has final twice",
    ),
    "points that are none": (
        "grader.py",
        QUESTION + "[Question('final', '4', int, print)]",
        "points of a question must be a whole number",
    ),
    "a title that is no text": ("sheet.md", b"# \xff", "sheet.md: cannot be read: "),
    "a mistake in a question": ("grader.py", MISTAKEN, "final, grader.py:4: AttributeError"),
    "no grader": ("grader.py", None, "a sheet needs a file grader.py"),
    "no answer": ("answer.toml", None, "a sheet needs a file answer.toml"),
    "wrong grader": ("grader.py", "import nowhere", "ModuleNotFoundError: No module named"),
    "no questions": ("grader.py", "ANSWER = 1", "KeyError: 'QUESTIONS'"),
}


@pytest.mark.parametrize("case", BROKEN_SHEETS.values(), ids=BROKEN_SHEETS.keys())
def test_a_broken_sheet_is_told(own_sheets, case):
    name, text, expected = case
    path = own_sheets / "01_gain" / name
    path.unlink() if text is None else path.write_bytes(getattr(text, "encode", lambda: text)())
    (own_sheets / "mine.toml").write_text("final = 1")
    mine = () if name == "sheet.md" else ("check", 1, own_sheets / "mine.toml")
    one_clear_line(call("lab", "--sheets", own_sheets, *mine), expected)


def test_two_sheets_of_one_number(own_sheets):
    shutil.copytree(own_sheets / "01_gain", own_sheets / "1_other")
    one_clear_line(call("lab", "--sheets", own_sheets), "1_other: there is another sheet 1")


def test_a_class(tmp_path):
    """Answers by file and by folder, one of them damaged; a row for each student."""
    one_clear_line(call("lab", "check", 1, tmp_path), "holds no answers")
    (tmp_path / "anna").mkdir()
    shutil.copy(VELOCITY / "bad.toml", tmp_path / "anna" / "answer.toml")
    shutil.copy(VELOCITY / "good.toml", tmp_path / "bert.toml")
    (tmp_path / "carl.toml").write_text("unit_cps = ")
    status, out, _ = call("lab", "check", 1, tmp_path)
    assert status == 1 and out.splitlines()[:2] == ["anna: 0 of 10 points", "bert: 10 of 10 points"]
    assert "carl: 0 of 10 points  line 1, column 12: not valid TOML" in out
    rows = list(csv.DictReader(call("lab", "check", 1, tmp_path, "--csv")[1].splitlines()))
    assert [(row["student"], row["points"]) for row in rows] == [
        ("anna", "0"), ("bert", "10"), ("carl", "0"),
    ]  # fmt: skip
    assert sum(int(rows[1][q.key]) for q in questions(find_sheet("1"))) == 10
    told = json.loads(call("lab", "check", 1, tmp_path, "--json")[1])
    assert all(mark["why"] for row in told[:2] for mark in row["marks"].values())
    one = call("lab", "check", 1, tmp_path / "bert.toml", "--csv")
    assert one[0] == 0 and "bert," in one[1]
    for name, cell in (("=1+1", "'=1+1"), ("a\x1b[2Jb", r"a\x1b[2Jb")):
        (tmp_path / "carl.toml").rename(tmp_path / f"{name}.toml")
        rows = list(csv.DictReader(call("lab", "check", 1, tmp_path, "--csv")[1].splitlines()))
        assert cell in [row["student"] for row in rows]
        (tmp_path / f"{name}.toml").rename(tmp_path / "carl.toml")
    shutil.copy(VELOCITY / "good.toml", tmp_path / "anna.toml")
    one_clear_line(call("lab", "check", 1, tmp_path), "is a second answer of anna, beside ")
