# SPDX-License-Identifier: Apache-2.0
"""Names, files and surroundings that mean no good: one clear line, and nothing is lost."""

import base64
import io
import json
import os
import random
import re
import shutil
import subprocess
import sys
import zipfile
import zlib
from pathlib import Path

import pytest

from mmcs import ROBOTS, ROOT
from mmcs.engine import build
from mmcs.tests.conftest import GOOD

CLI = [sys.executable, "-m", "mmcs"]


def one_clear_line(answer, *words, status=2):
    got, out, err = answer
    assert got == status, (out, err)
    assert err.startswith("mmcs: ") and err.count("\n") == 1 and err.endswith("\n"), err
    assert "Traceback" not in err and err[:-1].isprintable(), err
    for word in words:
        assert word in err, err


def command(*args, **options):
    done = subprocess.run(
        [*CLI, *map(str, args)], cwd=ROOT, capture_output=True, check=False, **options
    )
    return done.returncode, done.stdout, done.stderr


# --- names -------------------------------------------------------------------------------------

NAMES = ["[red]x[bold]", "[x", "[b]", "\x1b[31mx", "a\rb", "a\nb", ":smile:", b"\xff\xfe".decode(
    errors="surrogateescape"), "ümläut", "x" * 200, "-" + "x", "%s", "{x}"]  # fmt: skip


@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
def test_names_are_text(mmcs, tmp_path, name):
    path = tmp_path / f"{name}.toml"
    path.write_text(GOOD.replace('"a test"', '"[b]a\\u001b[7m :smile:"'))
    for args in (("check", path), ("show", path)):
        status, out, err = mmcs(*args)
        assert (status, err) == (0, "")
        assert "\x1b" not in out and "\r" not in out and "\udcff" not in out
    one_clear_line(mmcs("check", path, "--set", "axis.0.b0=0"))
    one_clear_line(mmcs("run", tmp_path / name / "none"))
    one_clear_line(mmcs("replay", tmp_path / name))
    one_clear_line(mmcs("run", f"--{name}", "lab500"))


def test_names_of_a_robot_are_text(mmcs, tmp_path, scenario):
    robot = (ROBOTS / "lab500.toml").read_text()
    name = r'"[red]\u001b[31m"'
    text = re.sub(r'^name = ".*"', lambda _: f"name = {name}", robot, flags=re.M)
    assert name in text
    (tmp_path / "mine.toml").write_text(text)
    status, out, err = mmcs("show", scenario(GOOD.replace('"lab500"', '"./mine.toml"')))
    assert (status, err) == (0, "") and "[red]\\x1b[31m" in out and "\x1b" not in out


def test_no_way_out_of_the_folder_of_results(mmcs, tmp_path):
    for name in ("...toml", "..toml"):
        path = tmp_path / name
        path.write_text(GOOD)
        one_clear_line(mmcs("run", path), "is no name for results; rename the file")
    assert [p.name for p in tmp_path.iterdir() if p.is_dir()] == []


# the screen itself; what talks to a process; what cleans by itself
OWN = ("screen.py", "gateway.py", "execute.py")


def test_nobody_prints_by_himself():
    for path in (ROOT / "mmcs").rglob("*.py"):
        if path.name not in OWN and "tests" not in path.parts:
            found = re.search(r"click\.echo|\bConsole\(|^\s*print\(", path.read_text(), re.M)
            assert not found, f"{path}: {found[0]}: what is printed goes through mmcs.screen"


# --- surroundings ------------------------------------------------------------------------------

