# SPDX-License-Identifier: Apache-2.0
"""Names, files, disks and surroundings that mean no good: one clear line, and nothing is lost."""

import json
import os
import random
import re
import resource
import shutil
import subprocess
import sys

import pytest

from mmcs import ROBOTS, ROOT
from mmcs.errors import InputError
from mmcs.runs.record import read_record
from mmcs.sweeps.store import Store
from mmcs.tests.conftest import GOOD, call, good, one_clear_line
from tools.compiled import ran
from tools.parsers import attack


def test_every_parser_in_python(capsys):
    assert attack(100, seed=7) == 0, capsys.readouterr().out


# --- records, rows ------------------------------------------------------------------


@pytest.fixture(scope="module")
def good_run(tmp_path_factory):
    """A real run of a moment."""
    folder = tmp_path_factory.mktemp("run")
    path = folder / "short.toml"
    path.write_text(GOOD.replace("duration = 0.3", "duration = 0.06"))
    good(call("run", path, "--out", folder / "out"))
    return folder / "out"


def damaged(whole: bytes, chance: random.Random) -> bytes:
    """A byte of it is another, or its end is missing."""
    at = chance.randrange(len(whole))
    if chance.randrange(3):
        return whole[:at] + bytes([chance.randrange(256)]) + whole[at + 1 :]
    return whole[:at]


def test_damaged_record(good_run, tmp_path):
    """A sentence, or the run all the same."""
    whole, chance = (good_run / "run.mmcs").read_bytes(), random.Random(1)
    for n in range(250):
        (tmp_path / "run.mmcs").write_bytes(damaged(whole, chance))
        try:
            read_record(str(tmp_path)).setup()
        except Exception as error:
            assert type(error) is InputError, (n, repr(error))


def test_damaged_rows(tmp_path):
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
    for line in [*bad, lines[3].replace(b"1.5", b"1.4")]:
        (tmp_path / "rows.jsonl").write_bytes(b"".join([*lines[:3], line, *lines[4:], b'{"n": 4']))
        again = Store(tmp_path, "me", True)
        assert sorted(again.rows) == [0, 1, 3, 4], line  # what is damaged is run again
        again.close()
    (tmp_path / "rows.jsonl").write_bytes(b"\xff" + lines[0])
    with pytest.raises(InputError, match="is damaged; leave out --resume"):
        Store(tmp_path, "me", True)


@pytest.mark.parametrize("report", [
    "[]", "[" * 50_000, '{"scenario": 1, "axes": [], "hash": ""}', "nul", "\ud800".encode(
        errors="surrogatepass"), '{"scenario": "x", "axes": [1], "hash": "0x1"}',
])  # fmt: skip
def test_damaged_report(mmcs, good_run, tmp_path, report):
    folder = tmp_path / "run"
    shutil.copytree(good_run, folder)
    data = report if isinstance(report, bytes) else report.encode()
    (folder / "report.json").write_bytes(data)
    for words in (("compare", folder, folder), ("export", "film", folder)):
        one_clear_line(mmcs(*words), start=f"{folder}: ")
    one_clear_line(mmcs("trace", folder, "--at", "panic"))


@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
@pytest.mark.parametrize("name", ["report.json", "log.csv", "run.mmcs", ".lock"])
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
            "run.mmcs": ("replay", folder)}  # fmt: skip
    if name != ".lock":
        one_clear_line(mmcs(*told[name]))
    elif kind != "pipe":  # a pipe can be locked like a file
        one_clear_line(mmcs("run", "lab500", "--out", folder), status=1)


def test_a_lock_that_is_a_link_is_refused(mmcs, tmp_path):
    mine = tmp_path / "mine"
    mine.write_text("mine")
    (tmp_path / ".lock").symlink_to(mine)
    one_clear_line(mmcs("run", "lab500", "--out", tmp_path), ".lock: ", status=1)
    assert mine.read_text() == "mine"


# --- the library of programs, and no room on the disk ------------------------------------------


