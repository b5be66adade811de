# SPDX-License-Identifier: Apache-2.0
"""What damaged files are refused with, and what an unusual end is told by (test_output.py)."""

import base64
import itertools
import json
import os
import shutil
import sys
import time
import zlib
from pathlib import Path
from types import SimpleNamespace as Of

import pytest

from mmcs import ROBOTS, files, mcdef, screen, setup_file
from mmcs.runs import record
from mmcs.scenario.load import load_robot
from mmcs.sweeps.campaign_report import wilson
from mmcs.sweeps.twin import Twin
from mmcs.tests.conftest import call
from mmcs.tests.insides import Recorder, inside, told
from mmcs.tool.advisor import Advisor
from mmcs.view import runs, waves


def packed(value) -> str:
    data = value if isinstance(value, bytes) else json.dumps(value).encode()
    return base64.b64encode(zlib.compress(data)).decode()


def a_record(path):
    """A record with one wrong value, its lines cut short, and a run whose files do not fit."""
    call("run", "lab500", "--out", "a", "--set", "duration=0.06")
    whole, robot = record.read_json(path / "a" / "run.mmcs"), {"robot.toml": "x"}
    cut = base64.b64encode(base64.b64decode(whole["files"])[:-9]).decode()
    longest = record.LONGEST_S
    other = [(key, value) for key in (*record.KINDS, "mmcs_run") for value in (None, True, [])] + [
        ("mmcs_run", 0), ("scenario", "a/b"), ("scenario", ""), ("files", "%"), ("files", "QUJD"),
        ("files", cut), ("checkpoints", "QUJD"), ("checkpoints", ""), ("checkpoints", "%"),
        *(("motion_start_s", t) for t in (-1e-9, 0, longest, longest + 1)),
        *(("data", whole["data"] | more) for more in (
            {"duration": 0}, {"duration": longest}, {"duration": longest + 1}, {"robot": "lab500"},
            {"duration": "1"}, {"motion": [{"kind": "table", "axis": 0, "file": "table0.csv"}]})),
        *(("files", packed(files)) for files in (
            [], {}, {"robot.toml": 1}, robot | {"../x": ""}, robot | {"table0.csvx": ""},
            robot | {"card0.sv": "\ud800"}, b"{", robot | {"table0.csv": "1"})),
    ]  # fmt: skip
    for key, value in other:
        found = told(record.parse, path, whole | {key: value})
        yield key, found if isinstance(found, tuple) else sorted(found.files)
    yield [told(record.parse, path, value) for value in ([], {}, None)]
    yield [told(getattr, record.parse(path, whole), name) for name in ("hash", "nothing")]
    log, told_of = (path / "a" / name for name in ("log.csv", "report.json"))
    lines, text = log.read_text().splitlines(keepends=True), json.loads(told_of.read_text())
    free = {key: value for key, value in text.items() if key != "log_crc32"}
    huge = lines[-1].replace(",", ",9e99", 1)
    for data, rows in ((text, lines[:-1]), (free, lines[:1]), (free, lines[:-1]), (free, []),
                       (free | {"axes": text["axes"] * 2}, lines), (free | {"axes": {}}, lines),
                       (free | {"scenario": 1}, lines), ({"axes": []}, lines), ([], lines),
                       (free, [*lines, "1,2\n"]), (free, [*lines, huge]),
                       (text, lines)):  # fmt: skip
        told_of.write_text(json.dumps(data))
        log.write_text("".join(rows))
        found = told(runs.read_run, "a")
        yield found if isinstance(found, tuple) else found.log.shape
    shutil.rmtree(path / "a")
    yield told(runs.read_run, "a")


