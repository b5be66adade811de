# SPDX-License-Identifier: Apache-2.0
"""Files of results that mean no good, or are damaged: one clear line, and nothing is lost."""

import base64
import contextlib
import hashlib
import io
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import zipfile
import zlib
from pathlib import Path
from types import SimpleNamespace

import pytest

from mmcs.engine import build
from mmcs.errors import RunError
from mmcs.tests.conftest import GOOD, one_clear_line
from mmcs.tests.test_hostile import command
from tools.compiled import ran

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
    from mmcs.runs.record import read_record

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


def rewritten(path, target, sealed=True, **members):
    """sealed: with the checksums of what it then holds."""
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
        data = {name: members.get(name, old.read(name)) for name in old.namelist()}
        data = {
            n: d.encode() if isinstance(d, str) else d for n, d in data.items() if d is not None
        }
        if sealed and "index.json" in data:
            with contextlib.suppress(RecursionError):
                index = json.loads(data["index.json"])
                if isinstance(index, dict):
                    index["sha256"] = {n: hashlib.sha256(d).hexdigest() for n, d in data.items()}
                    data["index.json"] = json.dumps(index).encode()
            new.comment = hashlib.sha256(data["index.json"]).hexdigest().encode()
        else:
            new.comment = old.comment
        for name, one in data.items():
            new.writestr(name, one)
    return target


@pytest.mark.parametrize("name", ["record.json", "index.json", "history.bin", "log.bin",
                                  "truth.bin", "0.bin"])  # fmt: skip
def test_no_byte_of_a_snapshot_can_be_another(mmcs, good_run, tmp_path, name):
    """Figures that were changed never stand beside the hash of a true run."""
    source = good_run / "run.mmsnap"
    data = bytearray(zipfile.ZipFile(source).read(name))
    at = data.index(b"0") if name.endswith("json") else len(data) // 2
    data[at] ^= 1
    rewritten(source, tmp_path / "run.mmsnap", sealed=False, **{name: bytes(data)})
    where = f"{tmp_path}@0" if name == "0.bin" else tmp_path
    one_clear_line(mmcs("run", "--from", where), "not a file of snapshots of MMCS, or damaged")


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
        {"index.json": json.dumps(index | {"pots": []})},
        {"index.json": json.dumps(index | {"pots": {"0": [1]}})},
        {"index.json": None}, {"record.json": b"{}"}, {"log.bin": None},
        {f"{len(index['snapshots']) - 1}.bin": None},
        {"index.json": b"[" + b"[]," * (4 << 20) + b"[]]"},
        {"history.bin": b"\0" * (80 << 20)}, {"log.bin": b"123"}, {"truth.bin": b""},
    ]  # fmt: skip
    for members in bad:
        rewritten(source, target, **members)
        one_clear_line(mmcs("run", "--from", tmp_path), "not a file of snapshots")
    rewritten(source, target, **{f"{len(index['snapshots']) - 1}.bin": b"x" * 500})
    answer = mmcs("run", "--from", tmp_path, "--out", tmp_path / "o")
    one_clear_line(answer, "not a snapshot of MMCS", begun=True)


def test_damaged_snapshots(good_run, tmp_path):
    from mmcs.runs.snapshots import Snapshot

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
    one_clear_line(mmcs("export", "mcap", folder), "log.csv has a line of more than 16 KB")


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
        Path(f"{library}.sum").write_text(ran("sha256sum", input="good", check=True).stdout)
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


def test_build_of_which_files_are_gone_is_made_again(tmp_path, monkeypatch):
    """Stamps alone tell make that all is there."""
    library = tmp_path / "sim" / "speed_c1" / "libmmcs_sim.so"
    stamp = tmp_path / "sim" / "boards" / "boards.stamp"

    def run(command, env, log=False):
        if stamp.exists():
            build.LOG.write_text("parts.cpp:3:23: fatal error: Vx.edges: No such file\n")
            return 2
        library.parent.mkdir(parents=True)
        library.write_bytes(b"good")
        return 0

    stamp.parent.mkdir(parents=True)
    stamp.touch()
    monkeypatch.setattr(build, "BUILD", tmp_path)
    monkeypatch.setattr(build, "LOG", tmp_path / "sim" / "build.log")
    monkeypatch.setattr(build, "_run", run)
    monkeypatch.setattr(build, "_spinner", lambda _: io.StringIO())
    assert build.ensure_library(1, "speed") == library and not stamp.exists()


def test_make_is_told_nothing_of_the_users_own_work(monkeypatch, tmp_path):
    """Nor does it build a model of no boards, as of a list that cannot be read."""
    make = ["make", "-n", "-s", "-f", "sim/Makefile", f"B={tmp_path}"]
    bad = {"PYTHONIOENCODING": "utf-16", "RTL_DIR": "/nonexistent", "MAKEFILES": "/etc/passwd",
           "PYTHON": "/nonexistent"}  # fmt: skip
    for name, value in bad.items():
        monkeypatch.setenv(name, value)
    for env, wrong in (({**os.environ, "MAKEFILES": ""}, True), (build.make_env(), False)):
        done = subprocess.run(make, check=False, cwd=build.ROOT, env=env, text=True, stderr=-1)
        assert (done.returncode != 0) == wrong == ("lists no boards" in done.stderr)


def test_damaged_preload_library_is_made_again(tmp_path, monkeypatch):
    """Who has it in front of his program would die of it."""
    from mmcs.device import libraries

    library = tmp_path / "device" / "libmmcs_preload.so"
    monkeypatch.setattr(libraries, "LIBRARY", library)
    good = libraries.preload_library().read_bytes()
    for damage in (good[:-1], bytes([good[0] ^ 1]) + good[1:], b""):
        library.write_bytes(damage)
        assert libraries.preload_library().read_bytes() == good
    library.with_name(f"{library.name}.sum").unlink()
    assert libraries.preload_library().read_bytes() == good
    before = library.stat().st_ino
    libraries.preload_library()
    assert library.stat().st_ino == before
    assert sorted(p.name for p in library.parent.iterdir()) == [library.name, f"{library.name}.sum"]


def test_waveforms_that_find_no_room_are_told(tmp_path):
    """A limit on the size of files does what a full disk does."""
    path = tmp_path / "short.toml"
    path.write_text(GOOD)
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))  # noqa: E731
    run = ("run", path, "--out", tmp_path / "o", "--trace", tmp_path / "x.fst")
    assert command(*run)[0] == 0  # what has to be built is built
    status, _, err = command(*run, preexec_fn=limit)  # noqa: PLW1509
    assert status == 1 and b"aborted where waveforms are written: if the disk is full" in err
    assert not list(tmp_path.glob("x.*"))  # nothing that is half


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


@pytest.mark.parametrize("args", [("design", "--wn", "50", "--plot", "x.svg"),
                                  ("lab", "start", "1", "x")])  # fmt: skip
def test_a_file_that_finds_no_room_is_not_left_half(tmp_path, args):
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))  # noqa: E731
    run = [sys.executable, "-B", "-m", "mmcs", *args]  # whole files of bytecode, or none
    done = ran(*run, cwd=tmp_path, preexec_fn=limit)
    assert done.returncode in (1, 2) and "File too large" in done.stderr
    assert done.stderr.startswith("mmcs: ") and done.stderr.count("\n") == 1
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


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
