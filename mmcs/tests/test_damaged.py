# SPDX-License-Identifier: Apache-2.0
"""Files of results that are damaged or none, and disks that are full: one clear line, and nothing
is lost."""

import io
import os
import random
import resource
import shutil
import sys
from types import SimpleNamespace

import pytest

from mmcs.engine import build
from mmcs.errors import InputError, RunError
from mmcs.runs.record import read_record
from mmcs.sweeps.store import Store
from mmcs.tests.conftest import GOOD, one_clear_line
from mmcs.tests.test_hostile import command
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
    assert command("run", path, "--out", folder / "out")[0] == 0
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


ABORTS = """
import mmcs, sys
def caught():
    line = next(x for x in open("/proc/self/status") if x.startswith("SigCgt"))
    return int(line.split()[1], 16) >> 5 & 1
seen = [caught()]
with mmcs.machine(mmcs.load(sys.argv[1]), "trace") as sim:
    for name in ("a.fst", "b.fst"):
        sim.trace(name)
        seen.append(caught())
print(*seen, caught())
"""


def test_an_abort_is_ours_while_waveforms_are_written_alone(tmp_path):
    (tmp_path / "short.toml").write_text(GOOD)
    done = ran(sys.executable, "-c", ABORTS, "short.toml", cwd=tmp_path)
    assert done.stdout.split() == ["0", "1", "1", "0"], done.stderr


def test_full_disk_is_told_as_such(tmp_path, monkeypatch):
    """Whatever the tool says that could not write: here Python's reader of a tree that was cut."""
    (tmp_path / "sim").mkdir()
    monkeypatch.setattr(build, "BUILD", tmp_path)
    monkeypatch.setattr(build, "LOG", tmp_path / "sim" / "build.log")
    monkeypatch.setattr(build, "WORK", tmp_path)
    monkeypatch.setattr(build, "_run", lambda *_, **__: 1)
    monkeypatch.setattr(build, "_spinner", lambda _: io.StringIO())
    build.LOG.write_text("json.decoder.JSONDecodeError: Unterminated string\n")
    usage = lambda free: lambda _: SimpleNamespace(free=free)  # noqa: E731
    monkeypatch.setattr(build.shutil, "disk_usage", usage(4096))
    with pytest.raises(RunError, match="no room is left on the disk of .*: free some"):
        build.ensure_library(1, "speed")
    monkeypatch.setattr(build.shutil, "disk_usage", usage(1 << 30))
    with pytest.raises(RunError, match="JSONDecodeError"):
        build.ensure_library(1, "speed")