def test_damaged_preload_library_is_made_again(tmp_path, monkeypatch):
    """Who has it in front of his program would die of it."""
    from mmcs.device import libraries

    library = tmp_path / "device" / "libmmcs_preload.so"
    monkeypatch.setattr(libraries, "LIBRARY", library)
    good = libraries.preload_library().read_bytes()
    library.write_bytes(bytes([good[0] ^ 1]) + good[1:])
    assert libraries.preload_library().read_bytes() == good
    library.with_name(f"{library.name}.sum").unlink()
    assert libraries.preload_library().read_bytes() == good
    before = library.stat().st_ino
    libraries.preload_library()
    assert library.stat().st_ino == before
    assert sorted(p.name for p in library.parent.iterdir()) == [library.name, f"{library.name}.sum"]


@pytest.mark.parametrize(("words", "limit", "told", "left"), [
    pytest.param("run short.toml --out o --trace x.fst", 4096,
                 "aborted where waveforms are written: if the disk is full", "x.*",
                 marks=pytest.mark.slow),
    ("lab start 1 x", 500, "File too large\n", "x*/*"),
    ("sweep short.toml --grid seed=1..3 --workers 1 --out out", 300,
     "mmcs: out/rows.jsonl: File too large\n", "out/*.csv"),
])  # fmt: skip
def test_no_room_is_told_and_nothing_is_left_half(tmp_path, words, limit, told, left):
    """A limit on the size of files does what a full disk does."""
    (tmp_path / "short.toml").write_text(GOOD)
    full = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))  # noqa: E731
    run = [sys.executable, "-B", "-m", "mmcs", *words.split()]  # -B: no half bytecode
    if "--trace" in words:
        assert ran(*run, cwd=tmp_path).returncode == 0  # what has to be built is built
        (tmp_path / "x.fst").unlink()
    done = ran(*run, cwd=tmp_path, preexec_fn=full)
    assert done.returncode in (1, 2) and told in done.stderr, done.stderr
    assert "--trace" in words or done.stderr.count("\n") == 1
    assert not [path for path in tmp_path.glob(left) if path.is_file()]


CLI = [sys.executable, "-m", "mmcs"]


def command(*args, **options):
    done = ran(*CLI, *args, text=False, **options)
    return done.returncode, done.stdout, done.stderr


# --- names -------------------------------------------------------------------------------------

NAMES = ["[red]x[bold]", "[x", "[b]", "\x1b[31mx", "a\rb", "a\nb", ":smile:", b"\xff\xfe".decode(
    errors="surrogateescape"), "ümläut", "x" * 200, "-" + "x", "%s", "{x}"]  # fmt: skip


@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
def test_names_are_text(mmcs, tmp_path, name):
    path = tmp_path / f"{name}.toml"
    path.write_text(GOOD.replace('"a test"', '"[b]a\\u001b[7m :smile:"'))
    for args in (("check", path), ("show", path)):
        out = good(mmcs(*args), silent=True)
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
    out = good(mmcs("show", scenario(GOOD.replace('"lab500"', '"./mine.toml"'))), silent=True)
    assert "[red]\\x1b[31m" in out and "\x1b" not in out


def test_no_way_out_of_the_folder_of_results(mmcs, tmp_path):
    for name in ("...toml", "..toml"):
        path = tmp_path / name
        path.write_text(GOOD)
        one_clear_line(mmcs("run", path), "is no name for results; rename the file")
    one_clear_line(mmcs("run", "lab500", "--out", "/proc"), start="/proc: cannot be written: ")
    assert [p.name for p in tmp_path.iterdir() if p.is_dir()] == []


# --- surroundings ------------------------------------------------------------------------------

ASCII = {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0", "LANG": "C"}


def test_locale_without_unicode(tmp_path):
    (tmp_path / "ü.toml").write_text(GOOD.replace("a test", "ein Tüst"), encoding="utf-8")
    for args in (("list",), ("show", "puma560"), ("check", tmp_path / "ü.toml")):
        status, out, err = command(*args, env=os.environ | ASCII)
        assert (status, err) == (0, b"")
    status, out, err = command("show", tmp_path / "ü.toml", env=os.environ | ASCII)
    assert status == 0 and "ein Tüst" in out.decode()


def test_no_width_and_warnings_that_are_errors(tmp_path, scenario):
    env = os.environ | {"COLUMNS": "0", "PYTHONWARNINGS": "error"}
    status, out, err = command("run", scenario(), "--out", tmp_path / "out", env=env)
    assert (status, err) == (0, b"") and b"shoot" in out


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
