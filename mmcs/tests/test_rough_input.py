# SPDX-License-Identifier: Apache-2.0
"""Input as no editor leaves it: deep, huge, binary, misplaced. One line, status 2 all the same."""

import re

import pytest

from mmcs import ROOT
from mmcs.tests.conftest import GOOD, good, one_clear_line

DIGITS = "9" * 5000
TABLE = GOOD.replace('kind = "step"', 'kind = "table"\nfile = "t.csv"\nduration = 0.1').replace(
    "to = 200\n", ""
)
TEXTS = {
    "deep": ("a = " + "[" * 5000 + "]" * 5000, "nests deeper than 10 levels"),
    "deep key": (".".join(["a"] * 900) + " = 1", "nests deeper than 10 levels"),
    "digits": (f"cards = {DIGITS}", "holds an integer with thousands of digits"),
    "beyond float": (
        GOOD.replace("200", DIGITS[:400]),
        f"motion.0.to = {DIGITS[:57]}...: must be a number, or a list with one number per axis",
    ),
    "mark": ("\ufeff" + GOOD, "begins with a byte-order mark: save it without"),
    "line in a key": ('"a\\nb" = 1\n' + GOOD, "a\\nb: unknown key; allowed: description, robot, "),
    "long robot": (
        GOOD.replace("lab500", "a" * 300),
        f'robot = "{"a" * 56}...: no such robot; there are: ',
    ),
    "pose": ("pose_deg = [1e300]\n" + GOOD, "pose_deg.0 = 1e+300: must be at most 36000"),
    "clock": ("clk_hz = 88_000_000\n" + GOOD, "clk_hz = 88000000: must be at most 80000000"),
    "no such axis to watch": (
        GOOD + '[[expect]]\nkind = "event"\nevent = "error"\naxis = 5\nseen = false\n',
        'expect.0.axis = 5: robot "lab500" has axes 0 to 0',
    ),
    "process too late": (
        GOOD.partition("[[motion]]")[0]
        + '[[process]]\nkind = "pd"\naxis = 0\nat = 2.0\nto = 5\np = 1.0\n',
        "process.0.at = 2.0: must be before the end of the run (0.3 s)",
    ),
    "table name": (
        TABLE.replace("t.csv", "t\\u0000.csv"),
        'motion.0.file = "t\\x00.csv": cannot be read: no file has such a name',
    ),
}
TABLES = {
    "binary": (b"\xff\xfe\x00", "is not UTF-8 text (byte 0)"),
    "nan": (b"1\nnan\n2\n", "line 2 leaves the 32-bit range of setpoints"),
    "infinite": (b"inf\n2\n", "line 1 leaves the 32-bit range of setpoints"),
    "far": (b"1\n5e9\n", "line 2 leaves the 32-bit range of setpoints"),
    "gap": (b"1\n\n\nx\n", "line 4 has no number in that column"),
    "heading": (
        b"a\n1\n2\n",
        'line 1 has no number in that column; of a table with headings, name a "column"',
    ),
    "empty": (b"", "must hold at least two numbers"),
}
ARGS = {
    "long scenario": (["run", "a" * 300], f'"{"a" * 300}": no such scenario; see `mmcs list`'),
    "long file": (["show", "a" * 300 + ".toml"], f"{'a' * 300}.toml: no such scenario file"),
    "digit": (
        ["check", "lab500", "--set", "motion.².to=1"],
        '--set: motion.².to=1: "²" must be an entry number: 0 to 0',
    ),
    "deep set": (
        ["check", "lab500", "--set", "cards=" + "[" * 3000],
        "--set: cards: nests deeper than 10 levels",
    ),
    "deep set key": (["check", "lab500", "--set", ".".join(["a"] * 900) + "=1"], '--set = "a.a.'),
    "design nan": (["design", "--wn", "nan"], "mmcs design: a number is out of all proportion\n"),
    "design far": (["design", "--wn", "1e300"], "mmcs design: a number is out of all proportion\n"),
    "design far d": (["design", "-d", "1e308"], "mmcs design: a number is out of all proportion\n"),
    "design far tau": (
        ["design", "-d", "1", "--tau", "1e308"],
        "mmcs design: a number is out of all proportion\n",
    ),
    "no such input": (
        ["faults", "nosuch"],
        'PATTERN = "nosuch": no input or register has it in its name\n',
    ),
    "two lines": (["run", "lab500", "--seed", "1\n2"], "Invalid value for '--seed': "),
}