ASCII = {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0", "LANG": "C"}


def test_locale_without_unicode(tmp_path):
    (tmp_path / "ü.toml").write_text(GOOD.replace("a test", "ein Tüst"), encoding="utf-8")
    for args in (("list",), ("show", "puma560"), ("check", tmp_path / "ü.toml")):
        status, out, err = command(*args, env=os.environ | ASCII)
        assert (status, err) == (0, b"")
    status, out, err = command("show", tmp_path / "ü.toml", env=os.environ | ASCII)
    assert status == 0 and "ein Tüst" in out.decode()


@pytest.mark.parametrize("closed", ["<&-", ">&-", "2>&-", "<&- >&- 2>&-", "2>/dev/full"])
def test_closed_files_lose_nothing(mmcs, tmp_path, scenario, closed):
    out = tmp_path / "out"
    run = ["sh", "-c", f'exec "$@" {closed}', "sh", *CLI, "run", scenario(), "--out", out]
    assert subprocess.run(run, cwd=ROOT, check=False).returncode == 0
    report = json.loads((out / "report.json").read_text())
    assert report["scenario"] == "test" and (out / "run.mmcs").read_text().startswith("{")
    assert not list(out.glob(".new")) and mmcs("compare", out, out)[0] == 0


# --- files that are none, or never end ---------------------------------------------------------


def test_file_that_never_ends(mmcs, scenario, tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "big.csv").write_bytes(b"1\n" * (5 << 20))
    (tmp_path / "big.toml").write_bytes(b"#" * (2 << 20))
    table = '[[motion]]\naxis = 0\nkind = "table"\nat = 0.1\nduration = 0.1\nfile = "{}"\n'
    for file, words in (
        ("/dev/zero", "is a pipe, a device or a folder"),
        ("pipe.csv", "is a pipe, a device or a folder"),
        ("/", "cannot be read"),
        ("big.csv", "is larger than 8 MB"),
    ):
        text = GOOD.partition("[[motion]]")[0] + table.format(file)
        one_clear_line(mmcs("check", scenario(text)), words)
    one_clear_line(mmcs("check", tmp_path / "big.toml"), "is larger than 1 MB")
    one_clear_line(
        mmcs("check", scenario(GOOD.replace('"lab500"', '"./big.toml"'))), "is larger than 1 MB"
    )


@pytest.mark.parametrize("args", [
    ("--grid", "axis.0.b0=" + "9" * 5000), ("--grid", "axis.0.b0=1.." + "9" * 5000),
    ("--grid", "axis.0.b0=1..9:" + "9" * 5000), ("--grid", "axis.0.b0=1e999..2"),
    ("--random", "axis.0.b0=" + "9" * 5000 + "..2"), ("--set", "axis.0.b0=" + "9" * 5000,
     "--grid", "axis.0.b0=1,2"), ("--grid", "axis.0.b0=" + "[" * 5000),
])  # fmt: skip
def test_numbers_of_thousands_of_digits(mmcs, tmp_path, args):
    one_clear_line(mmcs("sweep", "lab500", *args, "--out", tmp_path))


def test_very_many_values_are_not_all_tried_beforehand(monkeypatch):
    from mmcs.sweeps.plan import Plan, make_plan

    tried, setup = [], Plan.setup
    monkeypatch.setattr(Plan, "setup", lambda s, v: tried.append(v) or setup(s, v))
    plan = make_plan("lab500", ("axis.0.b0=1..200000",), (), None, 1)
    assert len(plan) == 200_000 and len(tried) <= 101


# --- records, snapshots, rows ------------------------------------------------------------------


@pytest.fixture(scope="module")
def good_run(tmp_path_factory):
    """A real run of a moment, with snapshots."""
    folder = tmp_path_factory.mktemp("run")
    path = folder / "short.toml"
    path.write_text(GOOD.replace("duration = 0.3", "duration = 0.06"))
    assert command("run", path, "--out", folder / "out")[0] == 0
    return folder / "out"


def packed(files):
    return base64.b64encode(zlib.compress(json.dumps(files).encode())).decode()


PACKER = zlib.compressobj(9)
SPACES = PACKER.compress(b" " * (1 << 20)) + PACKER.flush(zlib.Z_FULL_FLUSH)  # a megabyte of them
BOMB = base64.b64encode(SPACES + 399 * SPACES[2:]).decode()  # a header is two bytes
RECORDS = {
    "another format": {"mmcs_run": 99}, "no hash": {"hash": None}, "list": {"data": []},
    "number": {"scenario": 7}, "way out": {"scenario": "../../x"}, "dots": {"scenario": ".."},
    "bomb": {"files": BOMB}, "not base64": {"files": "ä"}, "not packed": {"files": "AAAA"},
    "robot is a number": {"files": packed({"robot.toml": 1})},
    "half a character": {"files": packed({"robot.toml": "\ud800"})},
    "path": {"files": packed({"robot.toml": "", "../x": ""})},
    "none": {"files": packed([])}, "rows": {"rows": "AA=="}, "marks": {"marks": [3, "x"]},
    "columns": {"columns": "AAA="}, "points": {"checkpoints": "AAAA"},
    "samples": {"samples": 10**30}, "not a time": {"motion_start_s": float("nan")},
    "clock": {"clk_hz": 0}, "duration": {"data": {"duration": "x", "robot": "./robot.toml"}},
    "robot elsewhere": {"data": {"duration": 1, "robot": "/etc/passwd"}},
}  # fmt: skip


@pytest.mark.parametrize("what", RECORDS)
def test_crafted_record(mmcs, good_run, tmp_path, what):
    record = json.loads((good_run / "run.mmcs").read_text())
    (tmp_path / "run.mmcs").write_text(json.dumps(record | RECORDS[what]))
    one_clear_line(mmcs("replay", tmp_path), "run.mmcs: ")
    one_clear_line(mmcs("trace", tmp_path, "--at", "0.01"), "run.mmcs: ")


def test_damaged_record(mmcs, good_run, tmp_path):
    """Any byte changed, anything cut off: a sentence, or the run all the same."""
    whole, chance = (good_run / "run.mmcs").read_bytes(), random.Random(1)
    from mmcs.record.record import read_record

    for n in range(300):
        data = bytearray(whole)
        if n % 3:
            data[chance.randrange(len(data))] = chance.randrange(256)
        else:
            del data[chance.randrange(len(data)) :]
        (tmp_path / "run.mmcs").write_bytes(data)
        try:
            read_record(str(tmp_path)).setup(tmp_path)
        except Exception as error:
            assert type(error).__name__ == "InputError", (n, repr(error))


def rewritten(path, target, **members):
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            data = members.get(name, old.read(name))
            if data is not None:
                new.writestr(name, data)
    return target


def test_crafted_snapshots(mmcs, good_run, tmp_path):
    source, target = good_run / "run.mmsnap", tmp_path / "run.mmsnap"
    index = json.loads(zipfile.ZipFile(source).read("index.json"))
    first = index["snapshots"][0]
    bad = [
        {"index.json": b"[]"}, {"index.json": b"{}"}, {"index.json": b"[" * 100_000},
        {"index.json": json.dumps(index | {"snapshots": []})},
        {"index.json": json.dumps(index | {"snapshots": [first | {"t": None}]})},
        {"index.json": json.dumps(index | {"snapshots": [first | {"rows": 10**18}]})},
        {"index.json": json.dumps(index | {"log": [10**18, 8]})},
        {"index.json": json.dumps(index | {"truth": [5, 10**9]})},
        {"index.json": json.dumps(index | {"pots": {"x": 1}})},
        {"index.json": None}, {"record.json": b"{}"}, {"log.bin": None},
        {f"{len(index['snapshots']) - 1}.bin": None},
        {"history.bin": b"\0" * (80 << 20)}, {"log.bin": b"123"}, {"truth.bin": b""},
    ]  # fmt: skip
    for members in bad:
        rewritten(source, target, **members)
        one_clear_line(mmcs("run", "--from", tmp_path), "not a file of snapshots")
    rewritten(source, target, **{f"{len(index['snapshots']) - 1}.bin": b"x" * 500})
    one_clear_line(mmcs("run", "--from", tmp_path, "--out", tmp_path / "o"), "snapshot")


def test_damaged_snapshots(good_run, tmp_path):
    from mmcs.record.snapshots import Snapshot

    whole, chance = (good_run / "run.mmsnap").read_bytes(), random.Random(2)
    for n in range(200):
        data = bytearray(whole)
        if n % 3:
            for _ in range(3):
                data[chance.randrange(len(data))] = chance.randrange(256)
        else:
            del data[chance.randrange(len(data)) :]
        (tmp_path / "run.mmsnap").write_bytes(data)
        try:
            Snapshot(str(tmp_path)).setup()
        except Exception as error:
            assert type(error).__name__ == "InputError", (n, repr(error))


def test_damaged_rows(mmcs, tmp_path):
    from mmcs.errors import InputError
    from mmcs.sweeps.store import Store

    store = Store(tmp_path, "me", False)
    row = {"status": "ok", "unmet": 0, "why": "", "hash": "0x0", "settle_ms": 1.5}
    for n in range(5):
        store.add(n, row)
    with pytest.raises(InputError, match="another sweep is writing here"):
        Store(tmp_path, "me", False)
    store.close()
    lines = (tmp_path / "rows.jsonl").read_bytes().splitlines(keepends=True)
    bad = [b"\xff\n", b"[]\n", b"[" * 5000 + b"\n", b'{"n": -1, "row": {}}\n', b"\n", b'"x"\n',
           b'{"n": 2, "row": {"status": "ok"}}\n', b'{"n": 2, "row": []}\n', b"null\n"]  # fmt: skip
    for line in bad:
        (tmp_path / "rows.jsonl").write_bytes(b"".join([*lines[:3], line, *lines[4:], b'{"n": 4']))
        again = Store(tmp_path, "me", True)
        assert sorted(again.rows) == [0, 1, 3, 4], line  # what is damaged is run again
        again.close()
    (tmp_path / "rows.jsonl").write_bytes(b"\xff" + lines[0])
    with pytest.raises(InputError, match="is damaged; leave out --resume"):
        Store(tmp_path, "me", True)


@pytest.mark.parametrize("report", [
    "[" * 50_000, '{"scenario": 1, "axes": [], "hash": ""}', "nul", "\ud800".encode(
        errors="surrogatepass"), '{"scenario": "x", "axes": [1], "hash": "0x1"}',
])  # fmt: skip
def test_damaged_report(mmcs, good_run, tmp_path, report):
    folder = tmp_path / "run"
    shutil.copytree(good_run, folder)
    data = report if isinstance(report, bytes) else report.encode()
    (folder / "report.json").write_bytes(data)
    one_clear_line(mmcs("compare", folder, folder), f"{folder}: ")
    one_clear_line(mmcs("trace", folder, "--at", "panic"))


@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
@pytest.mark.parametrize("name", ["report.json", "log.csv", "run.mmcs", "run.mmsnap", ".lock"])
def test_results_that_are_no_files(mmcs, good_run, tmp_path, name, kind):
    """Who waits for the other end of a pipe, or for the end of a device, waits for ever."""
    folder = tmp_path / "run"
    shutil.copytree(good_run, folder)
    (folder / name).unlink(missing_ok=True)
    if kind == "pipe":
        os.mkfifo(folder / name)
    elif kind == "device":
        (folder / name).symlink_to("/dev/zero")
    else:
        (folder / name).mkdir()
    told = {"report.json": ("compare", folder, good_run), "log.csv": ("compare", folder, good_run),
            "run.mmcs": ("replay", folder), "run.mmsnap": ("run", "--from", folder)}  # fmt: skip
    if name != ".lock":
        one_clear_line(mmcs(*told[name]))
    elif kind != "pipe":  # a pipe can be locked like a file
        one_clear_line(mmcs("run", "lab500", "--out", folder), status=1)


def test_log_of_one_endless_line(mmcs, good_run, tmp_path):
    """A log is read by groups of lines; one that does not end is not held to be refused."""
    folder = shutil.copytree(good_run, tmp_path / "run")
    os.truncate(folder / "log.csv", 100 << 20)
    one_clear_line(mmcs("mcap", folder), "log.csv has a line of more than 16 KB")


def test_folder_that_reaches_beyond_itself(mmcs, good_run, tmp_path):
    """What a folder of results says of itself moves nothing elsewhere, and empties nothing."""
    folder, mine = tmp_path / "a" / "run", tmp_path / "a" / "mine"
    shutil.copytree(good_run, folder)
    mine.write_text("mine")
    for text in ('["../../mine"]', '["report.json", "/etc/passwd"]', '{"a": 1}', "[[", "7", '[""]'):
        (folder / ".new").mkdir()
        (folder / ".new" / "whole.json").write_text(text)
        one_clear_line(mmcs("compare", folder, good_run), "was not written by MMCS; it is removed")
        assert mine.read_text() == "mine" and not (folder / ".new").exists()
        assert mmcs("compare", folder, good_run, "--out", tmp_path / "c.svg")[0] == 0
    (folder / ".lock").unlink(missing_ok=True)
    (folder / ".lock").symlink_to(mine)
    one_clear_line(mmcs("run", "lab500", "--out", folder), ".lock: ", status=1)
    assert mine.read_text() == "mine"


# --- the build cache ---------------------------------------------------------------------------


def test_damaged_build_is_made_again(tmp_path, monkeypatch):
    """A library that is not the one that was built is never loaded; half a file is none."""
    library = tmp_path / "sim" / "speed_c1" / "libmmcs_sim.so"
    made = []

    def run(command, env, log=False):
        if "-q" in command:
            return 0 if library.exists() else 1
        if library.exists():
            return 0  # make finds nothing to do
        library.parent.mkdir(parents=True, exist_ok=True)
        library.write_bytes(b"good")
        digest = subprocess.run(["sha256sum"], input=b"good", capture_output=True, check=True)
        Path(f"{library}.sum").write_bytes(digest.stdout)
        made.append(command)
        return 0

    monkeypatch.setattr(build, "BUILD", tmp_path)
    monkeypatch.setattr(build, "LOG", tmp_path / "sim" / "build.log")
    monkeypatch.setattr(build, "_run", run)
    monkeypatch.setattr(build, "_spinner", lambda _: io.StringIO())
    for damage in (None, b"goo", b"gooD", b"", "no sum"):
        if damage == "no sum":
            Path(f"{library}.sum").unlink()
        elif damage is not None:
            library.write_bytes(damage)
        before = len(made)
        assert build.ensure_library(1, "speed") == library and library.read_bytes() == b"good"
        assert len(made) == before + 1
    assert build.ensure_library(1, "speed") == library and len(made) == 5


def test_damaged_preload_library_is_made_again(tmp_path, monkeypatch):
    """Who has it in front of his program would die of it."""
    from mmcs.device import execute

    library = tmp_path / "device" / "libmmcs_preload.so"
    monkeypatch.setattr(execute, "LIBRARY", library)
    good = execute.preload_library().read_bytes()
    for damage in (good[:-1], bytes([good[0] ^ 1]) + good[1:], b""):
        library.write_bytes(damage)
        assert execute.preload_library().read_bytes() == good
    library.with_name(f"{library.name}.sum").unlink()
    assert execute.preload_library().read_bytes() == good
    before = library.stat().st_ino
    execute.preload_library()
    assert library.stat().st_ino == before
    assert sorted(p.name for p in library.parent.iterdir()) == [library.name, f"{library.name}.sum"]