def a_setup_file(path):
    assert call("compile", "lab500", "-o", "a.bin")[0] == 0
    whole = (path / "a.bin").read_bytes()
    for data in (whole, whole[:-1], whole[:40], b"", b"x" + whole[1:], whole + b"0",
                 whole[:-9] + bytes([whole[-9] ^ 1]) + whole[-8:]):  # fmt: skip
        found = told(setup_file.read, data)
        yield found if isinstance(found, tuple) else sorted(found)
    found = setup_file.read(whole)
    yield len(setup_file.source(found))
    yield told(setup_file.source, found | {"source": found["source"][0:0]})
    (path / "b.bin").write_bytes(whole[:-1])
    asked = ("run b.bin", "check a.bin", "check b.bin", "check a.bin --set nothing=1",
             "check a.bin --set clk_hz=9", "run a.bin --set duration=0.02 --out r",
             "check a.bin --set robot.axis.0.gear=0")  # fmt: skip
    yield [call(*words.split()) for words in asked]
    (path / "c.toml").write_text((ROBOTS / "lab500.toml").read_text() + "x = 1\n")
    yield told(load_robot, str(path / "c.toml"))


def ends(path):
    """(standard files that are closed, what a fault is noticed by, how a page's lease is had)"""
    asked, locale = Recorder(), Recorder("utf-8", "ANSI_X3.4-1968")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fstat", Recorder(0, OSError(), 0))
        patch.setattr(os, "open", lambda *given: asked("open", *given))
        patch.setattr(os, "execv", lambda *given: asked("execv", given[1][1:]))
        patch.setattr(sys, "argv", ["mmcs", "run", "x"])
        patch.setattr(screen.locale, "getpreferredencoding", locale)
        for _ in range(2):
            screen.prepare()
    twin = Of(told={("panic", "goes high")}, start=1.0, refused=1, sim=Of(time=9.0))
    note = lambda kind, text: {"kind": kind, "text": text, "t": 2.5}  # noqa: E731
    code = f"code {mcdef.MERR_PHI | 1:#x}"
    notes = [note("panic", "goes high"), note("panic", "goes low"), note("log", "high"),
             note("error", "code 0x0"), note("error", code), note("panic", "is high")]  # fmt: skip
    seen = [Twin._detected(twin, notes[:n], 0.5, ["a"] * 2) for n in range(7)]
    seen += [Twin._detected(twin, given, 0.5, ["b"]) for given in ([], notes[-1:])]
    for beat, holds in itertools.product((True, False), (True, False)):
        link = Recorder({"clients": [{"client": 3, "lease": holds}, {"client": 4, "lease": True}]})
        link.hello = {"you": 3}
        one = Advisor.__new__(Advisor)
        one.gone, one.heard, one.patience_s = Of(is_set=lambda beat=beat: not beat), 0.0, 5.0
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(time, "monotonic", Recorder(0.0, 1.0, 2.0, 2.0, 2.1))
            patch.setattr(time, "sleep", link)
            seen.append((told(one._wait_for_lease, link), link.calls))
    for answer in (None, OSError()):
        link = Recorder(answer, None)
        Advisor._give_back(one, link, {"lender": "7"})
        seen.append(link.calls)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(waves, "subprocess", Of(Popen=asked, DEVNULL=-3))
        patch.setattr(waves, "echo", asked)
        displays = ("DISPLAY", "WAYLAND_DISPLAY", "")
        for there, display in itertools.product(("gtkwave", "surfer", ""), displays):
            patch.setattr(waves, "shutil", Of(which=lambda name, there=there: name == there))
            patch.setattr(waves, "os", Of(environ={display: "0"}))
            waves.open_viewer(Path("a.fst"))
    (path / "a.json").write_text("[1, 2]")
    for most in (5, 6):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(files, "MAX_JSON", most)
            seen.append(told(files.read_json, path / "a.json"))
    seen += [wilson(*one) for one in ((0, 0), (0, 9), (9, 9), (1, 100), (99, 100))]
    return asked.calls, locale.calls, seen


REFUSALS = {
    "records": inside(lambda path: list(a_record(path))),
    "set-up files": inside(lambda path: list(a_setup_file(path))),
    "unusual ends": inside(ends),
}