@pytest.mark.req("DRV-3")
@pytest.mark.parametrize("case", TEXTS)
def test_rough_file(mmcs, scenario, case):
    text, expected = TEXTS[case]
    path = scenario(text)
    one_clear_line(mmcs("check", path), start=f"{path}: {expected}")


@pytest.mark.parametrize("case", TABLES)
def test_rough_table(mmcs, scenario, case):
    content, expected = TABLES[case]
    path = scenario(TABLE)
    (path.parent / "t.csv").write_bytes(content)
    told = f'{path}: motion.0.file = "t.csv": {expected}\n'
    one_clear_line(mmcs("check", path), start=told)


def test_table_with_a_byte_order_mark_and_carriage_returns(mmcs, scenario):
    path = scenario(TABLE + 'column = "a"\n')
    (path.parent / "t.csv").write_bytes(b"\xef\xbb\xbfa,b\r\n1,2\r\n\r\n3,4\r\n")
    assert mmcs("check", path)[0] == 0


@pytest.mark.filterwarnings("error::RuntimeWarning")  # people would read of it, too
@pytest.mark.parametrize("case", ARGS)
def test_rough_argument(mmcs, case):
    args, expected = ARGS[case]
    one_clear_line(mmcs(*args), start=expected)


@pytest.mark.parametrize("name", ["report.json", "log.csv", "plot.svg"])
def test_result_that_is_a_folder_is_told_before_the_run(mmcs, tmp_path, name):
    (tmp_path / name).mkdir()
    answer = mmcs("run", "lab500", "--out", tmp_path)
    one_clear_line(answer, start=f"{tmp_path}/{name}: is a folder, and the name of a result\n")


def test_file_that_is_a_folder(mmcs, tmp_path):
    """As of every command that writes one."""
    (tmp_path / "x.fmu").mkdir()
    answer = mmcs("export", "fmu", "lab500", "--out", tmp_path / "x.fmu")
    one_clear_line(answer, start=f"{tmp_path}/x.fmu: is a folder, and the name of a result\n")


def test_trace_that_is_a_folder(mmcs, tmp_path):
    (tmp_path / "x.fst").mkdir()
    answer = mmcs("run", "lab500", "--out", tmp_path, "--trace", tmp_path / "x.fst")
    one_clear_line(answer, start=f"{tmp_path}/x.fst: is a folder, and the name of a result\n")


def test_folder_that_cannot_be_written(mmcs):
    answer = mmcs("run", "lab500", "--out", "/proc")
    one_clear_line(answer, start="/proc: cannot be written: ")


@pytest.mark.parametrize(
    ("report", "log", "expected"),
    [
        ("[]", "t_s\n1\n", "is not a run: its report.json is not one of MMCS"),
        ('{"scenario": "x", "axes": [], "hash": "0x1"}', "", "is not a run: it has an empty log"),
    ],
)
def test_folder_that_is_not_a_run(mmcs, tmp_path, report, log, expected):
    (tmp_path / "report.json").write_text(report)
    (tmp_path / "log.csv").write_text(log)
    for args in (["compare", tmp_path, tmp_path], ["export", "film", tmp_path]):
        one_clear_line(mmcs(*args), start=f"{tmp_path}: {expected}\n")


def test_gear_out_of_all_proportion(mmcs, scenario):
    robot = (ROOT / "sim/robots/lab500.toml").read_text()
    path = scenario(re.sub(r"^gear = .*", "gear = 1e300", robot, count=1, flags=re.M))
    told = f"{path}: axis.0.gear = 1e+300: must be at most 1000000\n"
    one_clear_line(mmcs("check", path), start=told)


def test_description_with_markup(mmcs, scenario, tmp_path):
    path = scenario(GOOD.replace("a test", "a [b] $x_{$ [/none] \\u001b[31m"))
    out = good(mmcs("run", path, "--out", tmp_path / "out"))
    assert out.startswith("test: a [b] $x_{$ [/none] \\x1b[31m\n")
    assert "shoot" in out and "…" not in out


@pytest.mark.parametrize(
    "args", [("campaign", "--seed", "9" * 5000), ("run", "lab500", "x" * 5000)]
)
def test_words_without_end_are_cut(mmcs, args):
    status, out, err = mmcs(*args)
    assert (status, out, err.count("\n")) == (2, "", 1) and len(err) < 400, err
